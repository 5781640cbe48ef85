//! The node of a side and its topics.

use std::net::IpAddr;

use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile};
use serde::Serialize;

use crate::conversion::{array, header, pose, wrench};
use crate::messages::{Float64MultiArray, PoseStamped, Text, WrenchStamped};
use crate::row::{Pair, Row};

/// What ROS 2 refuses, in words.
#[derive(Debug)]
pub struct Refused(String);

impl std::fmt::Display for Refused {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "ROS 2 refused {}", self.0)
    }
}

impl std::error::Error for Refused {}

fn refused(what: &str) -> impl Fn(&dyn std::fmt::Debug) -> Refused + '_ {
    move |error| Refused(format!("{what}: {error:?}"))
}

/// For what comes at the rate of the rows: the newest counts, and nobody waits.
pub const STREAM: QosProfile =
    QosProfile::publisher_default().reliability_best_effort().history(History::KeepLast { depth: 10 });

/// For the status: who joins later hears the latest.
pub const STATUS: QosProfile = QosProfile::publisher_default()
    .reliability_reliable(WhenFull::DEFAULT)
    .durability(Durability::TransientLocal)
    .history(History::KeepLast { depth: 1 });

/// The node of a side: `/telespring/robot1` or `/telespring/robot2`.
pub struct Side {
    side: u8,
    frame: String,
    handle: Publisher<PoseStamped>,
    partner: Publisher<PoseStamped>,
    target: Publisher<PoseStamped>,
    force: Publisher<WrenchStamped>,
    measured_force: Publisher<WrenchStamped>,
    row: Publisher<Float64MultiArray>,
    status: Publisher<Text>,
    said: Option<String>,
    // after the publishers: they say goodbye first
    _node: Node,
}

impl Side {
    /// The topics of a side in the axes `frame`.
    ///
    /// # Errors
    ///
    /// [`Refused`] if ROS 2 gives no node or topic.
    pub fn new(context: &Context, side: u8, frame: &str) -> Result<Self, Refused> {
        let namespace = format!("/telespring/robot{side}");
        let name = NodeName::new(&namespace, "bridge").map_err(|error| refused("the name")(&error))?;
        let options = NodeOptions::new().enable_rosout(false);
        let mut node = context.new_node(name, options).map_err(|error| refused("the node")(&error))?;
        Ok(Self {
            side,
            frame: frame.to_owned(),
            handle: publisher(&mut node, &namespace, "handle", ["geometry_msgs", "PoseStamped"], STREAM)?,
            partner: publisher(&mut node, &namespace, "partner", ["geometry_msgs", "PoseStamped"], STREAM)?,
            target: publisher(&mut node, &namespace, "target", ["geometry_msgs", "PoseStamped"], STREAM)?,
            force: publisher(&mut node, &namespace, "force", ["geometry_msgs", "WrenchStamped"], STREAM)?,
            measured_force: publisher(
                &mut node,
                &namespace,
                "measured_force",
                ["geometry_msgs", "WrenchStamped"],
                STREAM,
            )?,
            row: publisher(&mut node, &namespace, "telemetry", ["std_msgs", "Float64MultiArray"], STREAM)?,
            status: publisher(&mut node, &namespace, "status", ["std_msgs", "String"], STATUS)?,
            said: None,
            _node: node,
        })
    }

    /// The robot of the study, 1 or 2.
    pub fn side(&self) -> u8 {
        self.side
    }

    /// Publishes what a row says; `offset` is ROS's time less the monotonic clock, ns. What cannot be sent is left out: the
    /// next row is newer.
    pub fn publish(&mut self, row: &Row, offset: i128) {
        let Some(header) = header(row, offset, &self.frame) else { return };
        for (publisher, pair) in
            [(&self.handle, Pair::Handle), (&self.partner, Pair::Partner), (&self.target, Pair::Target)]
        {
            if let Some(message) = pose(row, pair, &header) {
                let _ = publisher.publish(message);
            }
        }
        for (publisher, pair) in [(&self.force, Pair::Force), (&self.measured_force, Pair::MeasuredForce)] {
            if let Some(message) = wrench(row, pair, &header) {
                let _ = publisher.publish(message);
            }
        }
        let _ = self.row.publish(array(row));
        let status = row.status();
        if self.said.as_ref() != Some(&status) && self.status.publish(Text { data: status.clone() }).is_ok() {
            self.said = Some(status);
        }
    }
}

/// A context in a domain of ROS 2, on one network of this machine or on all.
///
/// # Errors
///
/// [`Refused`] if the system gives no socket.
pub fn context(domain: u16, network: Option<IpAddr>) -> Result<Context, Refused> {
    let mut builder = DomainParticipantBuilder::new(domain);
    if let Some(network) = network {
        builder = builder.with_only_networks([network]);
    }
    let participant = builder.build().map_err(|error| refused("the domain")(&error))?;
    Context::from_domain_participant(participant).map_err(|error| refused("the domain")(&error))
}

fn publisher<M: Serialize>(
    node: &mut Node,
    namespace: &str,
    topic: &str,
    [package, kind]: [&str; 2],
    profile: QosProfile,
) -> Result<Publisher<M>, Refused> {
    let name = Name::new(namespace, topic).map_err(|error| refused(topic)(&error))?;
    let topic = node
        .create_topic(&name, MessageTypeName::new(package, kind), &profile)
        .map_err(|error| refused(topic)(&error))?;
    node.create_publisher(&topic, None).map_err(|error| refused("a publisher")(&error))
}
