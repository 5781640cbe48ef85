//! The rehearsal of a study: its laboratory and protocol.

use std::sync::Arc;

use super::Study;
use super::emulated_network::TraceFile;
use super::laboratory::{AgentChoice, Setup, Task};
use super::network::SAMPLE_PERIOD;
use super::reader::Reader;
use crate::error::{InvalidInput, Result};
use crate::model::Delay;
use crate::session::Architecture;
use crate::{quantity, rig};

/// The axes of a rehearsal.
const PLANE: [&str; 2] = ["x", "y"];
/// What is refused otherwise.
const NEEDS_AXES: &str =
    "a rehearsal, or a live session, needs robots with exactly the two axes \"x\" and \"y\"";

/// The values of the axes x and y.
fn pair(values: &[f64]) -> [f64; 2] {
    [values[0], values[1]]
}

/// The quantile of the normal distribution at 97.5 %: the ends of a 95 % interval are this many standard deviations away.
pub(super) const QUANTILE: f64 = 1.959_963_984_540_054;

impl Study {
    /// Each robot's Coulomb friction per axis in the rehearsal, N.
    pub fn coulomb(&self) -> [&[f64]; 2] {
        self.robots.each_ref().map(|robot| robot.coulomb.as_slice())
    }

    /// The setup of the rehearsal: arms, agents, task, controllers and network.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Whether the robots have exactly the axes x and y, so that the study can be rehearsed.
    pub fn is_planar(&self) -> bool {
        self.dyad.axis_names() == PLANE
    }

    /// The sample period of the laboratory's controllers, s: from `[laboratory]`, else from `[controller]`,
    /// else 1 ms.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if both sections give different values, or the value of `[controller]` is out of
    /// range for the laboratory.
    pub fn sample_period(&self) -> Result<f64> {
        let of_controller = self.network.sample_period();
        match self.setup.sample_period {
            Some(period) if of_controller > 0.0 && period != of_controller => Err(InvalidInput::new(
                "laboratory.sample_period",
                format!("{period:?}"),
                format!("[controller] gives {of_controller:?} s for the same controllers"),
                "Give it once, or the same value twice.",
            )),
            Some(period) => Ok(period),
            None if of_controller > 0.0 => {
                quantity::SAMPLE_PERIOD.check("controller.sample_period", of_controller)
            }
            None => Ok(SAMPLE_PERIOD),
        }
    }

    /// The virtual laboratory in which this study is rehearsed.
    ///
    /// A Python agent is an [`rig::Agent::External`] in it, a Python target a [`rig::Target::Sampled`]
    /// without samples: the caller supplies forces and positions. Operators are not included, since arms
    /// and agents hold the handles.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the robots have other axes than x and y, the sample period is invalid, or the study
    /// names a recorded trace of the network (see [`Study::laboratory_on`]), with its dotted field.
    ///
    /// # Examples
    ///
    /// ```
    /// let laboratory = telespring::study::Study::paper().laboratory()?;
    /// assert_eq!(laboratory.controller.sample_period, 0.001);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn laboratory(&self) -> Result<rig::Laboratory> {
        self.laboratory_on([None, None])
    }

    /// As [`Study::laboratory`], with the content of the recorded traces that the study names, forward and backward.
    ///
    /// # Errors
    ///
    /// As [`Study::laboratory`], and if a trace is missing or superfluous.
    pub fn laboratory_on(&self, traces: [Option<Arc<rig::Trace>>; 2]) -> Result<rig::Laboratory> {
        let network = self.network_on(traces)?;
        Ok(rig::Laboratory { network, ..self.laboratory_without_traces()? })
    }

    /// As [`Study::laboratory_on`], with the text of the files that the study names; see [`TraceFile::trace`].
    ///
    /// # Errors
    ///
    /// As [`Study::laboratory_on`] and [`TraceFile::trace`].
    pub fn laboratory_on_texts(&self, texts: [Option<&str>; 2]) -> Result<rig::Laboratory> {
        self.laboratory_on(self.recorded_traces(texts)?)
    }

    /// The recorded traces in the text of the files that the study names, forward and backward; see [`TraceFile::trace`].
    ///
    /// # Errors
    ///
    /// As [`TraceFile::trace`].
    pub fn recorded_traces(&self, texts: [Option<&str>; 2]) -> Result<[Option<Arc<rig::Trace>>; 2]> {
        let [forward, backward] = &self.emulated_network.traces;
        let unnamed = TraceFile { path: String::new(), is_round_trip: false };
        let read = |file: &Option<TraceFile>, text: Option<&str>, is_forward: bool| {
            let file = file.as_ref().unwrap_or(&unnamed);
            text.map(|text| file.trace(text, is_forward).map(Arc::new)).transpose()
        };
        Ok([read(forward, texts[0], true)?, read(backward, texts[1], false)?])
    }

    /// The study's laboratory before its recorded traces are read: for a live program, whose network is a real one.
    ///
    /// # Errors
    ///
    /// As [`Study::laboratory`], but for the traces.
    pub fn laboratory_without_traces(&self) -> Result<rig::Laboratory> {
        self.check_planar()?;
        let side = |i: usize| rig::Station {
            handle: rig::Handle {
                mass: pair(self.dyad.robots()[i].mass()),
                damping: pair(self.dyad.robots()[i].damping()),
                coulomb: pair(&self.robots[i].coulomb),
            },
            arm: self.setup.arms[i],
            agent: match self.setup.agents[i] {
                AgentChoice::Skilled { stiffness, damping } => rig::Agent::Skilled { stiffness, damping },
                AgentChoice::Blurred { stiffness, spots } => rig::Agent::Blurred { stiffness, spots },
                AgentChoice::Python(_) => rig::Agent::External,
            },
        };
        Ok(rig::Laboratory {
            stations: [side(0), side(1)],
            target: match self.setup.task {
                Task::FigureEight { amplitude, angular_frequency } => {
                    rig::Target::FigureEight { amplitude, angular_frequency }
                }
                Task::Python(_) => rig::Target::Sampled(Vec::new()),
            },
            controller: rig::Controller {
                sample_period: self.sample_period()?,
                computing_tick: self.setup.computing_tick,
                actuator_lag: self.setup.actuator_lag,
                encoder_resolution: self.setup.encoder_resolution,
            },
            network: self.emulated_network.model.clone(),
            session: self.session_plan(),
        })
    }

    /// What the controllers of the laboratory do, and what they may count on.
    fn session_plan(&self) -> rig::SessionPlan {
        let rig::Network { forward, backward } = &self.emulated_network.model;
        let jitters = [forward.jitter, backward.jitter];
        rig::SessionPlan {
            architecture: self.session,
            least_damping: self.least_damping().each_ref().map(|robot| pair(robot)),
            least_mass: self.least_mass().each_ref().map(|robot| pair(robot)),
            lateness: jitters.map(|jitter| jitter + self.network.max_gap()),
            missing: self.missing(),
            has_playout_buffer: self.has_playout_buffer,
        }
    }

    /// The complete protocol of the rehearsal; missing values follow from robots, task and controllers.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the robots have other axes than x and y, a required reference stiffness does not
    /// exist, or the parts do not match, with its dotted field.
    ///
    /// # Examples
    ///
    /// ```
    /// let protocol = telespring::study::Study::paper().protocol()?;
    /// assert_eq!((protocol.conditions.len(), protocol.trials), (17, 20));
    /// assert_eq!((protocol.duration, protocol.discard), (29.111, 4.852));
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn protocol(&self) -> Result<rig::Protocol> {
        self.check_planar()?;
        self.protocol.resolve(&self.dyad, &self.setup.task, self.sample_period()?)
    }

    /// What the strategy of the study's session holds on the handles over a sample period, in a condition of its rehearsal.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] as [`Study::laboratory`], but not for recorded traces, and for a value that is out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, study::Study};
    ///
    /// let held = Study::paper().held_coupling(71.2, Delay::each_way(0.084)?)?;
    /// assert_eq!((held.stiffness, held.damping), (71.2, [[0.0; 2]; 2]));
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn held_coupling(&self, stiffness: f64, delay: Delay) -> Result<rig::HeldCoupling> {
        quantity::STIFFNESS.check("stiffness", stiffness)?;
        let coupling = rig::ConnectedMode { stiffness, damping: self.dyad.coupling_damping(), delay };
        self.laboratory_without_traces()?.held_coupling(&coupling)
    }

    /// Rejects a rehearsal with robots of other axes than x and y.
    fn check_planar(&self) -> Result<()> {
        if self.is_planar() {
            return Ok(());
        }
        Err(InvalidInput::new(
            "robot1.axes",
            format!("{:?}", self.dyad.axis_names()),
            NEEDS_AXES,
            "Give both robots these axes. docs/your-robot.md says how a robot with one axis takes part.",
        ))
    }

    /// Checks that the study's session can run in every condition; the bare spring always can.
    fn check_session(&self, laboratory: &rig::Laboratory, protocol: &rig::Protocol) -> Result<()> {
        if self.session == Architecture::default() {
            return Ok(());
        }
        for (stiffness, delay) in &protocol.conditions {
            let Some(stiffness) = *stiffness else { continue };
            // `check_dampers` has checked the damper of the coupling, with the strategy's entry in the file
            let coupling = rig::ConnectedMode { stiffness, damping: 0.0, delay: Delay::each_way(*delay)? };
            laboratory.check_session(&coupling).map_err(|refusal| refusal.within("session"))?;
        }
        Ok(())
    }

    /// Checks that the rehearsal is possible if the file has a section for it.
    pub(super) fn check_rehearsal(&self, reader: &Reader<'_>) -> Result<()> {
        let Some(section) = reader.rehearsal_section() else { return Ok(()) };
        if !self.is_planar() {
            return Err(reader.reject_section(
                section,
                format!(
                    "{NEEDS_AXES}, but these have {:?}",
                    self.dyad.axis_names()
                ),
                "Give both robots these axes, or remove the section for a study that is neither rehearsed nor run live. \
                 docs/your-robot.md says how a robot with one axis takes part.",
            ));
        }
        let mut laboratory =
            self.laboratory_without_traces().map_err(|error| reader.with_line_of_field(error))?;
        if matches!(laboratory.target, rig::Target::Sampled(_)) {
            // A Python target has no samples yet; everything else is checked.
            laboratory.target = rig::Target::FigureEight { amplitude: [0.0; 2], angular_frequency: 0.0 };
        }
        laboratory.check().map_err(|error| reader.with_line_of_field(error))?;
        let protocol = self.protocol().map_err(|error| reader.with_line_of_field(error))?;
        self.check_session(&laboratory, &protocol).map_err(|error| reader.with_line_of_field(error))
    }
}
