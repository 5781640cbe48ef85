//! What both sides must agree on: the terms of a study.

use telespring::InvalidInput;
use telespring::session::wire;
use telespring::study::{Coupling, Study};

use super::disagreement::{Difference, Disagreement, Value};

/// The number of axes of a live session.
const AXES: u8 = 2;

/// What both sides must agree on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// The version of the packets.
    pub packets: u8,
    /// The number of axes.
    pub axes: u8,
    /// The robot of the study that the sender moves, 1 or 2.
    pub side: u8,
    /// A fingerprint of both robots: masses, damping, friction.
    pub robots: u64,
    /// A fingerprint of strategy, predictor and play-out.
    pub strategy: u64,
    /// A fingerprint of the whole study.
    pub study: u64,
    /// Stiffness (N/m) and damping (N·s/m) of the coupling.
    pub coupling: [f64; 2],
    /// The sample period, s.
    pub sample_period: f64,
    /// Axes that the sender leaves out of the coupling; then the receiver does, too. No term on which the two could disagree.
    pub lock: [bool; 2],
}

/// A number that tells contents apart, not a signature: FNV-1a with 64 bits (Fowler, Noll and Vo).
///
/// # Examples
///
/// ```
/// use telespring_link::hello::fingerprint;
///
/// assert_eq!(fingerprint(b"foobar"), 0x8594_4171_f739_67e8); // as its authors print it
/// ```
pub fn fingerprint(content: &[u8]) -> u64 {
    content.iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

impl Terms {
    /// The terms of a study for the side that moves robot `side`, 1 or 2.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the study has no stiffness, or its robots have other axes than x and y.
    pub fn new(study: &Study, side: u8) -> Result<Self, InvalidInput> {
        let laboratory = study.laboratory_without_traces()?;
        let Coupling { stiffness, damping } = study.coupling()?;
        let handles = laboratory.stations.map(|station| station.handle);
        let numbers = handles.iter().flat_map(|handle| [handle.mass, handle.damping, handle.coulomb]);
        let least = laboratory.session.least_damping;
        let numbers = numbers.chain(least).flatten().flat_map(f64::to_le_bytes);
        Ok(Self {
            packets: wire::VERSION,
            axes: AXES,
            side,
            robots: fingerprint(&numbers.collect::<Vec<u8>>()),
            strategy: fingerprint(study.session().to_table().to_string().as_bytes()),
            study: fingerprint(study.to_toml().as_bytes()),
            coupling: [stiffness, damping],
            sample_period: laboratory.controller.sample_period,
            lock: [false; 2],
        })
    }

    /// The first thing in which the partner's terms do not fit these.
    pub fn difference(&self, partner: &Self) -> Option<Difference> {
        let same = |one: f64, other: f64| one.to_bits() == other.to_bits();
        let sides = [self.side, partner.side];
        let checks = [
            (self.packets == partner.packets, Disagreement::Version),
            (self.axes == partner.axes, Disagreement::Axes),
            (sides == [1, 2] || sides == [2, 1], Disagreement::Side),
            (self.robots == partner.robots, Disagreement::Robots),
            ((0..2).all(|i| same(self.coupling[i], partner.coupling[i])), Disagreement::Coupling),
            (same(self.sample_period, partner.sample_period), Disagreement::SamplePeriod),
            (self.strategy == partner.strategy, Disagreement::Strategy),
            (self.study == partner.study, Disagreement::Study),
        ];
        let (_, on) = checks.into_iter().find(|(agrees, _)| !agrees)?;
        Some(Difference { on, values: Some([self, partner].map(|terms| terms.value(on))) })
    }

    /// What these terms have of it.
    fn value(&self, on: Disagreement) -> Value {
        match on {
            Disagreement::Version => Value::Packets(self.packets),
            Disagreement::Axes => Value::Axes(self.axes),
            Disagreement::Side => Value::Robot(self.side),
            Disagreement::Robots => Value::Fingerprint(self.robots),
            Disagreement::Coupling => Value::Coupling(self.coupling),
            Disagreement::SamplePeriod => Value::Period(self.sample_period),
            Disagreement::Strategy => Value::Fingerprint(self.strategy),
            Disagreement::Study => Value::Fingerprint(self.study),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_any_difference_is_named() {
        let toml = |changes: &str| {
            let text = String::from(
                "robot1 = {mass = 1, damping = 5, axes = [\"x\", \"y\"]}\n\
                 robot2 = {mass = 1, damping = 5, coulomb = 0, axes = [\"x\", \"y\"]}\n\
                 coupling.stiffness = 20\nnetwork.delay = 0.05\nsession.strategy = \"guard\"\n\
                 laboratory.sample_period = 0.001\n",
            );
            let text = match changes.split_once(" -> ") {
                Some((from, to)) => {
                    assert!(text.contains(from));
                    text.replace(from, to)
                }
                None => text,
            };
            Study::from_toml(&text).unwrap()
        };
        let found = |one: &Terms, other: &Terms| one.difference(other).map(|difference| difference.on);
        let here = Terms::new(&toml(""), 1).unwrap();
        for (changes, expected) in [
            ("", None),
            ("damping = 5, c -> damping = 5.0000001, c", Some(Disagreement::Robots)),
            ("coulomb = 0 -> coulomb = 1", Some(Disagreement::Robots)),
            ("stiffness = 20 -> stiffness = 21", Some(Disagreement::Coupling)),
            ("period = 0.001 -> period = 0.002", Some(Disagreement::SamplePeriod)),
            ("\"guard\" -> \"spring\"", Some(Disagreement::Strategy)),
            ("\"guard\" -> {kind = \"guard\", share = 0.5}", Some(Disagreement::Strategy)),
            ("delay = 0.05 -> delay = 0.06", Some(Disagreement::Study)),
        ] {
            let there = Terms::new(&toml(changes), 2).unwrap();
            assert_eq!(found(&here, &there), expected, "{changes}");
            assert_eq!(found(&there, &here), expected, "{changes}");
        }
        let terms = Terms::new(&toml(""), 2).unwrap();
        assert_eq!(found(&here, &here), Some(Disagreement::Side));
        assert_eq!(found(&here, &Terms { side: 3, ..terms }), Some(Disagreement::Side));
        assert_eq!(found(&here, &Terms { packets: 1, ..terms }), Some(Disagreement::Version));
        assert_eq!(found(&here, &Terms { axes: 3, ..terms }), Some(Disagreement::Axes));
    }
}
