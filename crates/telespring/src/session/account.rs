//! The energy account of one side: what its robot may still give out.
//!
//! The account is debited with the energy that the robot really gave out, and credited with a share of the energy that
//! the robot's own damping certainly took, and with the energy that the partner sent. A force that it cannot pay is
//! reduced. `docs/guard.md` has the proof.

mod device;
mod loss;
mod overdraft;
mod settings;

pub use overdraft::Overdraft;
pub use settings::AccountSettings;

use super::pair::{dot, finite_or};
use crate::error::Result;
use device::Device;
use loss::LossWindow;

/// The longest time between two measurements for which energy is taken in, s: a clock that jumps brings in no more.
const LONGEST_INTAKE: f64 = 0.1;

/// The longest time for which the partner's energy waits to be taken in, s: what would have to wait longer is lost.
/// Otherwise two hands lay by in minutes what keeps free robots moving for minutes.
const LONGEST_WAIT: f64 = 5.0;

/// The energy account of one side, over both axes together.
///
/// # Examples
///
/// An account of 20 mJ pays for a force of √(2 k S) and no more:
///
/// ```
/// use telespring::session::{AccountSettings, EnergyAccount};
///
/// let settings = AccountSettings { capacity: 0.02, ..AccountSettings::new(100.0, [6.0, 6.0]) };
/// let mut account = EnergyAccount::new(settings)?;
/// assert_eq!(account.pay([1.0, 0.0], 0.005), [1.0, 0.0]);
/// assert_eq!(account.pay([50.0, 0.0], 12.5), [2.0, 0.0]);
/// // the robot moved 4 mm with the 2 N, in 0.1 s: 8 mJ given out, of which 70 % of 6 N·s/m · (0.04 m/s)² · 0.1 s return
/// account.settle(0.1, [0.004, 0.0], [2.0, 0.0], 0.0);
/// assert!((account.balance() - (0.02 - 0.008 + 0.7 * 0.00096)).abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone)]
pub struct EnergyAccount {
    settings: AccountSettings,
    balance: f64,
    sent: f64,
    received: f64,
    /// The largest total that the partner has claimed to have sent.
    claimed: f64,
    /// What of it may still be taken in.
    waiting: f64,
    given_out: f64,
    credited: f64,
    /// The force that acted before the last measurement, N.
    acted: [f64; 2],
    device: Device,
    windows: [LossWindow; 2],
}

/// The sum of both magnitudes.
fn magnitude([a, b]: [f64; 2]) -> f64 {
    a.abs() + b.abs()
}

impl EnergyAccount {
    /// An account that holds its capacity.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::error::InvalidInput) for the first setting out of range.
    pub fn new(settings: AccountSettings) -> Result<Self> {
        let settings = settings.checked()?;
        Ok(Self {
            settings,
            balance: settings.capacity,
            sent: 0.0,
            received: 0.0,
            claimed: 0.0,
            waiting: 0.0,
            given_out: 0.0,
            credited: 0.0,
            acted: [0.0; 2],
            device: Device::new(&settings),
            windows: [LossWindow::default(); 2],
        })
    }

    /// Takes account of the time since the previous measurement: `elapsed` s, the measured displacement (m), the force
    /// that acted on the handle all that time (N), and the energy that the partner claims to have sent so far (J).
    ///
    /// A claim that is not finite or falls is passed over. A time that is not positive brings no credit. A displacement
    /// or a force that is not a number empties the account, because nobody knows what was given out.
    pub fn settle(&mut self, elapsed: f64, displacement: [f64; 2], acted: [f64; 2], claimed: f64) {
        let AccountSettings { encoder_step, share, .. } = self.settings;
        self.device.advance(elapsed);
        let given_out = dot(acted, displacement);
        let [dx, dy] = acted;
        let [ex, ey] = self.acted;
        // What the encoder may hide of the energy given out; see docs/guard.md.
        let hidden = 0.5
            * encoder_step
            * (magnitude([dx - ex, dy - ey]) + magnitude(acted) - magnitude(self.acted)).max(0.0);
        if !(given_out + hidden).is_finite() {
            self.balance = self.balance.min(0.0);
            self.acted = [0.0; 2];
            self.windows = [LossWindow::default(); 2];
            return;
        }
        self.acted = acted;
        let lost = self.certain_loss(elapsed, displacement);
        let taken_in = self.take_in(elapsed, claimed);
        let balance = self.balance - given_out - hidden + share * lost + taken_in;
        self.balance = if balance.is_finite() { balance } else { self.balance.min(0.0) };
        self.given_out = finite_or(self.given_out + given_out, self.given_out);
        self.credited = finite_or(self.credited + share * lost, self.credited);
    }

    /// The energy that the robot's damping certainly took since it was last asked, J.
    fn certain_loss(&mut self, elapsed: f64, displacement: [f64; 2]) -> f64 {
        let AccountSettings { damping, encoder_step, .. } = self.settings;
        let axes = self.windows.iter_mut().zip(displacement).zip(damping);
        axes.map(|((window, moved), damping)| window.add(elapsed, moved, damping, encoder_step)).sum()
    }

    /// Takes in what the partner has sent, at no more than the set power, J.
    fn take_in(&mut self, elapsed: f64, claimed: f64) -> f64 {
        if claimed.is_finite() && claimed > self.claimed {
            self.waiting = finite_or(self.waiting + (claimed - self.claimed), f64::MAX);
            self.claimed = claimed;
        }
        let time = if elapsed > 0.0 { elapsed.min(LONGEST_INTAKE) } else { 0.0 };
        let received = (self.received + self.waiting.min(self.settings.intake * time)).min(self.claimed);
        let taken_in = received - self.received;
        self.received = received;
        self.waiting = (self.waiting - taken_in).clamp(0.0, self.settings.intake * LONGEST_WAIT);
        taken_in
    }

    /// The force that the account can pay of the one `wanted` (N), and that counts as commanded. `stored` is the energy
    /// that the wanted spring holds, J.
    ///
    /// The paid force has the wanted direction and at most the size √(2 k S). It is also so small that its impulse and that
    /// of all earlier forces still to act, behind a computing tick or a lag, is at most √(2 k S) for as long as a force
    /// acts. What the account holds beyond the energy of the spring and the capacity moves to the partner. A wanted force
    /// that is not finite gives no force.
    pub fn pay(&mut self, wanted: [f64; 2], stored: f64) -> [f64; 2] {
        let AccountSettings { stiffness, capacity, .. } = self.settings;
        let [x, y] = wanted;
        let size = x.hypot(y);
        let (outstanding, periods) = (self.device.outstanding(), self.settings.reaction_periods());
        let most = self.largest_force();
        let allowed = most.min((periods * most - outstanding).max(0.0));
        let (force, paid) = match size {
            _ if !size.is_finite() => ([0.0; 2], 0.0),
            _ if size <= allowed => (wanted, size),
            _ => (wanted.map(|force| force / size * allowed), allowed),
        };
        self.device.command(paid);
        let spring = if size.is_finite() { (size * size / (2.0 * stiffness)).max(stored) } else { 0.0 };
        // No energy leaves that the forces still to act may need.
        let committed = (outstanding + paid) * (outstanding + paid) / (2.0 * stiffness * periods * periods);
        let excess = self.balance - (spring.max(committed) + capacity);
        if excess > 0.0 {
            self.balance -= excess;
            self.sent = finite_or(self.sent + excess, self.sent);
        }
        force
    }

    /// The largest force that the balance can pay, √(2 k S), N; 0 while it is overdrawn.
    pub fn largest_force(&self) -> f64 {
        (2.0 * self.settings.stiffness * self.balance.max(0.0)).sqrt()
    }

    /// The settings of the account.
    pub fn settings(&self) -> &AccountSettings {
        &self.settings
    }

    /// The energy in the account, J; below 0 while it is overdrawn.
    pub fn balance(&self) -> f64 {
        self.balance
    }

    /// The energy sent to the partner so far, J; it never falls.
    pub fn sent(&self) -> f64 {
        self.sent
    }

    /// The energy taken in from the partner so far, J.
    pub fn received(&self) -> f64 {
        self.received
    }

    /// The energy given out to the handle so far as measured, J: the sum of force times displacement.
    pub fn given_out(&self) -> f64 {
        self.given_out
    }

    /// The energy credited so far for the losses in the robot's damping, J.
    pub fn credited(&self) -> f64 {
        self.credited
    }
}
