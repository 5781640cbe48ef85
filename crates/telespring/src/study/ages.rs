//! What the verdicts must judge: the ages of the motion that both sides really use, from a study's network and session.
//!
//! The verdicts know a delay, a jitter and a gap. A study's network may also lose packets, queue them or play a recording,
//! and its session may play the motion at another time than the network delivers it. All of that ends in one thing, the
//! range of the ages in use, and this is the only place that composes it; the verdicts, the sizing of damping injection
//! and every screen take it from here. `way_ages` has the rules of one way, docs/networks.md says them in words.

use std::sync::Arc;

use super::Study;
use super::network::SAMPLE_PERIOD;
use super::way_ages::{WayAges, WayFacts, missing_time};
use crate::error::{InvalidInput, Result};
use crate::model::Delay;
use crate::rig::{Adversary, Trace};
use crate::session::architecture::{PlayoutDesign, PredictorDesign, StrategyDesign};
use crate::verdicts::Network;

/// What made the ages other than delay, jitter and gap state them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum AgeSource {
    /// Packets lost by chance.
    Loss,
    /// Packets lost in bursts.
    Burst,
    /// Times without any packet.
    Blackout,
    /// A link that takes time for each packet.
    Rate,
    /// A link that is slower than the packets come, so that its queue fills.
    RateBelowNeed,
    /// A recorded trace.
    Trace,
    /// An adversary.
    Adversary,
    /// A play-out at an age of its own.
    Playout,
    /// A play-out that follows the network.
    AdaptivePlayout,
    /// The longest gap that the study states is shorter than what the losses make.
    GapTooShort,
}

impl AgeSource {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Loss => "loss",
            Self::Burst => "burst",
            Self::Blackout => "blackout",
            Self::Rate => "rate",
            Self::RateBelowNeed => "rate below need",
            Self::Trace => "trace",
            Self::Adversary => "adversary",
            Self::Playout => "play-out",
            Self::AdaptivePlayout => "adaptive play-out",
            Self::GapTooShort => "stated gap too short",
        }
    }
}

/// The sources met so far, each once.
#[derive(Debug, Default)]
pub(super) struct SourceSet(Vec<AgeSource>);

impl SourceSet {
    /// Notes a source.
    pub fn add(&mut self, source: AgeSource) {
        if !self.0.contains(&source) {
            self.0.push(source);
        }
    }
}

/// What no verdict judges, so that nothing about the study's session is proven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unjudged {
    /// A recorded trace whose content is not given.
    UnreadTrace,
    /// A partner that lies about its motion.
    LyingPeer,
    /// A predictor that changes the loop of the bare spring.
    Predictor,
    /// A strategy that is not the bare spring and not the guard.
    Strategy,
    /// A lag with which the force follows its command.
    ActuatorLag,
}

impl Unjudged {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::UnreadTrace => "unread trace",
            Self::LyingPeer => "lying peer",
            Self::Predictor => "predictor",
            Self::Strategy => "strategy",
            Self::ActuatorLag => "actuator lag",
        }
    }
}

/// The network that the verdicts judge in place of the one that a study states.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedNetwork {
    /// Delay, jitter and gap with the ages in use, and the controllers. Without a bound those that are stated.
    pub network: Network,
    /// Whether both sides wait for jitter and gap of this network, so that its delay is constant.
    pub has_playout_buffer: bool,
    /// Whether delay, jitter and gap are those that the study states.
    pub is_as_stated: bool,
    /// The smallest and the largest age of a motion in use at a tick, forward and backward, s; `None` if nothing bounds them,
    /// or they are not known. Then only what holds on any network is proven.
    pub ages: Option<[[f64; 2]; 2]>,
    /// Constant delays that the network may keep for long, s: if one is unstable, so is the dyad.
    pub lasting: Vec<Delay>,
    /// What the ages come from beside what is stated.
    pub sources: Vec<AgeSource>,
    /// What is not judged; if there is any, nothing is proven.
    pub unjudged: Vec<Unjudged>,
    /// Whether the force acts a sample period late because the laboratory computes so long: more than is stated.
    pub has_computing_tick: bool,
    /// Whether the session has the guard with a predictor: the answer is that of the bare spring without it.
    pub is_guard_predicted: bool,
}

impl Study {
    /// The network that the verdicts judge: the ages that both sides really use, from the study's network and session.
    ///
    /// `delay` replaces the delay of the network, and `traces` are the recorded traces that the study names, forward and
    /// backward. Without them nothing is proven.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if there is no delay, or a trace is given that the study does not name.
    ///
    /// # Examples
    ///
    /// Six packets in a row are lost so rarely that a longer row does not count:
    ///
    /// ```
    /// use telespring::study::Study;
    /// let robots = "robot1 = {mass = 1, damping = 5}\nrobot2 = {mass = 1, damping = 5}\n";
    /// let study = Study::from_toml(&format!("{robots}network = {{delay = 0.05, loss = 0.01}}"))?;
    /// let judged = study.judged_network(None, [None, None])?;
    /// assert_eq!(judged.ages, Some([[0.049, 0.057]; 2]));
    /// assert_eq!(judged.sources[0].word(), "loss");
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn judged_network(
        &self,
        delay: Option<Delay>,
        traces: [Option<Arc<Trace>>; 2],
    ) -> Result<JudgedNetwork> {
        let delay = match delay {
            None => self.network()?.delay(),
            Some(delay) => delay,
        };
        // Of continuous controllers the laboratory says how they are rehearsed.
        let period = match (self.network.sample_period(), self.setup.sample_period) {
            (0.0, Some(sampled)) => sampled,
            (stated, _) => stated,
        };
        let has_computing_tick = self.setup.computing_tick && self.network.computing_time() < period;
        let computing = if has_computing_tick { period } else { self.network.computing_time() };
        let (jitters, max_gap) = (self.network.jitters(), self.network.max_gap());
        let stated = Network::with_jitters(delay, jitters, max_gap, period, computing)?;
        let traces = self.one_way(traces)?;
        let mut sources = SourceSet::default();
        let mut unjudged = self.unjudged_session();
        let models = [&self.emulated_network.model.forward, &self.emulated_network.model.backward];
        let delays = [stated.delay().forward(), stated.delay().backward()];
        let named = self.emulated_network.traces.each_ref().map(Option::is_some);
        if (0..2).any(|way| named[way] && traces[way].is_none()) {
            unjudged.push(Unjudged::UnreadTrace);
        }
        if models.iter().any(|model| matches!(model.adversary, Some(Adversary::LyingPeer { .. }))) {
            unjudged.push(Unjudged::LyingPeer);
        }
        let ways = [0, 1].map(|way| {
            WayFacts {
                delay: delays[way],
                jitter: stated.jitters()[way],
                max_gap: stated.max_gap(),
                period: self.packet_period(),
                model: models[way],
                trace: traces[way].as_deref(),
                has_playout_buffer: self.has_playout_buffer,
                playout: self.session.playout,
            }
            .ages(&mut sources)
        });
        let mut judged = self.with_ages(&stated, ways)?;
        if unjudged.contains(&Unjudged::UnreadTrace) {
            judged = JudgedNetwork { ages: None, is_as_stated: false, has_playout_buffer: false, ..judged };
        }
        sources.0.sort_unstable();
        (judged.sources, judged.unjudged) = (sources.0, unjudged);
        judged.has_computing_tick = has_computing_tick;
        judged.is_guard_predicted = matches!(self.session.strategy, StrategyDesign::Guard(_))
            && self.session.predictor != PredictorDesign::Hold;
        Ok(judged)
    }

    /// The stated network, or the same controllers over one with these ages.
    fn with_ages(&self, stated: &Network, ways: [WayAges; 2]) -> Result<JudgedNetwork> {
        let [first, latest] = [stated.delay(), {
            let [forward, backward] = stated.jitters();
            Delay::new(stated.delay().forward() + forward, stated.delay().backward() + backward)?
        }];
        let as_stated = JudgedNetwork {
            network: *stated,
            has_playout_buffer: self.has_playout_buffer,
            is_as_stated: true,
            ages: None,
            lasting: vec![first, latest],
            sources: Vec::new(),
            unjudged: Vec::new(),
            has_computing_tick: false,
            is_guard_predicted: false,
        };
        if ways.contains(&WayAges::Unbounded) {
            return Ok(JudgedNetwork { has_playout_buffer: false, is_as_stated: false, ..as_stated });
        }
        let stated_ages = [0, 1].map(|way| {
            let greatest = stated.buffered()[way];
            let least = [stated.delay().forward(), stated.delay().backward()][way];
            [if self.has_playout_buffer { greatest } else { least }, greatest]
        });
        if ways == [WayAges::Stated; 2] {
            return Ok(JudgedNetwork { ages: Some(stated_ages), ..as_stated });
        }
        let ages = [0, 1].map(|way| match ways[way] {
            WayAges::Within { least, greatest, .. } => [least, greatest].map(to_nanoseconds),
            _ => stated_ages[way],
        });
        let lasting = [0, 1].map(|way| match ways[way] {
            WayAges::Within { lasting, .. } => lasting,
            _ => Some(stated_ages[way]),
        });
        let lasting = match lasting {
            [Some(forward), Some(backward)] => {
                vec![Delay::new(forward[0], backward[0])?, Delay::new(forward[1], backward[1])?]
            }
            _ => Vec::new(),
        };
        let [forward, backward] = ages;
        let network = Network::with_jitters(
            Delay::new(forward[0], backward[0])?,
            [forward[1] - forward[0], backward[1] - backward[0]].map(to_nanoseconds),
            0.0,
            stated.sample_period(),
            stated.computing_time(),
        )?;
        Ok(JudgedNetwork {
            network,
            has_playout_buffer: false,
            is_as_stated: false,
            ages: Some(ages),
            lasting,
            ..as_stated
        })
    }

    /// How much older than delay, jitter and gap a motion may become because packets are lost or wait, forward and backward,
    /// s; 0 where nothing bounds it.
    pub(super) fn missing(&self) -> [f64; 2] {
        let models = [&self.emulated_network.model.forward, &self.emulated_network.model.backward];
        models.map(|model| missing_time(model, self.packet_period()).unwrap_or(0.0))
    }

    /// The time between two packets of the study's session, s; a continuous controller sends as its laboratory does.
    fn packet_period(&self) -> f64 {
        let own = self.network.sample_period();
        if own > 0.0 { own } else { self.setup.sample_period.unwrap_or(SAMPLE_PERIOD) }
    }

    /// What of the study's session no verdict judges.
    fn unjudged_session(&self) -> Vec<Unjudged> {
        let is_neutral =
            matches!(self.session.predictor, PredictorDesign::Hold | PredictorDesign::SharedTarget);
        let session = match self.session.strategy {
            StrategyDesign::Spring if is_neutral => None,
            StrategyDesign::Spring => Some(Unjudged::Predictor),
            StrategyDesign::Guard(_) => None,
            _ => Some(Unjudged::Strategy),
        };
        let lag = (self.setup.actuator_lag > 0.0).then_some(Unjudged::ActuatorLag);
        session.into_iter().chain(lag).collect()
    }

    /// Refuses a promise of a playout buffer that the study's own play-out breaks.
    pub(super) fn check_buffer(&self) -> Result<()> {
        if !self.has_playout_buffer {
            return Ok(());
        }
        let needed = self.network.buffered();
        let needed = needed[0].max(needed[1]);
        let (value, allowed) = match self.session.playout {
            PlayoutDesign::Adaptive(_) => (
                "true".to_owned(),
                "the play-out of [session] is adaptive, and its delay is not constant".to_owned(),
            ),
            PlayoutDesign::Fixed { delay: Some(delay) } if self.has_delay && delay < needed - 1e-9 => (
                "true".to_owned(),
                format!(
                    "the play-out of [session] waits {delay:?} s, but the latest sample is {needed:?} s old \
                     (delay, jitter and gap)"
                ),
            ),
            PlayoutDesign::Fixed { .. } => return Ok(()),
        };
        let remedy =
            "Leave network.playout_buffer out, or leave out session.playout, which then waits that long.";
        Err(InvalidInput::new("network.playout_buffer", value, allowed, remedy))
    }
}

/// A time without the digits that computing has added, s.
fn to_nanoseconds(time: f64) -> f64 {
    (time * 1e9).round() / 1e9
}
