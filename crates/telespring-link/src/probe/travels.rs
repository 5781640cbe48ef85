//! Which packets came, and how long each travelled.

use super::report::{ABSENT, PER_BLOCK};

/// The travel of each packet of one way, by its number. A travel is arrival less stamp, on two clocks, ns.
#[derive(Debug, Clone, Default)]
pub(super) struct Travels {
    /// The smallest travel; `None` before the first.
    base: Option<i64>,
    /// Travels, ns; `None` for a packet that did not come.
    all: Vec<Option<i64>>,
    /// Packets that came after one with a higher number.
    pub(super) overtaken: u64,
    highest: Option<usize>,
}

impl Travels {
    /// Room for this many packets.
    pub(super) fn with_capacity(packets: usize) -> Self {
        Self { all: Vec::with_capacity(packets), ..Self::default() }
    }

    /// A packet came; what lies beyond the room is ignored.
    pub(super) fn note(&mut self, number: usize, travel: i64) {
        if number >= self.all.capacity() {
            return;
        }
        if number >= self.all.len() {
            self.all.resize(number + 1, None);
        }
        let Some(place) = self.all.get_mut(number) else { return };
        if place.is_some() {
            return;
        }
        *place = Some(travel);
        self.base = Some(self.base.map_or(travel, |base| base.min(travel)));
        self.overtaken += u64::from(self.highest.is_some_and(|highest| number < highest));
        self.highest = self.highest.max(Some(number));
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.all.clear();
        (self.base, self.overtaken, self.highest) = (None, 0, None);
    }

    /// Packets from `first` to the last that came.
    pub(super) fn number_from(&self, first: usize) -> usize {
        self.highest.map_or(0, |highest| (highest + 1).saturating_sub(first))
    }

    /// The travels of the packets from `first` on, ns.
    pub(super) fn from(&self, first: usize, packets: usize) -> Vec<Option<i64>> {
        (first..first.saturating_add(packets)).map(|number| self.all.get(number).copied().flatten()).collect()
    }

    /// What all travels are counted from, and block `block` of those of the packets from `first` on.
    pub(super) fn block(&self, first: usize, block: usize) -> (i64, [u32; PER_BLOCK]) {
        let base = self.base.unwrap_or(0);
        let travels = std::array::from_fn(|place| {
            let number = first.saturating_add(block * PER_BLOCK + place);
            let travel = self.all.get(number).copied().flatten();
            travel.map_or(ABSENT, |travel| {
                let units = (travel.saturating_sub(base) + 50) / 100;
                u32::try_from(units).unwrap_or(ABSENT - 1).min(ABSENT - 1)
            })
        });
        (base, travels)
    }
}
