//! Which sequence numbers have come.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

/// Sequence numbers per word of the window.
const WORD: u64 = 64;
/// Words of the window.
const WORDS: usize = 64;

/// The sequence numbers that have come, with a window in which repetitions are recognised: 63 words and more.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sequences {
    first: Option<u64>,
    highest: u64,
    distinct: u64,
    /// Bit `n mod 64` of word `n / 64 mod WORDS` stands for the number n of the last `WORDS` words.
    seen: [u64; WORDS],
}

impl Sequences {
    pub(super) fn new() -> Self {
        Self { first: None, highest: 0, distinct: 0, seen: [0; WORDS] }
    }

    fn word(&mut self, number: u64) -> Option<&mut u64> {
        self.seen.get_mut(usize::try_from(number / WORD % WORDS as u64).ok()?)
    }

    /// Notes a number and returns whether it is new; one from before the window counts as new.
    pub(super) fn note(&mut self, number: u64) -> bool {
        if self.first.is_none() || number > self.highest {
            let begun = if self.first.is_some() { self.highest / WORD } else { number / WORD };
            // the words that the window enters hold numbers of one turn ago
            let entered = (number / WORD).saturating_sub(begun).min(WORDS as u64);
            for step in 0..entered {
                if let Some(word) = self.word(number.saturating_sub(step * WORD)) {
                    *word = 0;
                }
            }
            self.highest = number;
        }
        self.first = Some(self.first.map_or(number, |first| first.min(number)));
        if self.highest / WORD - number / WORD < WORDS as u64 {
            let bit = 1 << (number % WORD);
            let Some(word) = self.word(number) else { return false };
            if *word & bit != 0 {
                return false;
            }
            *word |= bit;
        }
        self.distinct = self.distinct.saturating_add(1);
        true
    }

    /// The numbers between the first and the highest that have not come.
    pub(super) fn missing(&self) -> u64 {
        let expected = self.first.map_or(0, |first| (self.highest - first).saturating_add(1));
        expected.saturating_sub(self.distinct)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn law_numbers_are_counted_as_a_set_counts_them() {
        // a set, which forgets nothing, against the window
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 33
        };
        let (mut sequences, mut set) = (Sequences::new(), BTreeSet::new());
        let mut base = 10_000_u64;
        for _ in 0..100_000 {
            base += [0, 0, 1, 1, 2, 70, 0, 1][usize::try_from(random() % 8).unwrap()];
            let number = base - random() % ((WORDS as u64 - 2) * WORD);
            assert_eq!(sequences.note(number), set.insert(number), "{number}");
        }
        let (first, last) = (set.first().unwrap(), set.last().unwrap());
        assert_eq!(sequences.missing(), last - first + 1 - set.len() as u64);
        assert!(sequences.note(u64::MAX) && !sequences.note(u64::MAX) && sequences.note(0));
    }
}
