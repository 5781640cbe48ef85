//! The messages of ROS 2 that are sent, field by field as `geometry_msgs` and `std_msgs` define them.

use serde::{Deserialize, Serialize};

/// `builtin_interfaces/Time`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Seconds since 1970.
    pub sec: i32,
    /// And nanoseconds.
    pub nanosec: u32,
}

impl Time {
    /// From nanoseconds since 1970; `None` outside of what 32 bits of seconds hold.
    pub fn new(nanoseconds: i128) -> Option<Self> {
        let sec = i32::try_from(nanoseconds.div_euclid(1_000_000_000)).ok()?;
        let nanosec = u32::try_from(nanoseconds.rem_euclid(1_000_000_000)).ok()?;
        Some(Self { sec, nanosec })
    }
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// When the tick was.
    pub stamp: Time,
    /// The frame: the axes of the study.
    pub frame_id: String,
}

/// `geometry_msgs/Point` and `geometry_msgs/Vector3`, which have the same fields.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Vector {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z: 0.
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// 0
    pub x: f64,
    /// 0
    pub y: f64,
    /// 0
    pub z: f64,
    /// 1
    pub w: f64,
}

/// `geometry_msgs/Pose`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Where, m.
    pub position: Vector,
    /// No turn.
    pub orientation: Quaternion,
}

/// `geometry_msgs/PoseStamped`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// When, and in which axes.
    pub header: Header,
    /// Where.
    pub pose: Pose,
}

/// `geometry_msgs/Wrench`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// The force, N.
    pub force: Vector,
    /// No torque.
    pub torque: Vector,
}

/// `geometry_msgs/WrenchStamped`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WrenchStamped {
    /// When, and in which axes.
    pub header: Header,
    /// The force.
    pub wrench: Wrench,
}

/// `std_msgs/String`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Text {
    /// The text.
    pub data: String,
}

/// `std_msgs/MultiArrayDimension`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MultiArrayDimension {
    /// What the dimension counts.
    pub label: String,
    /// How many.
    pub size: u32,
    /// How many values it spans.
    pub stride: u32,
}

/// `std_msgs/MultiArrayLayout`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MultiArrayLayout {
    /// The dimensions.
    pub dim: Vec<MultiArrayDimension>,
    /// Values before the first.
    pub data_offset: u32,
}

/// `std_msgs/Float64MultiArray`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Float64MultiArray {
    /// One dimension: the places of a row.
    pub layout: MultiArrayLayout,
    /// The values.
    pub data: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use byteorder::LittleEndian;

    use super::*;

    fn cdr(message: &impl Serialize) -> Vec<u8> {
        let mut bytes = Vec::new();
        cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, message).unwrap();
        bytes
    }

    /// Common Data Representation (OMG, formal/04-03-12, 15.3): each value at a multiple of its size; a string is its length
    /// with the closing zero, then the characters.
    #[test]
    fn ref_a_pose_has_the_bytes_of_the_standard() {
        let header = Header { stamp: Time { sec: 5, nanosec: 6 }, frame_id: "study".into() };
        let position = Vector { x: 0.5, y: -0.25, z: 0.0 };
        let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
        let mut expected = vec![5, 0, 0, 0, 6, 0, 0, 0, 6, 0, 0, 0];
        expected.extend(b"study\0");
        expected.extend([0; 6]); // to the next multiple of 8
        for value in [0.5, -0.25, 0.0, 0.0, 0.0, 0.0, 1.0_f64] {
            expected.extend(value.to_le_bytes());
        }
        assert_eq!(cdr(&PoseStamped { header, pose: Pose { position, orientation } }), expected);
    }

    #[test]
    fn ref_an_array_has_the_bytes_of_the_standard() {
        let layout = MultiArrayLayout {
            dim: vec![MultiArrayDimension { label: "abc".into(), size: 1, stride: 2 }],
            data_offset: 3,
        };
        let mut expected = vec![1, 0, 0, 0, 4, 0, 0, 0];
        expected.extend(b"abc\0");
        expected.extend([1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0]);
        expected.extend([0; 4]); // to the next multiple of 8
        expected.extend(1.5_f64.to_le_bytes());
        assert_eq!(cdr(&Float64MultiArray { layout, data: vec![1.5] }), expected);
    }

    #[test]
    fn law_a_time_has_its_parts() {
        assert_eq!(Time::new(1_500_000_001), Some(Time { sec: 1, nanosec: 500_000_001 }));
        assert_eq!(Time::new(-1), Some(Time { sec: -1, nanosec: 999_999_999 }));
        assert_eq!(Time::new(i128::from(i32::MAX) * 1_000_000_000 + 1_000_000_000), None);
    }
}
