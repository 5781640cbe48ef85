//! How long there may be no way but one that is not allowed, before the partner is looked for anew.

use std::time::Duration;

use super::shared::Way;

/// A direct way is found within seconds, or not at all: from then on iroh tries the addresses that the partner tells of itself,
/// but not those that this site was given. They are tried where two sites connect anew.
const PATIENCE: Duration = Duration::from_secs(20);

/// Since when there has been a way over the relay only, which is not allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Withheld(Option<Duration>);

impl Withheld {
    /// Takes the way of now, since any origin; whether it is time to look for another one. Then the patience begins anew.
    pub(super) fn is_time(&mut self, now: Duration, way: Way) -> bool {
        if way != Way::Withheld {
            self.0 = None;
            return false;
        }
        let since = *self.0.get_or_insert(now);
        let is_time = now.saturating_sub(since) >= PATIENCE;
        if is_time {
            self.0 = None;
        }
        is_time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_way_that_stays_withheld_is_looked_for_anew_again_and_again_and_no_other_one_is() {
        let seconds = Duration::from_secs;
        let mut withheld = Withheld::default();
        let times = (0..=70).filter(|second| withheld.is_time(seconds(*second), Way::Withheld));
        assert_eq!(times.collect::<Vec<u64>>(), [20, 41, 62]);
        for way in [Way::None, Way::Direct, Way::Relayed] {
            let mut withheld = Withheld::default();
            assert!((0..100).all(|second| !withheld.is_time(seconds(second), way)), "{way:?}");
            // another way meanwhile: the patience begins anew
            let mut withheld = Withheld::default();
            let looked = (0..60).map(|second| {
                let way = if second == 15 { way } else { Way::Withheld };
                (second, withheld.is_time(seconds(second), way))
            });
            let times: Vec<u64> = looked.filter(|(_, is_time)| *is_time).map(|(second, _)| second).collect();
            assert_eq!(times, [36, 57], "{way:?}");
        }
    }
}
