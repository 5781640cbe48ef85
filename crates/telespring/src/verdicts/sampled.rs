//! The dyad under two sampled controllers: spectral radius and largest stable stiffness.

use super::Network;
use super::contour::{self, CountFailure};
use super::sampled_characteristic::SampledCharacteristic;
use super::sampled_roots::SampledSpectrum;
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;
use crate::quantity;

/// The spectral radius of the one-period map of one axis under sampled controllers.
///
/// `stiffness` is in N/m. The delays are those behind a playout buffer ([`Network::buffered`]), rounded up
/// to whole periods.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness is out of range or the network has no sample period.
///
/// # Examples
///
/// ```
/// use telespring::{Delay, DyadAxis};
/// use telespring::verdicts::{Network, sampled_spectral_radius};
/// let axis = DyadAxis::new(0.8334, 7.7257, 0.7776, 7.4208)?;
/// let network = Network::new(Delay::each_way(0.1)?, 0.0, 0.0, 0.001, 0.0)?;
/// assert!(sampled_spectral_radius(&axis, 71.2, &network)?.is_stable());
/// let network = Network::new(Delay::each_way(0.2)?, 0.0, 0.0, 0.001, 0.0)?;
/// assert!(!sampled_spectral_radius(&axis, 71.2, &network)?.is_stable());
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn sampled_spectral_radius(
    axis: &DyadAxis,
    stiffness: f64,
    network: &Network,
) -> Result<SampledSpectrum> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    if network.sample_period() == 0.0 {
        return Err(InvalidInput::new(
            "network.sample_period",
            0.0,
            "a sampled verdict needs a sample period above 0",
            "Give the period of the controllers, such as 0.001, or use the continuous verdict.",
        ));
    }
    let characteristic = SampledCharacteristic::new(axis, stiffness, network);
    let (root, certificate) = characteristic.rightmost_root(characteristic.rate_scale(axis, stiffness));
    Ok(SampledSpectrum {
        radius: (root.re * network.sample_period()).exp(),
        abscissa_equivalent: root.re,
        frequency: root.im.abs(),
        certificate,
    })
}

/// The largest stiffness (N/m) up to `limit` below which the dyad under sampled controllers is stable: a
/// count on the unit circle at several levels, then bisection below the first unstable level.
///
/// An infinite `limit` stands for the stiffness above which no spring under a hold is stable.
pub(super) fn stiffness_bound(axis: &DyadAxis, network: &Network, limit: f64) -> f64 {
    const LEVELS: i32 = 40;
    // A spring under a hold on a free, undamped mass diverges at any k; with damping, above about 2 B/h.
    let strongest = axis
        .sides
        .iter()
        .map(|side| {
            let h = network.sample_period();
            8.0 * (side.mass / (h * h) + side.damping / h) + side.ground_stiffness
        })
        .fold(0.0, f64::max);
    let limit = limit.min(strongest);
    if limit <= 0.0 {
        return 0.0;
    }
    // Unknown if the count cannot be completed: the search stops at the proven stiffness.
    let holds =
        |k: f64| match contour::count_outside_circle(&SampledCharacteristic::new(axis, k, network), 0.0) {
            Ok((outside, _)) => Some(outside == 0),
            Err(CountFailure::RootOnCircle) => Some(false),
            Err(CountFailure::TooLong) => None,
        };
    let mut low = 0.0;
    let mut high = None;
    for level in 0..=LEVELS {
        // The last level lies just inside: the limit itself may be a boundary.
        let k = limit * (1.0 - 1e-9) * 1e4_f64.powf(f64::from(level - LEVELS) / f64::from(LEVELS));
        match holds(k) {
            Some(true) => low = k,
            Some(false) => {
                high = Some(k);
                break;
            }
            None => return low,
        }
    }
    let Some(mut high) = high else { return limit };
    // Without a stable level, the search starts far below any useful stiffness.
    if low == 0.0 {
        low = 1e-6;
        if low >= high || holds(low) != Some(true) {
            return 0.0;
        }
    }
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        match holds(middle) {
            Some(true) => low = middle,
            Some(false) => high = middle,
            None => break,
        }
    }
    low
}
