//! The connected mode: the coupling of a trial, and what each side of it knows.

use super::Laboratory;
use crate::error::Result;
use crate::model::Delay;
use crate::quantity;
use crate::session::{Endpoint, Law, SideFacts};

/// The connected mode: stiffness, damping and delay of the coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConnectedMode {
    /// The stiffness of the virtual spring, N/m.
    pub stiffness: f64,
    /// The damping in parallel with it, N·s/m.
    pub damping: f64,
    /// The one-way delays from the measurement of a position to its use by the partner.
    pub delay: Delay,
}

impl ConnectedMode {
    /// Checks that stiffness and damping of a trial's connected mode are in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) with the field.
    pub fn check(&self) -> Result<()> {
        quantity::STIFFNESS.check("stiffness", self.stiffness)?;
        quantity::DAMPING.check("coupling_damping", self.damping)?;
        Ok(())
    }
}

impl Laboratory {
    /// What one side of the coupling, 0 or 1, knows in a trial of the laboratory; live, the session id is another.
    pub fn side_facts(&self, side: usize, coupling: &ConnectedMode) -> SideFacts {
        let Self { controller, session, .. } = self;
        let ConnectedMode { stiffness, damping, delay } = *coupling;
        // Robot 2 receives in the forward direction.
        let seen = |[forward, backward]: [f64; 2]| {
            if side == 0 { [backward, forward] } else { [forward, backward] }
        };
        SideFacts {
            session: side as u64 + 1,
            law: Law { stiffness, damping },
            delays: seen([delay.forward(), delay.backward()]),
            lateness: seen(session.lateness),
            missing: seen(session.missing),
            has_playout_buffer: session.has_playout_buffer,
            sample_period: controller.sample_period,
            computing_tick: controller.computing_tick,
            encoder_step: controller.encoder_resolution,
            actuator_lag: controller.actuator_lag,
            least_mass: session.least_mass[side],
            least_damping: [session.least_damping[side], session.least_damping[1 - side]],
        }
    }

    /// Checks that both sides can run the laboratory's architecture in a condition.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) with the setting that is refused.
    pub fn check_session(&self, coupling: &ConnectedMode) -> Result<()> {
        for side in 0..2 {
            let facts = self.side_facts(side, coupling);
            Endpoint::new(self.session.architecture.rehearsal_settings(&facts)?)?;
        }
        Ok(())
    }
}
