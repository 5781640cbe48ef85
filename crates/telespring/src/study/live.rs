//! One side of a live session of a study.

use super::{Coupling, Study};
use crate::error::{InvalidInput, Result};
use crate::rig::ConnectedMode;
use crate::session::{ClockSettings, EndpointSettings, SideFacts, WatchdogSettings};

impl Study {
    /// The endpoint that moves robot `side`, 1 or 2, of the study in a live session, and in the replay of one: watched, with
    /// the clock of the partner estimated. `session` is drawn anew whenever the program starts.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the study or a value does not do for a live session.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{Endpoint, WatchdogSettings};
    /// use telespring::study::Study;
    ///
    /// let study = Study::from_toml(
    ///     "robot1 = {axes = [\"x\", \"y\"], mass = 1, damping = 5}\n\
    ///      robot2 = {axes = [\"x\", \"y\"], mass = 1, damping = 5}\n\
    ///      coupling.stiffness = 20\n\
    ///      network.delay = 0.05",
    /// )?;
    /// let side = Endpoint::new(study.live_side(1, 0x5eed, WatchdogSettings::default())?)?;
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn live_side(&self, side: u8, session: u64, watchdog: WatchdogSettings) -> Result<EndpointSettings> {
        if !matches!(side, 1 | 2) {
            return Err(InvalidInput::new(
                "side",
                side,
                "1 or 2",
                "Give the robot of the study that this site moves.",
            ));
        }
        let laboratory = self.laboratory_without_traces()?;
        let Coupling { stiffness, damping } = self.coupling()?;
        let coupling = ConnectedMode { stiffness, damping, delay: self.network()?.delay() };
        let facts = SideFacts { session, ..laboratory.side_facts(usize::from(side) - 1, &coupling) };
        Ok(EndpointSettings {
            clock: ClockSettings::estimated(),
            watchdog: Some(watchdog),
            ..laboratory.session.architecture.endpoint_settings(&facts)?
        })
    }
}
