//! A map beside the truth that somebody has marked in the log.

use crate::abduction::Visit;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use utoipa::ToSchema;

/// How what was found compares with marked arrivals.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Truth {
    /// How many arrivals are marked.
    pub marks: usize,
    /// How many of them were found.
    pub found: usize,
    /// Those that were not.
    pub missed: Vec<Mark>,
    /// Visits, counted from 0, at which nothing is marked.
    pub invented: Vec<usize>,
    /// The places that were visited more than once, and whether they looked the same each time.
    pub stars: Vec<Repeated>,
    /// Pairs of visits to different places that are one place in the preferred map.
    pub merged: Vec<[usize; 2]>,
    /// Pairs of visits to one place that are different places in the preferred map.
    pub split: Vec<[usize; 2]>,
    /// Whether the preferred map is the true one: all marks found, no visit invented, none merged or split. Null
    /// without a preferred map.
    pub map_is_true: Option<bool>,
}

/// A marked arrival.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Mark {
    /// The annotator's name of the place.
    pub place: String,
    /// The scan, counted from 0.
    pub scan: usize,
}

/// The visits to a place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Repeated {
    /// The annotator's name of the place.
    pub place: String,
    /// The visits, counted from 0.
    pub visits: Vec<usize>,
    /// Whether the star of each can be turned onto that of the first.
    pub equal: bool,
}

impl Truth {
    /// Compares marks, and the visit found for each, with the stars of all visits and the place of each in the preferred
    /// map.
    pub fn of(
        marks: Vec<Mark>,
        at: &[Option<usize>],
        visits: &[Arc<Visit>],
        preferred: Option<&[usize]>,
    ) -> Truth {
        let found: Vec<(usize, &str)> =
            marks.iter().zip(at).filter_map(|(mark, at)| at.map(|at| (at, mark.place.as_str()))).collect();
        let missed: Vec<Mark> =
            marks.iter().zip(at).filter(|(_, at)| at.is_none()).map(|(mark, _)| mark.clone()).collect();
        let known = |visit: &usize| found.iter().any(|(at, _)| at == visit);
        let invented: Vec<usize> = (0..visits.len()).filter(|visit| !known(visit)).collect();
        let [merged, split] = preferred.map_or_else(Default::default, |places| differing(&found, places));
        let same = missed.is_empty() && invented.is_empty() && merged.is_empty() && split.is_empty();
        Truth {
            marks: marks.len(),
            found: found.len(),
            stars: repeated(&found, visits),
            missed,
            invented,
            merged,
            split,
            map_is_true: preferred.map(|_| same),
        }
    }
}

/// Pairs of visits that the map takes for one place though they are two, and the other way round.
fn differing(found: &[(usize, &str)], places: &[usize]) -> [Vec<[usize; 2]>; 2] {
    let [mut merged, mut split] = [Vec::new(), Vec::new()];
    for (k, &(a, here)) in found.iter().enumerate() {
        for &(b, there) in &found[k + 1..] {
            match (places.get(a) == places.get(b), here == there) {
                (true, false) => merged.push([a, b]),
                (false, true) => split.push([a, b]),
                _ => {}
            }
        }
    }
    [merged, split]
}

fn repeated(found: &[(usize, &str)], visits: &[Arc<Visit>]) -> Vec<Repeated> {
    let mut places: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    found.iter().for_each(|&(visit, place)| places.entry(place).or_default().push(visit));
    let alike = |a: usize, b: usize| {
        let (Some(a), Some(b)) = (visits.get(a), visits.get(b)) else { return false };
        (0..a.star.size() as u8).any(|rotation| a.star.matches(&b.star, rotation))
    };
    let repeated = places.into_iter().filter(|(_, visits)| visits.len() > 1);
    repeated
        .map(|(place, visits)| {
            let equal = visits.iter().all(|&visit| alike(visits[0], visit));
            Repeated { place: place.to_owned(), visits, equal }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_merges_and_splits_are_named() {
        let found = [(0, "N"), (1, "E"), (3, "N"), (4, "S")];
        assert_eq!(differing(&found, &[0, 1, 2, 0, 1]), [vec![[1, 4]], vec![]]);
        assert_eq!(differing(&found, &[0, 1, 2, 3, 4]), [vec![], vec![[0, 3]]]);
    }

    #[test]
    fn a_mark_missed_is_no_true_map() {
        let marks = ["N", "E"].map(|place| Mark { place: place.into(), scan: 0 }).to_vec();
        let truth = Truth::of(marks.clone(), &[None, None], &[], Some(&[]));
        assert_eq!((truth.found, truth.missed, truth.map_is_true), (0, marks, Some(false)));
        assert_eq!(Truth::of(Vec::new(), &[], &[], None).map_is_true, None);
    }
}
