//! How far an account can be overdrawn.

use super::AccountSettings;
use crate::error::{InvalidInput, Result};
use crate::quantity;

/// How far an account can be overdrawn: energy that a robot gives out without having it.
///
/// A force acts on after the motion that it was computed from. Over this time T_a, a spring that holds just the energy of its
/// force can give out ½ k (vT_a)² too much at speeds up to v. Where m is the least mass of the robot, that is the share
/// `ratio` = k T_a²/m of its kinetic energy at the same speed, and no energy exceeds 1/(1 − `ratio`) times what was there.
/// `docs/guard.md` has the proof.
///
/// # Examples
///
/// 2000 N/m at 100 Hz with a computing tick prove nothing, at 1 kHz they do:
///
/// ```
/// use telespring::session::AccountSettings;
///
/// let slow = AccountSettings {
///     sample_period: 0.01,
///     computing_tick: true,
///     ..AccountSettings::new(2000.0, [7.7, 10.1])
/// };
/// let overdraft = slow.overdraft(0.8334)?;
/// assert!((overdraft.ratio - 2000.0 * 0.02 * 0.02 / 0.8334).abs() < 1e-12);
/// assert!(!overdraft.is_proven() && overdraft.largest_energy(0.05).is_infinite());
/// assert!((overdraft.proven_stiffness - 0.1 * 0.8334 / 4e-4).abs() < 1e-9);
///
/// let fast = AccountSettings { sample_period: 0.001, ..slow }.overdraft(0.8334)?;
/// assert!(fast.is_proven() && fast.largest_energy(0.05) < 0.0506);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overdraft {
    /// The largest overdraft as a share of the robot's kinetic energy at the same speed.
    pub ratio: f64,
    /// What the steps of the encoder alone can overdraw, J; it does not add up.
    pub hidden: f64,
    /// The largest stiffness for which the guard is proven with these settings, N/m.
    pub proven_stiffness: f64,
}

impl Overdraft {
    /// Above this ratio the guard counts as not proven.
    ///
    /// At 0.1 a hand gets at most 11 % more energy than there was. That is about as well as mass and damping are known on
    /// which the account rests, and such a spring swings the robot with 20 reaction times per period, as many samples as
    /// digital control asks for (Franklin, Powell and Workman, Digital Control of Dynamic Systems, 1998, ch. 11: 20 to 40).
    pub const LARGEST_PROVEN_RATIO: f64 = 0.1;

    /// Whether the guard is proven.
    pub fn is_proven(&self) -> bool {
        self.ratio <= Self::LARGEST_PROVEN_RATIO
    }

    /// The most energy that the robot can have where at most this much was there, J; infinite from a ratio of 1 on.
    ///
    /// E ≤ available + (√(`ratio` E) + √`hidden`)², solved for E.
    pub fn largest_energy(&self, available: f64) -> f64 {
        let Self { ratio, hidden, .. } = *self;
        if ratio >= 1.0 {
            return f64::INFINITY;
        }
        let root = (ratio * hidden).sqrt() + (hidden + (1.0 - ratio) * available.max(0.0)).sqrt();
        (root / (1.0 - ratio)).powi(2)
    }
}

impl AccountSettings {
    /// For how many sample periods a force acts after the motion that it was computed from, on average until it is gone:
    /// one as it is held, one more with a computing tick, and the time constant of the lag.
    pub(super) fn reaction_periods(&self) -> f64 {
        let held = if self.computing_tick { 2.0 } else { 1.0 };
        held + self.actuator_lag / self.sample_period
    }

    /// The time T_a for which a force acts after the motion that it was computed from, s.
    fn reaction_time(&self) -> f64 {
        self.sample_period * self.reaction_periods()
    }

    /// How far the account can be overdrawn; `least_mass` is the least mass of the robot on any axis, kg.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the mass or a setting is out of range.
    pub fn overdraft(&self, least_mass: f64) -> Result<Overdraft> {
        let settings = self.checked()?;
        quantity::MASS.check("least_mass", least_mass)?;
        let per_stiffness = settings.reaction_time().powi(2) / least_mass;
        // Positions as measured and the debit for what the encoder hides are each wrong by √2 q per tick at most.
        let hidden = 2.0 * 2.0_f64.sqrt() * settings.encoder_step * settings.reaction_periods();
        Ok(Overdraft {
            ratio: settings.stiffness * per_stiffness,
            hidden: 0.5 * settings.stiffness * hidden.powi(2),
            proven_stiffness: Overdraft::LARGEST_PROVEN_RATIO / per_stiffness,
        })
    }

    /// Refuses settings for which the account bounds nothing: a ratio of 1 or more.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field `stiffness`, or for the first value out of range.
    pub fn check_bound(&self, least_mass: f64) -> Result<()> {
        let Overdraft { ratio, proven_stiffness, .. } = self.overdraft(least_mass)?;
        if ratio < 1.0 {
            return Ok(());
        }
        let delays = match (self.computing_tick, self.actuator_lag > 0.0) {
            (false, false) => "the sample period",
            (true, false) => "the sample period, or compute without the extra period",
            (_, true) => "the sample period and the lag of the actuator",
        };
        Err(InvalidInput::new(
            "stiffness",
            self.stiffness,
            format!(
                "a force acts {:.4} s after its motion, and in that time a robot of {least_mass} kg can take {ratio:.3} \
                 times its own energy out of the guard's account; the guard bounds nothing from 1 on",
                self.reaction_time()
            ),
            format!("Use at most {proven_stiffness:.4} N/m, where it is proven, or shorten {delays}."),
        ))
    }
}
