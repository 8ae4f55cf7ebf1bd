//! Rings of identical left-turn corners: what the axioms can tell of how long they are.

use crate::engine::{explain, story};
use crate::strategies::{Walk, World};
use topostar::abduction::{AxiomSet, Boundary, Profile, Simplicity};

/// A corner: the way back, the way on to its left, and where both end.
const CORNER: &str = "a b a! b!";

fn laps(corners: usize, laps: usize) -> Walk {
    let segments: Vec<_> = (0..corners).map(|k| ((k, 1), ((k + 1) % corners, 0))).collect();
    World::joined(&vec![CORNER; corners], &segments).follow((0, 2), &vec![1; corners * laps])
}

/// A travel may close a ring of any length up to that walked, or none: one candidate more each, and each goes on.
/// With `least` the least ring that may close.
fn candidates(travels: usize, least: usize) -> Vec<u64> {
    (0..=travels).map(|travel| (travel + 2).saturating_sub(least).max(1) as u64).collect()
}

#[test]
fn a_ring_of_any_length_is_taken_for_the_shortest() {
    let hard = Some(Boundary::Hard);
    for corners in 3..=8 {
        for profile in Profile::ALL {
            let walk = laps(corners, 2);
            // Two paths that join two places twice are the least ring of strictly ordered paths; a path that has
            // places on one side of it only is one of a triangle.
            let axioms = AxiomSet::of(profile);
            for (axioms, least) in [(axioms, 2), (axioms.with_boundary(hard), 3)] {
                let found = explain(&walk.visits, axioms);
                let report = found.report();
                let counts: Vec<u64> =
                    report.candidates_per_observation.iter().map(|count| count.value).collect();
                assert_eq!(counts, candidates(2 * corners, least));
                let simplest = Simplicity { abnormalities: None, paths: least, places: least };
                assert_eq!((report.simplicity, report.unique), (Some(simplest), true));
                assert!(found.candidates().any(|candidate| story(&candidate) == walk.truth));
            }
            // After two laps, as many candidates as travels.
            assert_eq!(explain(&walk.visits, axioms).len(), 2 * corners);
        }
    }
}

/// Without any law of paths, one place explains it all.
#[test]
fn without_path_axioms_a_ring_is_one_place() {
    let report = explain(&laps(4, 2).visits, AxiomSet::built_in()).report();
    assert_eq!(report.simplicity.map(|simplicity| simplicity.places), Some(1));
}

/// Held soft, a boundary makes the triangle the simplest map, and what it ranks lower stays.
#[test]
fn held_soft_boundaries_prefer_the_triangle() {
    let paper = AxiomSet::of(Profile::Paper);
    let found = explain(&laps(5, 2).visits, paper.with_boundary(Some(Boundary::Soft)));
    let simplest = Simplicity { abnormalities: Some(0), paths: 3, places: 3 };
    assert_eq!(found.report().simplicity, Some(simplest));
    assert_eq!(found.len(), explain(&laps(5, 2).visits, paper).len());
}
