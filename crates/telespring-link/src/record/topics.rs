//! The topics of one site, for a file or for viewers.

use std::sync::Arc;

use foxglove::messages::log::Level;
use foxglove::messages::{FrameTransform, Log, PoseInFrame};
use foxglove::{Channel, Context, PartialMetadata};

use super::messages::{Arrival, Event, Tick, time_of};
use super::scene;
use crate::feed::Item;

/// From one pose to the next, ns: 60 per second.
const POSE_INTERVAL: u64 = 16_666_667;
/// From one frame to the next, ns.
const FRAME_INTERVAL: u64 = 1_000_000_000;

/// Something that is due once per interval of the time of the items.
#[derive(Debug, Default)]
struct Due(u64);

impl Due {
    /// Whether it is due at `time`.
    fn is_now(&mut self, time: u64, interval: u64) -> bool {
        let is_due = time >= self.0;
        if is_due {
            // the grid goes on, or begins anew after a gap
            let next = self.0.saturating_add(interval);
            self.0 = if next > time { next } else { time.saturating_add(interval) };
        }
        is_due
    }
}

/// The topics of one site.
#[derive(Debug)]
pub struct Topics {
    /// The channels close with it.
    _context: Arc<Context>,
    /// The date at which the monotonic clock reads 0, ns since 1970.
    zero: u64,
    site: String,
    tick: Channel<Tick>,
    arrival: Channel<Arrival>,
    event: Channel<Event>,
    log: Channel<Log>,
    /// Of the own handle, of the partner's and of the target.
    poses: [Channel<PoseInFrame>; 3],
    frame: Channel<FrameTransform>,
    pose_due: Due,
    frame_due: Due,
    /// The time of the latest item, ns.
    latest: u64,
}

impl Topics {
    /// The topics of a side, 1 or 2.
    pub fn new(context: &Arc<Context>, side: u8, zero: u64) -> Self {
        let site = format!("site{side}");
        let topic = |name: &str| context.channel_builder(format!("/{site}/{name}"));
        Self {
            _context: Arc::clone(context),
            zero,
            tick: topic("tick").build(),
            arrival: topic("arrival").build(),
            event: topic("event").build(),
            log: topic("log").build(),
            poses: ["handle", "partner", "target"].map(|name| topic(name).build()),
            frame: topic("frame").build(),
            pose_due: Due::default(),
            frame_due: Due::default(),
            latest: 0,
            site,
        }
    }

    /// The date of a time of the monotonic clock, ns since 1970.
    fn date(&self, time: u64) -> PartialMetadata {
        PartialMetadata { log_time: Some(self.zero.saturating_add(time)) }
    }

    /// Publishes an item.
    pub fn publish(&mut self, item: &Item) {
        let time = time_of(item);
        self.latest = self.latest.max(time);
        match item {
            Item::Tick { moment, lateness, duration, overruns } => {
                let tick = Tick::new(moment, *lateness, *duration, *overruns);
                self.tick.log_with_meta(&tick, self.date(time));
                self.show(&tick);
            }
            Item::Arrival(arrival) => self.arrival.log_with_meta(&arrival.into(), self.date(time)),
            Item::Event { happened, .. } => self.tell(&Event::new(time, happened), scene::level(happened)),
        }
    }

    /// Says how many items found no room.
    pub fn miss(&self, count: u64) {
        self.tell(&Event::missed(self.latest, count), Level::Warning);
    }

    fn tell(&self, event: &Event, level: Level) {
        let date = self.date(event.time);
        self.event.log_with_meta(event, date);
        self.log.log_with_meta(&scene::log(event, level, &self.site, self.zero), date);
    }

    /// Shows where the handles and the target are, if that is due.
    fn show(&mut self, tick: &Tick) {
        let date = self.date(tick.time);
        if self.frame_due.is_now(tick.time, FRAME_INTERVAL) {
            self.frame.log_with_meta(&scene::frame(&self.site, self.zero + tick.time), date);
        }
        if self.pose_due.is_now(tick.time, POSE_INTERVAL) {
            for (channel, motion) in self.poses.iter().zip([tick.own, tick.partner_predicted, tick.target]) {
                if let Some(motion) = motion {
                    let pose = scene::pose(motion.position, self.zero + tick.time);
                    channel.log_with_meta(&pose, date);
                }
            }
        }
    }
}

impl Drop for Topics {
    /// Topics of a session that is over are no longer offered to viewers.
    fn drop(&mut self) {
        self.tick.close();
        self.arrival.close();
        self.event.close();
        self.log.close();
        self.poses.iter().for_each(Channel::close);
        self.frame.close();
    }
}
