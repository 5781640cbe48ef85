//! The program as people start it, and a subscriber of ROS 2 beside it.

use std::net::UdpSocket;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use ros2_client::{Context, MessageTypeName, Name, Node, NodeName, NodeOptions, QosProfile, Subscription};
use serde::de::DeserializeOwned;
use telespring_ros2::messages::{Float64MultiArray, PoseStamped, Text, WrenchStamped};
use telespring_ros2::node::{STATUS, STREAM, context};
use telespring_ros2::row::{COLUMNS, Row, VALUES};

/// How long the two may take to find each other.
const PATIENCE: Duration = Duration::from_secs(60);

/// Ends with the test.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn row(sequence: u32) -> Vec<u8> {
    let mut values = [f64::NAN; VALUES];
    let uptime = std::fs::read_to_string("/proc/uptime").unwrap();
    let uptime: f64 = uptime.split(' ').next().unwrap().parse().unwrap();
    for (place, value) in [
        (0, 1.0),
        (1, f64::from(sequence)),
        (2, 2.0),
        (3, uptime),
        (4, 1.0),
        (5, 2.0),
        (7, 0.25),
        (8, -0.5),
        (11, 0.125),
        (12, 0.5),
        (19, 3.0),
        (20, -4.0),
    ] {
        values[place] = value;
    }
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn subscribe<M: DeserializeOwned + 'static>(
    node: &mut Node,
    topic: &str,
    [package, kind]: [&str; 2],
    profile: QosProfile,
) -> Subscription<M> {
    let name = Name::new("/telespring/robot2", topic).unwrap();
    let topic = node.create_topic(&name, MessageTypeName::new(package, kind), &profile).unwrap();
    node.create_subscription(&topic, Some(profile)).unwrap()
}

#[test]
fn cross_a_subscriber_hears_what_the_rows_say() {
    // a domain that nobody else is likely to be in
    let domain = 100 + u16::try_from(std::process::id() % 100).unwrap();
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let listen = format!("127.0.0.1:{port}");
    let mut program = Program(
        Command::new(env!("CARGO_BIN_EXE_telespring-ros2"))
            .args(["--listen", &listen, "--domain", &domain.to_string(), "--network", "127.0.0.1"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let context: Context = context(domain, Some("127.0.0.1".parse().unwrap())).unwrap();
    let name = NodeName::new("/telespring", "reader").unwrap();
    let mut node = context.new_node(name, NodeOptions::new().enable_rosout(false)).unwrap();
    let handle = subscribe::<PoseStamped>(&mut node, "handle", ["geometry_msgs", "PoseStamped"], STREAM);
    let force = subscribe::<WrenchStamped>(&mut node, "force", ["geometry_msgs", "WrenchStamped"], STREAM);
    let array =
        subscribe::<Float64MultiArray>(&mut node, "telemetry", ["std_msgs", "Float64MultiArray"], STREAM);
    let status = subscribe::<Text>(&mut node, "status", ["std_msgs", "String"], STATUS);
    let target = subscribe::<PoseStamped>(&mut node, "target", ["geometry_msgs", "PoseStamped"], STREAM);

    let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
    let (mut pose, mut wrench, mut values, mut text) = (None, None, None, None);
    let start = Instant::now();
    let mut sequence = 0;
    while (pose.is_none() || wrench.is_none() || values.is_none() || text.is_none())
        && start.elapsed() < PATIENCE
    {
        assert_eq!(program.0.try_wait().unwrap(), None, "the program has ended");
        sequence += 1;
        let _ = sender.send_to(b"no row", &listen);
        let _ = sender.send_to(&row(sequence), &listen);
        std::thread::sleep(Duration::from_millis(10));
        pose = pose.or(handle.take().unwrap());
        wrench = wrench.or(force.take().unwrap());
        values = values.or(array.take().unwrap());
        text = text.or(status.take().unwrap());
    }
    let (pose, _) = pose.expect("no pose came");
    assert_eq!([pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w], [0.25, -0.5, 1.0]);
    assert_eq!(pose.header.frame_id, "telespring");
    let date = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs_f64();
    // the row's time is that since the machine's start
    assert!((date - f64::from(pose.header.stamp.sec)).abs() < 300.0, "{date} {pose:?}");
    let (wrench, _) = wrench.expect("no wrench came");
    assert_eq!([wrench.wrench.force.x, wrench.wrench.force.y], [3.0, -4.0]);
    let (values, _) = values.expect("no array came");
    assert_eq!((values.data.len(), values.data[7]), (COLUMNS.len(), 0.25));
    assert!(values.data[15].is_nan());
    assert_eq!(text.expect("no status came").0.data, Row::decode(&row(1)).unwrap().status());
    // there is no target
    assert!(target.take().unwrap().is_none());

    let pid = program.0.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    assert!(program.0.wait().unwrap().success());
}

#[test]
fn law_a_port_that_somebody_has_is_refused() {
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let listen = taken.local_addr().unwrap().to_string();
    let output =
        Command::new(env!("CARGO_BIN_EXE_telespring-ros2")).args(["--listen", &listen]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8(output.stderr).unwrap().contains(&listen));
}
