//! Left and right: stars as they are listed, mirrored, and named otherwise.

use crate::engine::{affordable, axiom_sets, explain};
use crate::strategies::{Star, Walk, World, mirrored, tangled_walks};
use proptest::prelude::*;
use topostar::abduction::{AxiomSet, Boundary, Profile};
use topostar::map::{Beside, Regions};
use topostar::star::{LargeScaleStar, SlotIndex};

/// The places of the two sides of each path.
fn sides(abduction: &topostar::abduction::Abduction) -> Vec<Vec<[Vec<usize>; 2]>> {
    let places = |side: &[Beside]| side.iter().map(|it| it.place.index()).collect::<Vec<usize>>();
    let sides = |regions: Regions| {
        let mut sides: Vec<_> =
            regions.iter().map(|path| [places(&path.left), places(&path.right)]).collect();
        // Paths are named by their first dstate, and mirroring changes which that is and the way it faces.
        sides.iter_mut().for_each(|sides: &mut [Vec<usize>; 2]| sides.sort());
        sides.sort();
        sides
    };
    let mut all: Vec<_> = abduction.candidates().map(|it| sides(Regions::of(&it.map))).collect();
    all.sort();
    all
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// No axiom prefers a hand.
    #[test]
    fn a_mirrored_world_has_the_mirrored_maps(walk in tangled_walks(8)) {
        let soft = AxiomSet::of(Profile::Paper).with_boundary(Some(Boundary::Soft));
        for axioms in axiom_sets().into_iter().chain([soft]) {
            let visits = affordable(&walk.visits, axioms);
            let (found, mirrored) = (explain(visits, axioms), explain(&mirrored(visits), axioms));
            let (report, image) = (found.report(), mirrored.report());
            prop_assert_eq!(&report.candidates_per_observation, &image.candidates_per_observation);
            prop_assert_eq!((report.simplicity, report.minimal.len()), (image.simplicity, image.minimal.len()));
            prop_assert_eq!(sides(&found), sides(&mirrored));
        }
    }
}

fn large(text: &str) -> LargeScaleStar {
    Star::written(text).large_scale()
}

fn listed(slots: impl Iterator<Item = SlotIndex>) -> Vec<u8> {
    slots.map(|slot| slot.0).collect()
}

/// The star of the seed's Figure 3(b), whose fragments are not antipodal, and that of Figure 3(e).
#[test]
fn left_and_right_are_those_of_the_figures() {
    let star = large("a b c! d a d! c b!");
    assert_eq!(listed(star.right_of(SlotIndex(0))), [1, 2, 3]);
    assert_eq!(listed(star.left_of(SlotIndex(0))), [5, 6, 7]);
    assert_eq!(listed(star.right_of(SlotIndex(1))), [2, 3, 4, 5, 6]);
    assert_eq!(listed(star.left_of(SlotIndex(1))), [0]);
    let star = large("a< b? a b<");
    assert_eq!(listed(star.right_of(SlotIndex(0))), [1]);
    assert_eq!(listed(star.left_of(SlotIndex(0))), [3]);
}

proptest! {
    #[test]
    fn right_of_a_slot_is_left_of_its_opposite(walk in tangled_walks(1)) {
        let star = &walk.visits[0].star;
        for slot in (0..star.size() as u8).map(SlotIndex) {
            let opposite = star.slots()[slot.0 as usize].opposite;
            let (mut right, left) = (listed(star.right_of(slot)), listed(star.left_of(slot)));
            prop_assert_eq!(&right, &listed(star.left_of(opposite)));
            right.extend(left);
            right.extend([slot.0, opposite.0]);
            right.sort_unstable();
            prop_assert!(right.into_iter().eq(0..star.size() as u8));
        }
    }
}

/// Two rings of one place each kind, one a left turn, one the same in a mirror, told apart by one wall.
#[test]
fn a_left_turn_is_never_taken_for_its_mirror_image() {
    let (left, right) = ("a b< a! b?", "a b? a! b<");
    assert!(large(left).alignments(&large(right)).is_empty());
    assert_eq!(large(left).alignments(&large(left)), [0]);
    let walk: Walk =
        World::joined(&[left, right], &[((0, 1), (1, 3)), ((1, 0), (0, 0))]).follow((0, 2), &[1, 0, 1, 0, 1]);
    for candidate in explain(&walk.visits, AxiomSet::built_in()).candidates() {
        let places = candidate.places();
        assert!((0..places.len()).all(|k| (0..k).all(|j| places[k] != places[j] || (k - j) % 2 == 0)));
    }
}
