//! The dyad under two sampled controllers: spectral radius and largest stable stiffness.

use super::Network;
use super::contour::{self, CountFailure};
use super::sampled_characteristic::SampledCharacteristic;
use super::sampled_line;
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

/// The softest spring, relative to the limit, that is tested where theory does not decide.
pub(super) const SOFTEST: f64 = 1e-6;

/// The smallest stiffness (N/m) up to `limit` at which a multiplier of the dyad under sampled controllers reaches
/// the unit circle, or `limit`; 0 if even a soft spring is unstable. Every smaller stiffness is stable.
///
/// All crossings of the circle are enclosed, at every angle and stiffness, so that no window of unstable
/// stiffnesses below the bound is missed. An infinite `limit` stands for the stiffness above which no spring
/// under a hold is stable. If masses, dampings and stiffnesses differ by so many decades that the search does
/// not end, the bound is the stiffness up to which it has proven stability.
pub(super) fn stiffness_bound(axis: &DyadAxis, network: &Network, limit: f64) -> f64 {
    let h = network.sample_period();
    // A spring under a hold on a free, undamped mass diverges at any k; with damping, above about 2 B/h.
    let strongest = axis
        .sides
        .iter()
        .map(|side| 8.0 * (side.mass / (h * h) + side.damping / h) + side.ground_stiffness)
        .fold(0.0, f64::max);
    let limit = limit.min(strongest);
    if limit <= 0.0 {
        return 0.0;
    }
    // With damped sides and no coupling damper, |qᵢ| exceeds k |nᵢ| by far on the whole circle below this stiffness:
    // a soft spring is stable at every delay.
    let soft = axis.sides.iter().fold(f64::INFINITY, |soft, side| {
        soft.min(side.damping / (side.mass / side.damping + h)).min(side.damping * side.damping / side.mass)
    });
    if soft > 0.0 && axis.coupling_damping == 0.0 {
        let start = (1e-3 * soft).min(0.5 * limit);
        return sampled_line::first_crossing_stiffness(axis, network, (start, limit));
    }
    // Otherwise a count decides for a spring far below any useful stiffness.
    let start = SOFTEST * limit;
    match contour::count_outside_circle(&SampledCharacteristic::new(axis, start, network), 0.0) {
        Ok((0, _)) => sampled_line::first_crossing_stiffness(axis, network, (start, limit)),
        Ok(_) | Err(CountFailure::RootOnCircle | CountFailure::TooLong) => 0.0,
    }
}
