//! A recorded live session once more: the endpoints are given what they were given then, under the same or other settings.
//!
//! The motions of both people and all that the network did stay as recorded; what the endpoints make of them is computed anew.
//! Nobody reacts to the force of a replay: it tells force, age, limits and energy of another strategy on this very motion and
//! network, not the motion that it would have led to.
//!
//! | part | job |
//! |---|---|
//! | [`RecordedSite`] | what the endpoint of one site was given, in its order |
//! | [`replay_site`] | one site; the partner's packets as recorded |
//! | [`replay_pair`] | both sites: a packet that arrived has the content that the replayed partner gives it |
//! | [`ReplayedSite`] | forces, ages, accounts and events |
//!
//! With the session's own settings and [`Acted::Recorded`] the recorded forces come out, bit for bit.
//!
//! # Examples
//!
//! One tick of a site that hears one packet of its partner:
//!
//! ```
//! use telespring::rig::replay::{Acted, ForceLimits, RecordedArrival, RecordedSite, RecordedTick, ReplaySettings, replay_site};
//! use telespring::session::{Endpoint, EndpointSettings, Law, LocalTime, Motion, Span};
//!
//! let law = Law { stiffness: 100.0, damping: 0.0 };
//! let settings = |id| EndpointSettings { watchdog: None, ..EndpointSettings::new(id, law, Span(0)) };
//! let (now, at) = (LocalTime(0), |x| Motion { position: [x, 0.0], velocity: [0.0; 2] });
//! let mut partner = Endpoint::new(settings(2))?;
//! partner.handle_measurement(now, at(0.02))?;
//! let datagram = partner.poll_transmit(now).unwrap();
//!
//! let tick = RecordedTick { motion: Some(at(0.0)), answered: Some(now), ..RecordedTick::at(now) };
//! let arrival = RecordedArrival { tick: 0, time: now, datagram };
//! let site = RecordedSite::new(vec![tick], vec![arrival])?;
//! let replay = ReplaySettings { endpoint: settings(1), acted: Acted::Recorded, limits: ForceLimits::NONE };
//! assert_eq!(replay_site(replay, &site)?.ticks[0].wanted, [2.0, 0.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod pair;
mod recorded;
mod site;

pub use crate::session::gate::ForceLimits;
pub use pair::replay_pair;
pub use recorded::{RecordedArrival, RecordedSite, RecordedTick};
pub use site::{Acted, ReplaySettings, ReplayedSite, ReplayedTick, replay_site};
