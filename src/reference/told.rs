//! A story and what it says, read off the visits.

use crate::abduction::Visit;
use crate::star::LargeScaleStar;
use std::collections::{BTreeMap, BTreeSet};

/// For each observation its place and rotation. Places are numbered by first visit, which is unturned.
pub type Story = Vec<(usize, usize)>;

/// A place and a slot of the star of its first visit.
pub type End = (usize, usize);

/// A story with the visits it is told of.
pub(super) struct Told<'a> {
    pub(super) visits: &'a [Visit],
    pub(super) story: &'a [(usize, usize)],
    /// The star of each place's first visit.
    pub(super) stars: Vec<&'a LargeScaleStar>,
    /// For each observation but the first, the gateway left by and the gateway arrived at, both outward.
    pub(super) travels: Vec<(End, End)>,
    far_ends: BTreeMap<End, End>,
}

impl<'a> Told<'a> {
    pub(super) fn new(visits: &'a [Visit], story: &'a [(usize, usize)]) -> Told<'a> {
        let mut stars: Vec<&LargeScaleStar> = Vec::new();
        for (visit, &(place, _)) in visits.iter().zip(story) {
            if place == stars.len() {
                stars.push(&visit.star);
            }
        }
        let travels: Vec<(End, End)> = (1..story.len()).filter_map(|k| travel(visits, story, k)).collect();
        let mut far_ends = BTreeMap::new();
        for (from, to) in travels.iter().flat_map(|&(a, b)| [(a, b), (b, a)]) {
            // The first is as good as any: `determinism` says that there is no other.
            far_ends.entry(from).or_insert(to);
        }
        Told { visits, story, stars, travels, far_ends }
    }

    pub(super) fn far_end(&self, end: End) -> Option<End> {
        self.far_ends.get(&end).copied()
    }

    /// The other direction of the same path fragment.
    pub(super) fn opposite(&self, end: End) -> End {
        (end.0, self.stars[end.0].slots()[end.1].opposite.0 as usize)
    }

    /// Every slot of every place.
    pub(super) fn ends(&self) -> Vec<End> {
        let slots = |(place, star): (usize, &&LargeScaleStar)| {
            (0..star.size()).map(move |slot| (place, slot)).collect::<Vec<End>>()
        };
        self.stars.iter().enumerate().flat_map(slots).collect()
    }

    /// The path segments: each travelled pair of gateways once, the lower one first.
    pub(super) fn segments(&self) -> BTreeSet<(End, End)> {
        self.travels.iter().map(|&(a, b)| (a.min(b), a.max(b))).collect()
    }
}

/// For each observation but the first, the gateway left by and the gateway arrived at, both outward.
pub fn travels(visits: &[Visit], story: &Story) -> Vec<(End, End)> {
    Told::new(visits, story).travels
}

/// The path segments: each travelled pair of gateways once, the lower one first.
pub fn segments(visits: &[Visit], story: &Story) -> BTreeSet<(End, End)> {
    Told::new(visits, story).segments()
}

/// The number of places of a story.
pub(super) fn place_count(story: &[(usize, usize)]) -> usize {
    story.iter().map(|visit| visit.0 + 1).max().unwrap_or(0)
}

/// The gateways that the travel before observation `k` left by and arrived at.
fn travel(visits: &[Visit], story: &[(usize, usize)], k: usize) -> Option<(End, End)> {
    let (before, now) = (&visits[k - 1], &visits[k]);
    let left = now.departure?.0 as usize;
    let passed = now.star.slots()[now.arrival.0 as usize].opposite.0 as usize;
    let from = (story[k - 1].0, (left + story[k - 1].1) % before.star.size());
    Some((from, (story[k].0, (passed + story[k].1) % now.star.size())))
}
