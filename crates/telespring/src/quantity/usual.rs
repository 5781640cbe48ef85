//! The values that laboratories have: a value outside is possible, but its unit is probably wrong.

use std::f64::consts::PI;

use super::{
    ADDED_MASS, AMPLITUDE, ANGULAR_FREQUENCY, CONTROLLER_PERIOD, COULOMB, DAMPING, DAMPING_SD, DELAY, ENERGY,
    FORCE, GROUND_STIFFNESS, IMPEDANCE, INERTIA, JOINT_DAMPING, LENGTH, LIFETIME, LINK_MASS, MASS, MASS_SD,
    OFFSET, OPERATOR_DAMPING, PLACE, POSITION_NOISE, POSITION_SHIFT, POWER, Quantity, RATE, RESOLUTION,
    ROBOT_SPRING, SAMPLE_PERIOD, SPAN, SPEED, STAMP_SHIFT, STIFFNESS,
};
use crate::error::{InvalidInput, Result};

/// The magnitudes that a quantity usually has, and the units that it is confused with.
struct Usual {
    quantity: Quantity,
    /// The smallest magnitude besides 0.
    minimum: f64,
    maximum: f64,
    /// Other units with the factor from them to the quantity's unit, the likeliest first.
    units: &'static [(&'static str, f64)],
}

/// The usual magnitudes of a quantity.
const fn usual(
    quantity: Quantity,
    minimum: f64,
    maximum: f64,
    units: &'static [(&'static str, f64)],
) -> Usual {
    Usual { quantity, minimum, maximum, units }
}

const GRAMS: &[(&str, f64)] = &[("g", 1e-3)];
const MILLISECONDS: &[(&str, f64)] = &[("ms", 1e-3)];
const PER_MILLIMETRE: &[(&str, f64)] = &[("N/mm", 1e3)];
const LENGTHS: &[(&str, f64)] = &[("cm", 1e-2), ("mm", 1e-3)];

/// Light haptic devices to industrial axes (95 kg and 200 N·s/m have been identified), networks up to a link
/// through a satellite.
const USUAL: [Usual; 32] = [
    usual(MASS, 0.01, 300.0, GRAMS),
    usual(ADDED_MASS, 0.0, 100.0, GRAMS),
    usual(DAMPING, 0.0, 1e3, &[("g/s", 1e-3)]),
    usual(STIFFNESS, 0.1, 2e4, PER_MILLIMETRE),
    usual(GROUND_STIFFNESS, 1.0, 5e4, PER_MILLIMETRE),
    // A measured spring may be as weak as its error.
    usual(ROBOT_SPRING, 0.0, 5e4, PER_MILLIMETRE),
    usual(OPERATOR_DAMPING, 0.0, 100.0, &[("g/s", 1e-3)]),
    usual(DELAY, 0.0, 2.0, MILLISECONDS),
    usual(SPAN, 0.0, 2.0, MILLISECONDS),
    usual(CONTROLLER_PERIOD, 0.0, 0.1, MILLISECONDS),
    usual(SAMPLE_PERIOD, 0.0, 0.1, MILLISECONDS),
    usual(RATE, 1.0, 1e5, &[("kHz", 1e3)]),
    usual(COULOMB, 0.0, 200.0, &[("mN", 1e-3)]),
    usual(FORCE, 0.0, 1e3, &[("mN", 1e-3)]),
    usual(PLACE, 0.0, 3.0, LENGTHS),
    usual(AMPLITUDE, 0.0, 1.0, LENGTHS),
    usual(LENGTH, 0.0, 2.0, LENGTHS),
    usual(OFFSET, 0.0, 2.0, LENGTHS),
    usual(RESOLUTION, 0.0, 1e-3, &[("mm", 1e-3), ("µm", 1e-6)]),
    usual(LINK_MASS, 0.0, 50.0, GRAMS),
    usual(INERTIA, 0.0, 10.0, &[("kg·cm²", 1e-4)]),
    usual(JOINT_DAMPING, 0.0, 100.0, &[]),
    usual(SPEED, 0.0, 5.0, &[("cm/s", 1e-2), ("mm/s", 1e-3)]),
    usual(LIFETIME, 0.0, 60.0, MILLISECONDS),
    usual(ANGULAR_FREQUENCY, 0.0, 100.0, &[("°/s", PI / 180.0)]),
    usual(MASS_SD, 0.0, 30.0, GRAMS),
    usual(ENERGY, 0.0, 5.0, &[("mJ", 1e-3)]),
    usual(POWER, 0.0, 20.0, &[("mW", 1e-3)]),
    usual(POSITION_SHIFT, 0.0, 1.0, LENGTHS),
    usual(STAMP_SHIFT, 0.0, 2.0, MILLISECONDS),
    usual(IMPEDANCE, 0.01, 1e3, &[("g/s", 1e-3)]),
    usual(POSITION_NOISE, 1e-9, 0.01, &[("mm", 1e-3), ("µm", 1e-6)]),
];

/// A number of some unit in another one; a division by a whole number rounds once: 833.4 g are 0.8334 kg.
fn converted(value: f64, factor: f64) -> f64 {
    let inverse = (1.0 / factor).round();
    if factor < 1.0 && (inverse * factor - 1.0).abs() < 1e-12 {
        return value / inverse;
    }
    let product = value * factor;
    // A product has one digit more than people write: 0.5993 N/mm are 599.3 N/m, not 599.3000000000001.
    format!("{product:.14e}").parse().unwrap_or(product)
}

impl Usual {
    /// Whether laboratories have a value: 0, or a magnitude in the range.
    fn contains(&self, value: f64) -> bool {
        value == 0.0 || (self.minimum..=self.maximum).contains(&value.abs())
    }
}

impl Quantity {
    /// Checks that laboratories have such a `value`, and returns it; a quantity without a usual range has all.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with `field`, the value, the usual magnitudes, and the unit probably meant.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::quantity::DELAY;
    /// assert_eq!(DELAY.check_usual("delay", 0.08), Ok(0.08));
    /// let refused = DELAY.check_usual("delay", 80.0).unwrap_err();
    /// assert!(refused.remedy.starts_with("Did you mean 80 ms? Write 0.08."));
    /// ```
    pub fn check_usual(&self, field: &str, value: f64) -> Result<f64> {
        match self.usual() {
            Some(usual) if !usual.contains(value) => Err(self.unusual(usual, field, value)),
            _ => Ok(value),
        }
    }

    /// The smallest and the largest magnitude, besides 0, that laboratories have; `None` if every value is usual.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::quantity::STIFFNESS;
    /// let (softest, stiffest) = STIFFNESS.usual_range().unwrap();
    /// assert!(STIFFNESS.check_usual("stiffness", stiffest).is_ok());
    /// assert!(STIFFNESS.check_usual("stiffness", 0.9 * softest).is_err());
    /// ```
    pub fn usual_range(&self) -> Option<(f64, f64)> {
        self.usual().map(|usual| (usual.minimum, usual.maximum))
    }

    /// What is usual of this quantity.
    fn usual(&self) -> Option<&'static Usual> {
        // The damping of a robot and its standard deviation differ in range, not in what is usual.
        let kind = if *self == DAMPING_SD { &DAMPING } else { self };
        USUAL.iter().find(|usual| usual.quantity == *kind)
    }

    /// The value of a text that is a number and a unit, this quantity's own or one that it is confused with.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::quantity::{DAMPING, DELAY, STIFFNESS};
    /// assert_eq!(DELAY.read_with_unit("80 ms"), Some(0.08));
    /// assert_eq!(STIFFNESS.read_with_unit("71.2N/m"), Some(71.2));
    /// assert_eq!(DAMPING.read_with_unit("9 Ns/m"), Some(9.0));
    /// assert_eq!(DELAY.read_with_unit("80 kg"), None);
    /// ```
    pub fn read_with_unit(&self, text: &str) -> Option<f64> {
        let text = text.trim();
        let end = text
            .char_indices()
            .map(|(start, letter)| start + letter.len_utf8())
            .rfind(|end| text[..*end].parse::<f64>().is_ok_and(f64::is_finite))?;
        let (number, unit) = (text[..end].parse::<f64>().ok()?, text[end..].trim());
        // A product is written N·s, N*s, N.s, N-s, N s or Ns.
        let plain = |unit: &str| unit.replace(['·', '⋅', '∙', '*', '.', '-', ' '], "").replace('μ', "µ");
        let own = [(self.unit, 1.0), ("", 1.0)];
        let others = USUAL.iter().find(|usual| usual.quantity == *self).map_or(&[][..], |usual| usual.units);
        let mut units = own.iter().chain(others);
        let (_, factor) = units.find(|(name, _)| plain(name) == plain(unit))?;
        Some(converted(number, *factor))
    }

    /// The refusal of a value that no laboratory has.
    fn unusual(&self, usual: &Usual, field: &str, value: f64) -> InvalidInput {
        let meant = usual.units.iter().find_map(|&(unit, factor)| {
            let converted = converted(value, factor);
            usual.contains(converted).then(|| format!("Did you mean {value} {unit}? Write {converted}. "))
        });
        let least = if usual.minimum > 0.0 { format!("{} to ", usual.minimum) } else { "up to ".to_owned() };
        InvalidInput::new(
            field,
            format!("{value} {}", self.unit).trim_end(),
            format!("{} is usually {least}{} {}", self.name, usual.maximum, self.unit),
            format!(
                "{}If it is meant, write allow_unusual = true in the study, or --allow-unusual on the command line.",
                meant.unwrap_or_default()
            ),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_every_usual_range_lies_within_the_range_of_its_quantity() {
        for Usual { quantity, minimum, maximum, units } in &USUAL {
            assert!(minimum < maximum, "{}", quantity.name);
            assert!(*maximum <= quantity.maximum, "{}", quantity.name);
            assert!(*minimum == 0.0 || *minimum >= quantity.minimum, "{}", quantity.name);
            assert!(units.iter().all(|(_, factor)| *factor != 1.0));
        }
    }

    #[test]
    fn ref_a_wrong_unit_is_named_with_the_number_to_write() {
        for (quantity, value, expected) in [
            (DELAY, 80.0, "80 ms? Write 0.08."),
            (SPAN, 15.0, "15 ms? Write 0.015."),
            (MASS, 1200.0, "1200 g? Write 1.2."),
            (MASS, 833.4, "833.4 g? Write 0.8334."),
            (STIFFNESS, 0.0712, "0.0712 N/mm? Write 71.2."),
            (GROUND_STIFFNESS, 0.5993, "0.5993 N/mm? Write 599.3."),
            (CONTROLLER_PERIOD, 1.0, "1 ms? Write 0.001."),
            (AMPLITUDE, 5.0, "5 cm? Write 0.05."),
            (RESOLUTION, 0.01, "0.01 mm? Write 0.00001."),
        ] {
            let refused = quantity.check_usual("field", value).unwrap_err();
            assert!(refused.remedy.contains(expected), "{}", refused.remedy);
            assert!(quantity.check("field", value).is_ok());
        }
    }
}
