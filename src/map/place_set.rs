//! A set of small numbers, one bit each.

use crate::map::PlaceId;

/// A set of places of one map.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlaceSet(BitSet);

/// A set of numbers below a bound.
#[derive(Clone, Debug, Default)]
pub(super) struct BitSet {
    words: Vec<u64>,
}

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
        self.0.words.iter().zip(&other.0.words).any(|(own, others)| own & others != 0)
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
        let word = number / 64;
        if word >= self.words.len() {
            self.words.resize(word + 1, 0);
        }
        self.words[word] |= 1 << (number % 64);
    }

    pub(super) fn contains(&self, number: usize) -> bool {
        self.words.get(number / 64).is_some_and(|word| word & (1 << (number % 64)) != 0)
    }
}
