//! The network that the verdicts judge, as Python sees it.

use pyo3::prelude::*;
use telespring::study;

use crate::records::record;

record! {
    /// The network that the verdicts judge in place of the one that a study states: the ages of the motion that both
    /// sides really use. `Study.judged_network` composes it.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> judged = ts.Study.paper().replace(network={"delay": 0.05, "loss": 0.01}).judged_network()
    /// >>> judged.ages, judged.sources
    /// (((0.049, 0.057), (0.049, 0.057)), ('loss',))
    JudgedNetwork {
        /// Delay, jitter and gap with these ages, and the controllers; the stated ones where nothing bounds the ages.
        network: telespring::verdicts::Network,
        /// Whether both sides wait for jitter and gap of this network, so that its delay is constant.
        has_playout_buffer: bool,
        /// Whether delay, jitter and gap are those that the study states.
        is_as_stated: bool,
        /// The smallest and the largest age of a motion in use at a tick, forward and backward, s. None if nothing
        /// bounds them: only what holds on any network is then proven.
        ages: Option<[[f64; 2]; 2]>,
        /// Constant delays that the network may keep for long, forward and backward, s: if one is unstable, so is the
        /// dyad.
        lasting: Vec<[f64; 2]>,
        /// What the ages come from beside delay, jitter and gap: "loss", "burst", "blackout", "rate", "rate below
        /// need", "trace", "adversary", "play-out", "adaptive play-out", "stated gap too short".
        sources: Vec<String>,
        /// What is not judged: "unread trace", "lying peer", "predictor", "strategy", "actuator lag". If there
        /// is any, nothing is proven.
        unjudged: Vec<String>,
        /// Whether the force acts a sample period late, since the laboratory has a computing tick that the controller
        /// does not state.
        has_computing_tick: bool,
        /// Whether a predictor runs before the guard: the answer is that of the bare spring without it.
        is_guard_predicted: bool,
    }
}

impl From<study::JudgedNetwork> for JudgedNetwork {
    /// The Python record of a judged network.
    fn from(judged: study::JudgedNetwork) -> Self {
        Self {
            network: judged.network,
            has_playout_buffer: judged.has_playout_buffer,
            is_as_stated: judged.is_as_stated,
            ages: judged.ages,
            lasting: judged.lasting.iter().map(|delay| [delay.forward(), delay.backward()]).collect(),
            sources: judged.sources.iter().map(|source| source.word().to_owned()).collect(),
            unjudged: judged.unjudged.iter().map(|each| each.word().to_owned()).collect(),
            has_computing_tick: judged.has_computing_tick,
            is_guard_predicted: judged.is_guard_predicted,
        }
    }
}
