//! Every walk of fourteen travels that covers the twelve corridors of a three by three grid, bare stars: the ranges
//! that an enumeration of their own found.

use crate::engine::{explain, story};
use crate::reference;
use crate::strategies::World;
use topostar::abduction::{AxiomId, AxiomSet, Boundary, Candidate, Profile};
use topostar::map::Regions;

/// North, east, south, west: what a step adds to the number of the place.
const STEPS: [isize; 4] = [-3, 1, 3, -1];

/// The moves of all covering walks from the middle of the upper side. Those from the other sides are these, turned;
/// from other places there are none.
fn covering_walks() -> Vec<Vec<usize>> {
    let mut found = Vec::new();
    cover(1, &mut Vec::new(), &mut Vec::new(), &mut found);
    found
}

fn cover(place: isize, moves: &mut Vec<usize>, used: &mut Vec<(isize, isize)>, found: &mut Vec<Vec<usize>>) {
    let mut distinct = used.clone();
    distinct.sort_unstable();
    distinct.dedup();
    if 12 - distinct.len() > 14 - moves.len() {
        return;
    }
    if moves.len() == 14 {
        return found.push(moves.clone());
    }
    for (way, step) in STEPS.into_iter().enumerate() {
        let (next, same_row) = (place + step, place / 3 == (place + step).div_euclid(3));
        if (0..9).contains(&next) && (way % 2 == 0 || same_row) {
            moves.push(way);
            used.push((place.min(next), place.max(next)));
            cover(next, moves, used, found);
            used.pop();
            moves.pop();
        }
    }
}

/// What the axioms leave of some walks, in a world that says how each place looks.
#[derive(Debug, PartialEq)]
struct Ranges {
    /// Least, median and greatest number of candidates at the end.
    candidates: [usize; 3],
    /// The median of the candidates at all observations together.
    nodes: usize,
    /// On how many walks the true map is minimal.
    minimal: usize,
    /// On how many it is the only one.
    unique: usize,
}

/// On every walk the true map is a candidate.
fn ranges(axioms: AxiomSet, world: &World) -> Ranges {
    let mut ranges = Ranges { candidates: [0; 3], nodes: 0, minimal: 0, unique: 0 };
    let (mut counts, mut nodes) = (Vec::new(), Vec::new());
    for moves in covering_walks() {
        let walk = world.follow((1, 1), &moves);
        let found = explain(&walk.visits, axioms);
        let is_true = |candidate: &Candidate| story(candidate) == walk.truth;
        assert!(found.candidates().any(|candidate| is_true(&candidate)), "{moves:?}");
        counts.push(found.len());
        let report = found.report();
        nodes.push(report.candidates_per_observation.iter().map(|count| count.value as usize).sum());
        let minimal = report.minimal.iter().any(is_true);
        ranges.minimal += usize::from(minimal);
        ranges.unique += usize::from(minimal && report.unique);
    }
    counts.sort_unstable();
    nodes.sort_unstable();
    ranges.candidates = [counts[0], counts[counts.len() / 2], counts[counts.len() - 1]];
    ranges.nodes = nodes[nodes.len() / 2];
    ranges
}

#[test]
fn the_ranges_over_all_covering_walks() {
    let hard = Some(Boundary::Hard);
    let paper = AxiomSet::of(Profile::Paper);
    let planar = paper.with(AxiomId::Planarity);
    let expected = [
        (AxiomSet::built_in().with(AxiomId::TravelMoves), ([41, 100, 228], 291, 0, 0)),
        (paper, ([32, 79, 132], 230, 0, 0)),
        (planar, ([27, 58, 89], 181, 2, 0)),
        (paper.with_boundary(hard), ([28, 67, 120], 191, 0, 0)),
        (planar.with_boundary(hard), ([23, 46, 68], 148, 8, 8)),
    ];
    let grid = World::grid(3, 3);
    for (axioms, (candidates, nodes, minimal, unique)) in expected {
        let expected = Ranges { candidates, nodes, minimal, unique };
        assert_eq!(ranges(axioms, &grid), expected);
    }
}

/// One label in six of those one can follow differs from what is usual. What the axioms could not tell apart, the stars do.
#[test]
fn labels_tell_most_places_apart() {
    let marks = [(0, 1), (2, 2), (4, 0), (7, 1)];
    let world = World::grid(3, 3).marked(&marks);
    let expected = Ranges { candidates: [20, 28, 68], nodes: 88, minimal: 468, unique: 360 };
    assert_eq!(ranges(AxiomSet::of(Profile::Paper), &world), expected);
}

/// The walk by which the counts were first found.
#[test]
fn the_golden_walk() {
    let moves: Vec<usize> = "ESSNWNWSESEWWN".chars().map(|way| "NESW".find(way).unwrap()).collect();
    let walk = World::grid(3, 3).follow((1, 1), &moves);
    let paper = AxiomSet::of(Profile::Paper);
    let bare = vec![1, 1, 1, 1, 1, 1, 2, 4, 4, 8, 10, 16, 16, 16, 32];
    let divided = vec![1, 1, 1, 1, 1, 1, 2, 3, 3, 7, 9, 13, 13, 13, 28];
    let planar = paper.with(AxiomId::Planarity).with_boundary(Some(Boundary::Hard));
    for (axioms, counts, size) in [(paper, bare, (4, 5)), (planar, divided, (5, 7))] {
        let report = explain(&walk.visits, axioms).report();
        let found: Vec<u64> = report.candidates_per_observation.iter().map(|count| count.value).collect();
        assert_eq!(found, counts);
        let simplicity = report.simplicity.unwrap();
        assert_eq!(((simplicity.paths, simplicity.places), report.unique), (size, true));
        let obeys = |law| reference::obeys(&walk.visits, &story(&report.minimal[0]), law);
        assert!(obeys("planarity"));
        // The simplest map without the axiom breaks it: two pairs of paths quarrel.
        let regions = Regions::of(&report.minimal[0].map);
        assert_eq!(regions.abnormalities().len(), if axioms == paper { 2 } else { 0 });
        assert_ne!(story(&report.minimal[0]), walk.truth);
    }
}
