//! A set of small numbers, one bit each.

use crate::map::PlaceId;

/// A set of places of one map.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlaceSet(BitSet);

/// A set of numbers below a bound.
#[derive(Clone, Debug, Default)]
pub(super) struct BitSet {
    /// The numbers below [`LOW`]; most sets have no others, and need no further memory.
    low: [u64; LOW / 64],
    high: Vec<u64>,
}

const LOW: usize = 256;

impl PlaceSet {
    /// Whether the place is a member.
    pub(crate) fn contains(&self, place: PlaceId) -> bool {
        self.0.contains(place.index())
    }

    /// Makes the place a member.
    pub(crate) fn insert(&mut self, place: PlaceId) {
        self.0.insert(place.index());
    }

    /// Whether the sets have a member in common.
    pub(crate) fn intersects(&self, other: &PlaceSet) -> bool {
        self.0.words().zip(other.0.words()).any(|(own, others)| own & others != 0)
    }
}

impl FromIterator<PlaceId> for PlaceSet {
    fn from_iter<I: IntoIterator<Item = PlaceId>>(places: I) -> Self {
        let mut set = BitSet::default();
        for place in places {
            set.insert(place.index());
        }
        PlaceSet(set)
    }
}

impl BitSet {
    pub(super) fn insert(&mut self, number: usize) {
        let (word, bit) = (number / 64, 1 << (number % 64));
        if let Some(low) = self.low.get_mut(word) {
            *low |= bit;
            return;
        }
        let word = word - self.low.len();
        if word >= self.high.len() {
            self.high.resize(word + 1, 0);
        }
        self.high[word] |= bit;
    }

    pub(super) fn contains(&self, number: usize) -> bool {
        let word = number / 64;
        let found = self.low.get(word).or_else(|| self.high.get(word - self.low.len()));
        found.is_some_and(|word| word & (1 << (number % 64)) != 0)
    }

    fn words(&self) -> impl Iterator<Item = &u64> {
        self.low.iter().chain(&self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn a_set_of_bits_is_a_set(
            own in prop::collection::btree_set(0..700usize, 0..9),
            other in prop::collection::btree_set(0..700usize, 0..9),
        ) {
            let set = |numbers: &BTreeSet<usize>| -> PlaceSet {
                numbers.iter().filter_map(|&number| PlaceId::new(number)).collect()
            };
            let (a, b) = (set(&own), set(&other));
            for number in 0..800 {
                prop_assert_eq!(a.contains(PlaceId::new(number).unwrap()), own.contains(&number));
            }
            prop_assert_eq!(a.intersects(&b), !own.is_disjoint(&other));
        }
    }
}
