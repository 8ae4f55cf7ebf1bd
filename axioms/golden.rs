//! The recorded traces give the counts that an independent enumeration found.

use crate::engine::{names, stories};
use crate::reference;
use crate::traces::visits;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Relation, Report, StopReason};
use topostar::map::Paths;

const ACES: &str = "aces-stars";

fn explain(trace: &str, profile: Profile) -> Abduction {
    let mut abduction = Abduction::new(AxiomSet::of(profile), Limits::default());
    for visit in visits(trace) {
        abduction.observe(&visit).unwrap();
    }
    abduction
}

fn counts(report: &Report) -> Vec<u64> {
    assert!(report.candidates_per_observation.iter().all(|count| count.relation == Relation::Equal));
    report.candidates_per_observation.iter().map(|count| count.value).collect()
}

/// Candidates, maps created, paths and places of the minimal maps, and how many of these: different maps, not
/// candidates. In `grid3x3-16` two of the three minimal candidates number the places of one map differently.
fn figures(report: &Report) -> (u64, u64, (usize, usize), usize) {
    assert!(report.complete && report.proven && report.stop_reason == StopReason::Exhausted);
    let simplicity = report.simplicity.unwrap();
    let size = (simplicity.paths, simplicity.places);
    (report.candidates.value, report.maps_created.value, size, report.minimal_maps())
}

#[test]
fn aces_as_in_the_paper() {
    let report = explain(ACES, Profile::Paper).report();
    assert_eq!(counts(&report), [1, 1, 1, 1, 2, 2, 2, 1, 2, 2, 5, 5, 15, 15, 35]);
    assert_eq!(figures(&report), (35, 68, (6, 9), 2));
    assert!(!report.unique);
}

#[test]
fn aces_with_planarity_is_the_true_map_alone() {
    let report = explain(ACES, Profile::Default).report();
    assert_eq!(counts(&report), [1, 1, 1, 1, 2, 2, 2, 1, 2, 2, 5, 5, 13, 13, 23]);
    assert_eq!(figures(&report), (23, 54, (6, 9), 1));
    assert!(report.unique);
    let preferred = &report.minimal[0];
    assert_eq!(preferred.places(), [0, 1, 2, 3, 4, 5, 6, 7, 0, 8, 4, 8, 6, 8, 2]);
    let map = &preferred.map;
    let size = (map.place_count(), map.path_count(), map.segment_count(), map.dstate_count());
    assert_eq!(size, (9, 6, 12, 36));
    assert_eq!(map.segments().len(), 12);
    let paths = Paths::of(map);
    assert!(paths.iter().all(|path| path.stops.len() == 3 && !path.closed));
    let lines: Vec<Vec<usize>> =
        paths.iter().map(|path| path.places().map(|place| place.index()).collect()).collect();
    assert_eq!(lines, [[7, 0, 1], [0, 8, 4], [1, 2, 3], [2, 8, 6], [3, 4, 5], [5, 6, 7]]);
}

#[test]
fn grids() {
    let expected = [
        ("grid3x3-16", (84, 219, (5, 7), 2), (63, 188, (5, 7), 1)),
        ("grid4x3-20", (2030, 5716, (6, 9), 1), (591, 2051, (6, 9), 1)),
        ("grid4x4-24", (55274, 85567, (4, 8), 1), (6329, 13672, (4, 8), 1)),
    ];
    for (trace, paper, default) in expected {
        assert_eq!(figures(&explain(trace, Profile::Paper).report()), paper, "{trace}, paper");
        assert_eq!(figures(&explain(trace, Profile::Default).report()), default, "{trace}, default");
    }
}

#[test]
fn short_traces_give_the_maps_of_the_reference() {
    for (trace, profile) in [
        (ACES, Profile::Paper),
        (ACES, Profile::Default),
        ("grid3x3-16", Profile::Paper),
        ("grid3x3-16", Profile::Default),
    ] {
        let expected = reference::explanations(&visits(trace), &names(AxiomSet::of(profile)), true);
        assert_eq!(stories(&explain(trace, profile)), expected, "{trace}");
    }
}

#[test]
fn two_minimal_candidates_may_be_one_map() {
    let report = explain("grid3x3-16", Profile::Paper).report();
    assert_eq!((report.minimal.len(), report.minimal_maps()), (3, 2));
    assert!(!report.unique);
}

#[test]
fn grid4x4_28() {
    let paper = explain("grid4x4-28", Profile::Paper).report();
    assert_eq!(figures(&paper), (162_190, 239_139, (4, 8), 3));
    let expected = [
        1, 1, 1, 1, 3, 3, 6, 6, 9, 29, 73, 75, 69, 132, 192, 571, 1816, 2247, 2771, 2771, 6281, 16194, 13440,
        13286, 28249, 28249, 28249, 60833, 162_190,
    ];
    assert_eq!(counts(&paper), expected);
    let default = explain("grid4x4-28", Profile::Default).report();
    assert_eq!(figures(&default), (18595, 34319, (4, 8), 1));
}
