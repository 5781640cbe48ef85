//! The network that the verdicts judge, as Python sees it.

use pyo3::prelude::*;
use telespring::Delay;
use telespring::study::{self, AgeSource, Unjudged};

use crate::records::{Value, record, words};

words!(AgeSource {
    Loss = "loss",
    Burst = "burst",
    Blackout = "blackout",
    Rate = "rate",
    RateBelowNeed = "rate below need",
    Trace = "trace",
    Adversary = "adversary",
    Playout = "play-out",
    AdaptivePlayout = "adaptive play-out",
    GapTooShort = "stated gap too short",
});

words!(Unjudged {
    UnreadTrace = "unread trace",
    LyingPeer = "lying peer",
    Predictor = "predictor",
    Strategy = "strategy",
    ActuatorLag = "actuator lag",
});

impl Value for Delay {
    /// A delay of a record as Python reads it: forward and backward, s.
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        [self.forward(), self.backward()].to_python(py)
    }

    /// A delay of a record from Python.
    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let [forward, backward] = <[f64; 2]>::from_python(value)?;
        Delay::new(forward, backward).map_err(|refusal| crate::errors::Failure::from(refusal).into())
    }
}

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
    JudgedNetwork(study::JudgedNetwork) {
        /// Delay, jitter and gap with these ages, and the controllers; the stated ones where nothing bounds the ages.
        network,
        /// Whether both sides wait for jitter and gap of this network, so that its delay is constant.
        has_playout_buffer,
        /// Whether delay, jitter and gap are those that the study states.
        is_as_stated,
        /// The smallest and the largest age of a motion in use at a tick, forward and backward, s. None if nothing
        /// bounds them: only what holds on any network is then proven.
        ages,
        /// Constant delays that the network may keep for long, forward and backward, s: if one is unstable, so is the
        /// dyad.
        lasting,
        /// What the ages come from beside delay, jitter and gap: "loss", "burst", "blackout", "rate", "rate below
        /// need", "trace", "adversary", "play-out", "adaptive play-out", "stated gap too short".
        sources,
        /// What is not judged: "unread trace", "lying peer", "predictor", "strategy", "actuator lag". If there
        /// is any, nothing is proven.
        unjudged,
        /// Whether the force acts a sample period late, since the laboratory has a computing tick that the controller
        /// does not state.
        has_computing_tick,
        /// Whether a predictor runs before the guard: the answer is that of the bare spring without it.
        is_guard_predicted,
    }
}
