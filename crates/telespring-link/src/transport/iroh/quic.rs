//! What QUIC is told: datagrams only, none of them old, and no stop because of loss.

use std::any::Any;
use std::sync::Arc;
use std::time::{Duration, Instant};

use iroh::endpoint::{AckFrequencyConfig, Controller, ControllerFactory, QuicTransportConfig, VarInt};
use telespring::session::wire::LENGTH;

/// After this time without anything from the partner a connection is given up.
pub(super) const IDLE: Duration = Duration::from_secs(10);
/// From one sign of life to the next on a path where nothing else is sent.
const KEEP_ALIVE: Duration = Duration::from_millis(500);
/// The round trip that is assumed before it is known; a lost first packet is sent again after three of them.
const FIRST_ROUND_TRIP: Duration = Duration::from_millis(100);

/// Room for what waits to be sent: three packets. An older one is dropped for a newer one.
const SEND_BUFFER: usize = 512;
/// Room for what has come and is not read yet; as above.
const RECEIVE_BUFFER: usize = 16 * 1024;

/// Bytes on their way without an acknowledgement: all that one packet per millisecond makes, with what QUIC adds to it, until
/// the connection is given up.
const WINDOW: u64 = 1000 * IDLE.as_secs() * (LENGTH as u64 + 96);

/// Later packets that were acknowledged, and the time in round trips, after which a packet counts as lost. Nothing is sent
/// again, so there is no hurry, and jitter that lets packets overtake each other must not look like loss.
const REORDERING: (u32, f32) = (64, 2.0);

/// Packets after which the partner is asked for an acknowledgement, instead of after every second one: they tell loss and round
/// trip only, and each is a packet of its own.
const ACKNOWLEDGE: u32 = 10;

/// A window that does not change.
///
/// A packet that is late is worth nothing, so a window that shrinks by loss only makes more loss: the usual controller lost
/// 22 % of the packets where the path lost 2 %. What this side sends is bounded by its loop, one packet per tick, and where
/// the path is too narrow for that the rate is reduced instead (`rate`).
#[derive(Debug, Clone, Copy)]
struct FixedWindow;

impl Controller for FixedWindow {
    fn on_congestion_event(&mut self, _: Instant, _: Instant, _: bool, _: bool, _: u64, _: u64) {}

    fn on_mtu_update(&mut self, _: u16) {}

    fn window(&self) -> u64 {
        WINDOW
    }

    fn clone_box(&self) -> Box<dyn Controller> {
        Box::new(*self)
    }

    fn initial_window(&self) -> u64 {
        WINDOW
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}

impl ControllerFactory for FixedWindow {
    fn build(self: Arc<Self>, _: Instant, _: u16) -> Box<dyn Controller> {
        Box::new(*self)
    }
}

/// The settings of every connection.
pub(super) fn settings() -> QuicTransportConfig {
    let (packets, round_trips) = REORDERING;
    let mut acknowledgements = AckFrequencyConfig::default();
    acknowledgements
        .ack_eliciting_threshold(VarInt::from_u32(ACKNOWLEDGE - 1))
        .reordering_threshold(VarInt::from_u32(packets - 1));
    QuicTransportConfig::builder()
        .congestion_controller_factory(Arc::new(FixedWindow))
        .datagram_send_buffer_size(SEND_BUFFER)
        .datagram_receive_buffer_size(Some(RECEIVE_BUFFER))
        // nothing but datagrams: a stream is refused by QUIC itself
        .max_concurrent_bidi_streams(VarInt::from_u32(0))
        .max_concurrent_uni_streams(VarInt::from_u32(0))
        .stream_receive_window(VarInt::from_u32(1024))
        .receive_window(VarInt::from_u32(1024))
        .send_window(1024)
        .max_idle_timeout(IDLE.try_into().ok())
        .keep_alive_interval(KEEP_ALIVE)
        .default_path_max_idle_timeout(IDLE)
        .default_path_keep_alive_interval(KEEP_ALIVE)
        .ack_frequency_config(Some(acknowledgements))
        .initial_rtt(FIRST_ROUND_TRIP)
        .packet_threshold(packets)
        .time_threshold(round_trips)
        // every packet fits into the smallest one that QUIC allows
        .mtu_discovery_config(None)
        .enable_segmentation_offload(false)
        .build()
}
