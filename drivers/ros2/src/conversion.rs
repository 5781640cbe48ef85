//! From a row to messages.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::messages::{
    Float64MultiArray, Header, MultiArrayDimension, MultiArrayLayout, Pose, PoseStamped, Quaternion, Time,
    Vector, Wrench, WrenchStamped,
};
use crate::row::{COLUMNS, Pair, Row};

/// The time of ROS less the monotonic clock of the machine, ns. ROS's time is the date, which may be set, so it is compared
/// anew for every row.
pub fn offset(monotonic: impl Fn() -> u128) -> Option<i128> {
    let before = monotonic();
    let date = SystemTime::now().duration_since(UNIX_EPOCH).ok()?.as_nanos();
    let after = monotonic();
    let between = before + (after - before) / 2;
    Some(i128::try_from(date).ok()? - i128::try_from(between).ok()?)
}

/// The header of a row, whose time is by the monotonic clock.
pub fn header(row: &Row, offset: i128, frame: &str) -> Option<Header> {
    // from what is a number below 1e9 s
    let nanoseconds = (row.time() * 1e9).round() as i128;
    Some(Header { stamp: Time::new(nanoseconds + offset)?, frame_id: frame.to_owned() })
}

fn vector([x, y]: [f64; 2]) -> Vector {
    Vector { x, y, z: 0.0 }
}

/// A position as a pose without a turn; `None` if it is not known.
pub fn pose(row: &Row, pair: Pair, header: &Header) -> Option<PoseStamped> {
    let position = vector(row.pair(pair)?);
    let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    Some(PoseStamped { header: header.clone(), pose: Pose { position, orientation } })
}

/// A force as a wrench without a torque; `None` if it is not known.
pub fn wrench(row: &Row, pair: Pair, header: &Header) -> Option<WrenchStamped> {
    let force = vector(row.pair(pair)?);
    Some(WrenchStamped { header: header.clone(), wrench: Wrench { force, torque: vector([0.0; 2]) } })
}

/// The whole row; the label of its one dimension names the places.
pub fn array(row: &Row) -> Float64MultiArray {
    let size = COLUMNS.len() as u32;
    let dimension = MultiArrayDimension { label: COLUMNS.join(","), size, stride: size };
    let data = row.0.iter().copied().take(COLUMNS.len()).collect();
    Float64MultiArray { layout: MultiArrayLayout { dim: vec![dimension], data_offset: 0 }, data }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::tests::row;

    #[test]
    fn law_a_row_becomes_poses_and_wrenches() {
        let row = row(&[(7, 0.25), (8, -0.5), (19, 3.0), (20, -4.0), (11, 1.0)]);
        let header = header(&row, 1_000_000_000, "study").unwrap();
        assert_eq!(header.stamp, Time { sec: 11, nanosec: 500_000_000 });
        let handle = pose(&row, Pair::Handle, &header).unwrap();
        assert_eq!(handle.pose.position, Vector { x: 0.25, y: -0.5, z: 0.0 });
        assert_eq!(handle.pose.orientation.w, 1.0);
        assert_eq!(handle.header.frame_id, "study");
        // one of two is not known
        assert_eq!(pose(&row, Pair::Partner, &header), None);
        let force = wrench(&row, Pair::Force, &header).unwrap();
        assert_eq!(force.wrench.force, Vector { x: 3.0, y: -4.0, z: 0.0 });
        assert_eq!(wrench(&row, Pair::MeasuredForce, &header), None);
        let array = array(&row);
        assert_eq!(array.data[7], 0.25);
        assert_eq!(array.layout.dim[0].label.split(',').nth(7), Some("position x"));
    }

    #[test]
    fn law_the_offset_leads_to_the_date() {
        let offset = offset(|| 5).unwrap();
        let date = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i128;
        assert!((0..60_000_000_000).contains(&(date - offset - 5)));
    }
}
