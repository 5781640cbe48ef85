//! What a strategy holds on the handles over a sample period, which its proof in a sampled loop depends on.

use super::{ConnectedMode, Laboratory};
use crate::error::Result;
use crate::session::architecture::StrategyDesign;
use crate::session::strategy::{StrategyChoice, WaveSettings};

/// The spring and the damper of a strategy, whose force is computed at a measurement and held until the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldCoupling {
    /// The stiffness by which a held force F is worth energy, F²/(2 stiffness), N/m: that of the spring on the handle; of two
    /// layers, that of the saturation.
    pub stiffness: f64,
    /// The strongest damper that the strategy puts on each handle, per robot and axis, N·s/m; 0 for none. A damper between
    /// both handles is none of them.
    pub damping: [[f64; 2]; 2],
}

impl Laboratory {
    /// What the laboratory's strategy holds on both handles in a condition.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) for what the strategy refuses.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::Delay;
    /// use telespring::rig::{ConnectedMode, Laboratory};
    /// use telespring::session::architecture::StrategyDesign;
    ///
    /// let mut laboratory = Laboratory::paper();
    /// laboratory.session.architecture.strategy = StrategyDesign::of_kind("wave-variables").unwrap();
    /// let coupling = ConnectedMode { stiffness: 71.2, damping: 0.0, delay: Delay::each_way(0.084)? };
    /// let held = laboratory.held_coupling(&coupling)?;
    /// assert_eq!((held.stiffness, held.damping), (142.4, [[10.0; 2]; 2]));
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn held_coupling(&self, coupling: &ConnectedMode) -> Result<HeldCoupling> {
        let stiffness = coupling.stiffness;
        let alike = |damping: f64| [[damping; 2]; 2];
        let (stiffness, damping) = match self.session.architecture.strategy {
            StrategyDesign::Spring | StrategyDesign::Guard(_) => (stiffness, alike(0.0)),
            StrategyDesign::InjectedDamping => {
                (stiffness, [self.injected_damping(0, coupling)?, self.injected_damping(1, coupling)?])
            }
            StrategyDesign::WaveVariables(design) => {
                let settings = WaveSettings { stiffness, impedance: design.impedance, filter: design.filter };
                (2.0 * stiffness, alike(settings.damper(self.controller.sample_period)))
            }
            StrategyDesign::TimeDomainPassivity(design) => (stiffness, alike(design.largest_damping)),
            StrategyDesign::TwoLayer(design) => {
                (design.saturation * stiffness, alike(design.largest_damping))
            }
            StrategyDesign::SetPositionModulation(design) => (stiffness, alike(design.damping)),
        };
        Ok(HeldCoupling { stiffness, damping })
    }

    /// The damping that one side, 0 or 1, injects in a condition of the laboratory, per axis, N·s/m; 0 with another strategy.
    fn injected_damping(&self, side: usize, coupling: &ConnectedMode) -> Result<[f64; 2]> {
        let settings = self.session.architecture.rehearsal_settings(&self.side_facts(side, coupling))?;
        Ok(match settings.strategy {
            StrategyChoice::InjectedDamping(strategy) => strategy.damping(),
            _ => [0.0; 2],
        })
    }
}
