//! Boundaries: the engine's regions against what a walk along every path sees.

use crate::engine::{affordable, explain, story};
use crate::reference::{self, Evidence};
use crate::strategies::{grid_walks, lies, tangled_walks};
use crate::topology::refutes_what_breaks_it;
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use topostar::abduction::{AxiomId, AxiomSet, Boundary, Candidate, Profile, Visit};
use topostar::map::{Beside, PathId, Regions, TopologicalMap};

pub(crate) fn paths_divide_left_from_right(visits: &[Visit]) -> Result<(), TestCaseError> {
    refutes_what_breaks_it(AxiomId::Boundary, visits)
}

/// Sets of axioms that allow ever more: simple paths, and paths of any kind.
fn permissive() -> [AxiomSet; 2] {
    [AxiomSet::of(Profile::Paper), AxiomSet::built_in()]
}

/// The sides of each path as the engine has them, in the words of the reference.
fn sides(candidate: &Candidate) -> Vec<[Evidence; 2]> {
    let map = &candidate.map;
    let regions = Regions::of(map);
    let paths = topostar::map::Paths::of(map);
    let least = |path: PathId| {
        let dstates = map.dstates().find(|dstate| paths.along(map, *dstate).path == path).unwrap();
        (dstates.place.index(), dstates.slot.0 as usize)
    };
    let side = |side: &[Beside]| -> Evidence {
        let carriers = |it: &Beside| {
            let place = it.place.index();
            it.evidence.iter().map(move |crossing| (place, crossing.carrier)).collect::<Vec<_>>()
        };
        side.iter().flat_map(carriers).map(|(place, carrier)| (place, least(carrier))).collect()
    };
    regions.iter().map(|path| [side(&path.left), side(&path.right)]).collect()
}

/// Whether no conflict is left when the evidence of the abnormal pairs is not believed.
fn settled(map: &TopologicalMap, regions: &Regions) -> bool {
    let abnormal: BTreeSet<(PathId, PathId)> =
        regions.abnormalities().iter().map(|it| (it.path, it.carrier)).collect();
    assert_eq!(abnormal.len(), regions.abnormalities().len());
    let on: BTreeMap<PathId, BTreeSet<usize>> = topostar::map::Paths::of(map)
        .iter()
        .map(|path| (path.id, path.places().map(|place| place.index()).collect()))
        .collect();
    regions.iter().all(|path| {
        let believed = |side: &[Beside]| -> BTreeSet<usize> {
            let counts =
                |it: &&Beside| it.evidence.iter().any(|by| !abnormal.contains(&(path.path, by.carrier)));
            side.iter().filter(counts).map(|it| it.place.index()).collect()
        };
        let (left, right) = (believed(&path.left), believed(&path.right));
        let on = &on[&path.path];
        left.is_disjoint(&right) && left.is_disjoint(on) && right.is_disjoint(on)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn regions_are_those_that_a_walk_along_each_path_sees(walk in tangled_walks(7), lies in lies(7)) {
        for visits in [walk.visits, lies] {
            for axioms in permissive() {
                let visits = affordable(&visits, axioms);
                for candidate in explain(visits, axioms).candidates() {
                    let expected = reference::beside(visits, &story(&candidate));
                    let expected: Vec<[Evidence; 2]> = expected.into_iter().map(|(_, sides)| sides).collect();
                    prop_assert_eq!(sides(&candidate), expected);
                }
            }
        }
    }

    #[test]
    fn abnormalities_are_the_fewest_that_settle_all(walk in tangled_walks(8), grid in grid_walks(12)) {
        for visits in [walk.visits, grid.visits] {
            for axioms in permissive() {
                let visits = affordable(&visits, axioms);
                for candidate in explain(visits, axioms).candidates() {
                    let regions = Regions::of(&candidate.map);
                    let expected = reference::abnormalities(visits, &story(&candidate));
                    prop_assert_eq!(regions.abnormalities().len(), expected);
                    prop_assert_eq!(regions.conflicts().next().is_some(), expected > 0);
                    prop_assert!(settled(&candidate.map, &regions));
                }
            }
        }
    }

    /// What a search that refutes as early as it can relies on.
    #[test]
    fn a_conflict_stays(walk in tangled_walks(8), lies in lies(8)) {
        for visits in [walk.visits, lies] {
            for axioms in permissive() {
                let visits = affordable(&visits, axioms);
                let mut broken: Vec<(reference::Story, bool)> = vec![(vec![], false)];
                for length in 1..=visits.len() {
                    let conflict = |it: &Candidate| Regions::of(&it.map).conflicts().next().is_some();
                    let now: Vec<(reference::Story, bool)> =
                        explain(&visits[..length], axioms).candidates().map(|it| (story(&it), conflict(&it))).collect();
                    for (story, conflict) in &now {
                        let before = broken.iter().find(|(earlier, _)| *earlier == story[..length - 1]).unwrap();
                        prop_assert!(*conflict || !before.1);
                    }
                    broken = now;
                }
            }
        }
    }

    /// To refute every closure that brings a conflict is to refute every map that has one.
    #[test]
    fn refuting_early_is_refuting_late(walk in tangled_walks(10), grid in grid_walks(14), lies in lies(10)) {
        for visits in [walk.visits, grid.visits, lies] {
            for axioms in permissive() {
                let visits = affordable(&visits, axioms);
                let clear = |it: &Candidate| Regions::of(&it.map).conflicts().next().is_none();
                let late: Vec<reference::Story> =
                    explain(visits, axioms).candidates().filter(clear).map(|it| story(&it)).collect();
                let early = explain(visits, axioms.with_boundary(Some(Boundary::Hard)));
                prop_assert_eq!(early.candidates().map(|it| story(&it)).collect::<Vec<_>>(), late);
            }
        }
    }

    #[test]
    fn held_soft_it_refutes_nothing(walk in tangled_walks(8)) {
        for axioms in permissive() {
            let visits = affordable(&walk.visits, axioms);
            let soft = explain(visits, axioms.with_boundary(Some(Boundary::Soft)));
            prop_assert!(soft.candidates().eq(explain(visits, axioms).candidates()));
        }
    }
}
