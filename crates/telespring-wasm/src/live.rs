//! Two robots under way on one axis: once coupled by the bare spring, and beside it by the guard.
//!
//! Both couplings are those of the virtual laboratory and of the live program: sessions that exchange packets over the
//! study's network. What holds the handles in the study holds them here, and a hand may pull robot 1.

use std::collections::BTreeMap;

use telespring::rig::{
    Agent, Arm, ConnectedMode, Laboratory, Observation, Row, RunningTrial, Status, Target,
};
use telespring::session::Architecture;
use telespring::session::architecture::{PredictorDesign, StrategyDesign};
use telespring::study::{Replacement, Study, Value};
use telespring::{InvalidInput, Result};

/// Beyond this place (m) a robot leaves the page, and its run ends.
const LIMIT: f64 = 5.0;

/// One run: two robots, their coupling, and whether it has ended.
struct Run {
    trial: RunningTrial,
    force: Row,
    has_ended: bool,
}

/// Two runs side by side, moved by the same hand.
pub struct Live {
    runs: [Run; 2],
    /// The stiffness of what holds each handle, N/m.
    ground: [f64; 2],
    period: f64,
}

impl Live {
    /// The numbers of a state: the time (s), then of spring and guard the places of robots 1 and 2 (m), the forces on them
    /// (N), the account of robot 1 (J, NaN without one), and 1 once the run has ended.
    pub const STATE: usize = 13;

    /// Both runs at rest at 0, on one axis of a study.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if there is no such axis, stiffness or delay, or the guard cannot run with the study's values.
    pub fn start(study: &Study, axis: usize, seed: u64) -> Result<Self> {
        let own = study.dyad().axis(axis)?;
        let coupling = study.coupling()?;
        let delay = study.network()?.delay();
        let guard = match study.session().strategy {
            StrategyDesign::Guard(design) => StrategyDesign::Guard(design),
            _ => StrategyDesign::of_kind("guard").unwrap_or_default(),
        };
        let mode = ConnectedMode { stiffness: coupling.stiffness, damping: coupling.damping, delay };
        let base = laboratory(study, axis)?;
        let run = |strategy: StrategyDesign| -> Result<Run> {
            let mut laboratory = base.clone();
            let playout = study.session().playout;
            laboratory.session.architecture =
                Architecture { strategy, predictor: PredictorDesign::Hold, playout };
            laboratory.check()?;
            let trial = RunningTrial::start(&laboratory, Some(mode), seed)?;
            Ok(Run { trial, force: Row::default(), has_ended: false })
        };
        Ok(Self {
            runs: [run(StrategyDesign::Spring)?, run(guard)?],
            ground: own.sides.map(|side| side.ground_stiffness),
            period: base.controller.sample_period,
        })
    }

    /// The sample period of both controllers, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Moves both runs by one sample period, while a hand pulls robot 1 towards a place (m) with `grip` (N/m, 0 for none).
    pub fn tick(&mut self, place: f64, grip: f64) {
        let [ground1, ground2] = self.ground;
        for run in self.runs.iter_mut().filter(|run| !run.has_ended) {
            let mut one = |seen: &Observation| -> Result<[f64; 2]> {
                let x = seen.position[0];
                Ok([grip * (place - x) - ground1 * x, 0.0])
            };
            let mut two = |seen: &Observation| -> Result<[f64; 2]> { Ok([-ground2 * seen.position[0], 0.0]) };
            match run.trial.tick(&mut [Some(&mut one), Some(&mut two)]) {
                Ok(Ok(force)) => run.force = force,
                Ok(Err(Status::Completed)) => {}
                _ => run.has_ended = true,
            }
            let far = run.trial.position().iter().any(|place| !(place[0].abs() <= LIMIT));
            run.has_ended |= far;
        }
    }

    /// Where both runs are: [`Live::STATE`] numbers.
    pub fn state(&self) -> [f64; Self::STATE] {
        let mut state = [0.0; Self::STATE];
        let time = self.runs.iter().map(|run| run.trial.time()).fold(0.0, f64::max);
        let values = self.runs.iter().flat_map(|run| {
            let [[x1, _], [x2, _]] = run.trial.position();
            let [[f1, _], [f2, _]] = run.force;
            [x1, x2, f1, f2, run.trial.account()[0], f64::from(u8::from(run.has_ended))]
        });
        for (slot, value) in state.iter_mut().zip(std::iter::once(time).chain(values)) {
            *slot = value;
        }
        state
    }
}

/// The study's laboratory with one axis of its robots on both axes, held as the study holds them by hands of the caller.
fn laboratory(study: &Study, axis: usize) -> Result<Laboratory> {
    let own = study.dyad().axis(axis)?;
    let robots = study.dyad().robots();
    let keys = |pairs: Vec<(&str, Value)>| {
        Replacement::Keys(pairs.into_iter().map(|(key, value)| (key.to_owned(), Some(value))).collect())
    };
    let mut sections: BTreeMap<String, Replacement> = BTreeMap::new();
    for section in
        ["arm1", "arm2", "agent1", "agent2", "operator1", "operator2", "task", "protocol", "comparison"]
    {
        sections.insert(section.to_owned(), Replacement::Default);
    }
    for (side, robot) in robots.iter().enumerate() {
        let name = format!("robot{}", side + 1);
        let mut values = keys(vec![
            ("axes", Value::from(vec!["x", "y"])),
            ("mass", Value::from(robot.mass()[axis])),
            ("damping", Value::from(robot.damping()[axis])),
            ("coulomb", Value::from(study.coulomb()[side][axis])),
        ]);
        if let Replacement::Keys(keys) = &mut values {
            for key in ["ground_stiffness", "mass_sd", "damping_sd", "mass_damping_correlation"] {
                keys.insert(key.to_owned(), None);
            }
        }
        sections.insert(name, values);
    }
    let planar = study.replace(&sections)?;
    let mut laboratory = planar.laboratory_without_traces()?;
    for (side, station) in laboratory.stations.iter_mut().enumerate() {
        let held = own.sides.get(side).copied().unwrap_or(own.sides[0]);
        let (mass, damping) =
            (held.mass - robots[side].mass()[axis], held.damping - robots[side].damping()[axis]);
        station.arm = Arm::Lumped { mass: [mass.max(0.0); 2], damping: [damping.max(0.0); 2] };
        station.agent = Agent::External;
    }
    laboratory.target = Target::FigureEight { amplitude: [0.0; 2], angular_frequency: 0.0 };
    laboratory.controller.computing_tick |= study.network()?.computing_time() > 0.0;
    if laboratory.controller.sample_period > 0.0 { Ok(laboratory) } else { Err(no_period()) }
}

/// Live controllers sample.
fn no_period() -> InvalidInput {
    InvalidInput::new(
        "controller.sample_period",
        "0",
        "controllers that run sample",
        "Give a sample period, such as 0.001.",
    )
}
