//! Worlds on the edge of the theory, recorded in `worlds/`: the counts that an enumeration of their own found, and
//! the axiom that refutes the true map where one does.

use crate::engine::{explain, names, stories, story};
use crate::reference::{self, End, Story};
use crate::strategies::{Walk, World};
use crate::traces::visits;
use topostar::abduction::{AxiomId, AxiomSet, Boundary, Profile, Report, Simplicity, Visit};

const PLUS: &str = "a b a b";

/// A walk and its recording, without the ending.
fn recorded(trace: &str, walk: Walk) -> Walk {
    assert_eq!(visits(trace), walk.visits, "worlds/{trace}.ndjson");
    walk
}

/// Path segments around a ring, from the slot `out` of each place to the slot `back` of the next.
fn ring(places: usize, out: usize, back: usize) -> Vec<(End, End)> {
    (0..places).map(|k| ((k, out), ((k + 1) % places, back))).collect()
}

/// Four corners of a ring, and two corridors between opposite ones, one over the other.
fn overpass() -> Walk {
    let stars = ["a b? c a? b c!", "a< b! c a! b c!", "a b! c< a! b< c!", "a b! c a! b c?"];
    let segments = [ring(4, 0, 4), vec![((0, 2), (2, 2)), ((1, 2), (3, 2))]].concat();
    recorded("overpass", World::joined(&stars, &segments).follow((0, 0), &[0, 0, 0, 0, 2, 0, 2, 0]))
}

/// A round street with a side street at each of its three places, no two alike, followed for two laps.
fn boulevard() -> Walk {
    let world = World::joined(&["a b a b!", "a b< a b!", "a b a b?"], &ring(3, 0, 2));
    recorded("boulevard", world.follow((0, 0), &[0; 6]))
}

/// A path that curls and ends at itself, as a 6 does.
fn spiral() -> Walk {
    let segments = [((0, 0), (1, 2)), ((1, 0), (2, 2)), ((2, 0), (1, 1))];
    recorded("spiral", World::joined(&["a a!", "a b a b!", "a b< a b!"], &segments).follow((0, 0), &[0; 3]))
}

/// A straight path, and one that bends from its first crossing with it to its second.
fn crescent() -> Walk {
    let segments = [((0, 1), (1, 3)), ((0, 0), (2, 0)), ((2, 1), (1, 0))];
    recorded("crescent", World::joined(&[PLUS, "a b< a b", "a a"], &segments).follow((0, 1), &[1, 0, 0]))
}

/// A ring of three corners that can be told apart, gone around so often that each of its places comes `times`.
fn cover(times: usize) -> Walk {
    let corners = ["a b< a! b!", "a b a! b?", "a b a? b!"];
    World::joined(&corners.repeat(times), &ring(3 * times, 1, 0)).follow((0, 2), &[1; 12])
}

/// Five corners that look alike, then one that does not, around a ring.
fn late_refutation() -> Walk {
    let corner = "a b a! b!";
    let stars = [corner, corner, corner, corner, corner, "a b a! b?"];
    recorded("late-refutation", World::joined(&stars, &ring(6, 1, 0)).follow((0, 2), &[1; 8]))
}

/// Crossings that all look alike, on a wide grid: around a block, then away.
fn aliased_turns() -> Vec<Visit> {
    let block = World::joined(&[PLUS; 7], &block_segments());
    let walk = block.follow((0, 1), &[1, 2, 3, 0, 0, 1, 1]);
    recorded("aliased-turns", walk).visits
}

/// North-west, north-east, south-east, south-west corner of the block, then north, and twice east.
fn block_segments() -> Vec<(End, End)> {
    vec![
        ((0, 1), (1, 3)),
        ((1, 2), (2, 0)),
        ((2, 3), (3, 1)),
        ((3, 0), (0, 2)),
        ((0, 0), (4, 2)),
        ((4, 1), (5, 3)),
        ((5, 1), (6, 3)),
    ]
}

fn counts(report: &Report) -> Vec<u64> {
    report.candidates_per_observation.iter().map(|count| count.value).collect()
}

fn size(report: &Report) -> (usize, usize) {
    report.simplicity.map(|Simplicity { paths, places, .. }| (paths, places)).unwrap()
}

fn paper() -> AxiomSet {
    AxiomSet::of(Profile::Paper)
}

fn planar() -> AxiomSet {
    paper().with(AxiomId::Planarity)
}

fn hard(axioms: AxiomSet) -> AxiomSet {
    axioms.with_boundary(Some(Boundary::Hard))
}

/// The true map is a candidate up to an observation, at which the axiom, alone of those held, refutes it.
fn refutes_the_truth(walk: &Walk, axioms: AxiomSet, axiom: AxiomId, at: usize) {
    let visits = &walk.visits;
    let alive = |observations: usize| {
        stories(&explain(&visits[..observations], axioms)).contains(&walk.truth[..observations].to_vec())
    };
    assert!(alive(at) && !alive(at + 1));
    let truth: Story = walk.truth[..=at].to_vec();
    let broken: Vec<&str> =
        names(axioms).into_iter().filter(|law| !reference::obeys(&visits[..=at], &truth, law)).collect();
    assert_eq!(broken, [axiom.name()]);
    let refuted = explain(visits, axioms).report().refuted_per_observation[at];
    assert!(refuted.by(axiom) > 0, "{refuted:?}");
}

#[test]
fn planarity_refutes_an_overpass_and_says_so() {
    let walk = overpass();
    refutes_the_truth(&walk, planar(), AxiomId::Planarity, 7);
    let planar = explain(&walk.visits, planar()).report();
    assert_eq!((counts(&planar), size(&planar)), (vec![1, 1, 1, 1, 2, 4, 4, 6, 8], (11, 6)));
    assert!(!planar.unique);
    let paper = explain(&walk.visits, paper()).report();
    assert_eq!((counts(&paper), size(&paper)), (vec![1, 1, 1, 1, 2, 4, 4, 8, 10], (6, 4)));
    assert_eq!(paper.minimal.iter().map(story).collect::<Vec<Story>>(), [walk.truth]);
}

/// What is left is the path that never closes.
#[test]
fn path_order_refutes_a_round_street_and_a_path_that_ends_at_itself() {
    for (walk, at, left) in [(boulevard(), 3, (8, 7)), (spiral(), 3, (4, 4))] {
        for axioms in [paper(), planar()] {
            refutes_the_truth(&walk, axioms, AxiomId::PathOrder, at);
            let report = explain(&walk.visits, axioms).report();
            assert_eq!((report.candidates.value, size(&report)), (1, left));
        }
        let without = paper().without(AxiomId::PathOrder).unwrap();
        let report = explain(&walk.visits, without).report();
        assert!(report.minimal.iter().map(story).any(|minimal| minimal == walk.truth));
    }
}

/// Either path has the second crossing both on it and, by way of the other path, beside it: two exceptions of one
/// pair of paths. Held hard, the axiom refutes what is true.
#[test]
fn a_crescent_is_wrongly_refuted_hard_and_kept_soft() {
    let walk = crescent();
    let report = explain(&walk.visits, paper()).report();
    assert_eq!((counts(&report), size(&report), report.minimal.len()), (vec![1, 1, 1, 3], (2, 3), 2));
    refutes_the_truth(&walk, hard(paper()), AxiomId::Boundary, 3);
    assert_eq!(counts(&explain(&walk.visits, hard(paper())).report()), [1, 1, 1, 1]);
    let soft = explain(&walk.visits, paper().with_boundary(Some(Boundary::Soft)));
    let truth = soft.candidates().find(|candidate| story(candidate) == walk.truth).unwrap();
    let exceptions = topostar::map::Regions::of(&truth.map).abnormalities();
    let pairs: Vec<(u32, u32)> = exceptions.iter().map(|it| (it.path.0, it.carrier.0)).collect();
    assert_eq!(pairs, [(0, 1), (1, 0)]);
    let preferred = soft.report().simplicity.unwrap();
    assert_eq!((preferred.abnormalities, preferred.paths, preferred.places), (Some(0), 4, 4));
}

/// No walk tells a ring from one twice as long whose places come in the same order: both stay, and the shorter one
/// is preferred in either. `unique` says that it is the simplest alone, not that it is all there is.
#[test]
fn a_world_and_its_double_cover_are_never_told_apart() {
    let (base, double) = (cover(1), recorded("double-cover", cover(2)));
    assert_eq!(base.visits, double.visits);
    for axioms in [paper(), planar(), hard(planar())] {
        let found = explain(&double.visits, axioms);
        let report = found.report();
        assert_eq!(counts(&report), [1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5]);
        for truth in [&base.truth, &double.truth] {
            assert!(stories(&found).contains(truth));
        }
        assert_eq!((size(&report), story(&report.minimal[0])), ((3, 3), base.truth.clone()));
        assert!(report.unique && report.candidates.value > 1);
    }
}

/// Three wrong closures were possible, the first of them three observations before.
#[test]
fn a_wrong_closure_falls_with_all_that_came_of_it() {
    let walk = late_refutation();
    for axioms in [paper(), planar()] {
        let report = explain(&walk.visits, axioms).report();
        assert_eq!((counts(&report), size(&report)), (vec![1, 1, 2, 3, 4, 1, 2, 3, 4], (6, 6)));
        let places = |observations: usize| -> Vec<Vec<usize>> {
            let stories = stories(&explain(&walk.visits[..observations], axioms));
            stories.iter().map(|story| story.iter().map(|visit| visit.0).collect()).collect()
        };
        assert_eq!(places(5), [[0, 1, 0, 1, 0], [0, 1, 2, 0, 1], [0, 1, 2, 3, 0], [0, 1, 2, 3, 4]]);
        assert_eq!(places(6), [[0, 1, 2, 3, 4, 5]]);
        assert_eq!(report.refuted_per_observation[5].by(AxiomId::StarMatch), 3);
    }
}

/// A path that goes straight on comes to no place twice; without that law, every crossing may be every other, each
/// way around.
#[test]
fn a_straight_corridor_of_crossings_is_one_map() {
    let segments: Vec<_> = (0..7).map(|k| ((k, 1), (k + 1, 3))).collect();
    let walk = World::joined(&[PLUS; 8], &segments).follow((0, 1), &[1; 7]);
    for axioms in [paper(), planar(), hard(planar())] {
        assert_eq!(counts(&explain(&walk.visits, axioms).report()), [1; 8]);
    }
    let free = explain(&walk.visits, AxiomSet::built_in()).report();
    assert_eq!(counts(&free), [1, 4, 11, 36, 117, 448, 1751, 7688]);
}

#[test]
fn aliased_turns_leave_as_many_maps_as_they_should() {
    let expected = [
        (AxiomSet::built_in(), [1, 4, 11, 33, 96, 247, 725, 2281]),
        (paper(), [1, 1, 3, 7, 19, 35, 125, 331]),
        (planar(), [1, 1, 3, 7, 16, 27, 80, 185]),
        (hard(paper()), [1, 1, 1, 2, 5, 8, 14, 20]),
        (hard(planar()), [1, 1, 1, 2, 5, 8, 14, 20]),
    ];
    for (axioms, expected) in expected {
        assert_eq!(counts(&explain(&aliased_turns(), axioms).report()), expected);
    }
}

/// A crossing can be entered four ways, and each is proposed: to stay there by four gateways, or come to a new one.
#[test]
fn a_symmetric_crossing_is_tried_in_all_its_alignments() {
    let visits = &aliased_turns()[..2];
    let report = explain(visits, paper()).report();
    assert_eq!((report.candidates.value, report.refuted.by(AxiomId::TravelMoves)), (1, 4));
    let rotations: Vec<Story> = stories(&explain(visits, AxiomSet::built_in()));
    let onto = |rotation| vec![(0, 0), (0, rotation)];
    // One of the four would be a gateway that leads to itself.
    assert_eq!(rotations, [onto(0), onto(1), onto(3), vec![(0, 0), (1, 0)]]);
}
