//! What a trace may hold that is small, wrong or too much: defined behaviour, and counts that say what they are.

use crate::engine::{explain, names, stories};
use crate::reference;
use crate::strategies::{Star, World, renamed, tangled_walks};
use crate::traces::visits;
use proptest::prelude::*;
use topostar::abduction::{Abduction, AxiomId, AxiomSet, Limits, Profile, Relation, StopReason, Visit};
use topostar::map::Regions;
use topostar::star::{SlotIndex, SmallScaleStar, StarError};

fn visit(departure: Option<u8>, star: &str, arrival: u8) -> Visit {
    let star = Star::written(star).large_scale();
    Visit { departure: departure.map(SlotIndex), star, arrival: SlotIndex(arrival) }
}

#[test]
fn a_world_of_one_place_is_one_map() {
    for profile in Profile::ALL {
        let found = explain(&[visit(None, "a a!", 0)], AxiomSet::of(profile));
        let report = found.report();
        assert!(report.unique && report.proven && report.complete);
        let map = &report.minimal[0].map;
        assert_eq!((map.place_count(), map.path_count(), map.segment_count()), (1, 1, 0));
        assert_eq!(Regions::of(map).conflicts().count(), 0);
    }
}

#[test]
fn a_star_without_gateways_is_refused() {
    assert_eq!(SmallScaleStar::new(Vec::new()), Err(StarError::Empty));
    assert_eq!(Star::written("a! a!").small_scale(), Err(StarError::NoGateway(0)));
}

/// A dead end is left by the gateway it was entered by, and the travel back leads where the robot came from.
#[test]
fn turning_around_in_a_dead_end_leads_back() {
    let walk = World::joined(&["a a!", "a? a"], &[((0, 0), (1, 1))]).follow((0, 0), &[0, 1, 0, 1]);
    for profile in Profile::ALL {
        let found = explain(&walk.visits, AxiomSet::of(profile));
        assert_eq!(stories(&found), vec![walk.truth.clone()]);
        assert_eq!(found.report().refuted.total(), 0);
    }
}

/// A loop that leads back to the gateway it left by has no far end in the theory: it is taken for a way to a place of
/// its own that looks the same.
#[test]
fn a_travel_back_to_the_same_gateway_is_a_new_place() {
    let star = "a b< a! b!";
    let visits = [visit(None, star, 2), visit(Some(1), star, 3)];
    for axioms in [AxiomSet::of(Profile::Paper), AxiomSet::built_in()] {
        let found = explain(&visits, axioms);
        assert_eq!(stories(&found), [[(0, 0), (1, 0)]]);
        assert_eq!(stories(&found), reference::explanations(&visits, &names(axioms), true));
    }
}

/// Stars are taken as seen. A gateway too many at a place known by the way there leaves no map, and the report says
/// where and why.
#[test]
fn a_spurious_gateway_at_a_known_place_leaves_no_map() {
    for profile in Profile::ALL {
        let report = explain(&visits("gateway-spurious"), AxiomSet::of(profile)).report();
        let extinction = report.extinction.unwrap();
        assert_eq!((extinction.observation, extinction.axioms), (3, vec![AxiomId::StarMatch]));
        assert_eq!(report.stop_reason, StopReason::Inconsistent { observation: 3 });
    }
}

/// A gateway missed when a loop closes hides the closure: maps remain, and none is true.
#[test]
fn a_missed_gateway_where_a_loop_closes_makes_a_place_of_its_own() {
    let segments = [((0, 1), (1, 0)), ((1, 1), (2, 0)), ((2, 1), (0, 0))];
    let ring = World::joined(&["a b c a! b! c!", "a b< a! b!", "a b a! b?"], &segments);
    let walk = ring.follow((0, 3), &[1, 1, 1, 1]);
    let axioms = AxiomSet::of(Profile::Default);
    assert!(stories(&explain(&walk.visits, axioms)).contains(&walk.truth));
    let mut missed = walk.visits[..4].to_vec();
    missed[3] = visit(Some(1), "a b a! b!", 2);
    let found = explain(&missed, axioms);
    assert_eq!(stories(&found), [[(0, 0), (1, 0), (2, 0), (3, 0)]]);
    assert_eq!(found.report().stop_reason, StopReason::Exhausted);
}

/// Fourteen travels between crossings that all look alike, with room for a thousand candidates.
#[test]
fn a_budget_gives_an_answer_and_says_what_it_is() {
    let star = "a b a b";
    let moves = [1, 2, 3, 0, 0, 1, 1, 2, 2, 3, 0, 1, 2, 2];
    let mut visits = vec![visit(None, star, 1)];
    visits.extend(moves.map(|way| visit(Some(way), star, way)));
    let axioms = AxiomSet::of(Profile::Default);
    let mut abduction = Abduction::new(axioms, Limits { max_candidates: Some(1000), ..Limits::default() });
    let exact = explain(&visits[..8], axioms).report();
    for (observation, visit) in visits.iter().enumerate() {
        abduction.observe(visit).unwrap();
        let report = abduction.report();
        assert!(abduction.len() <= 1000 && !report.minimal.is_empty(), "observation {observation}");
        let cut = report.candidates.relation == Relation::AtLeast;
        assert_eq!((report.complete, report.proven), (!cut, !cut));
        assert!(!(cut && report.unique));
    }
    let report = abduction.report();
    assert_eq!(report.candidates_per_observation[..8], exact.candidates_per_observation);
    let StopReason::CandidateLimit { observation } = report.stop_reason else { panic!("{report:?}") };
    for (k, count) in report.candidates_per_observation.iter().enumerate() {
        assert_eq!(count.relation == Relation::AtLeast, k >= observation);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// Which direction of a fragment is `+`, and what fragments and gateways are called, is the observer's choice.
    #[test]
    fn names_and_signs_change_nothing(walk in tangled_walks(6), by in any::<u32>()) {
        for visit in &walk.visits {
            let star = Star::of(&visit.star);
            let other = renamed(&star.small_scale().unwrap(), by);
            prop_assert_eq!(other.large_scale(), visit.star.clone());
        }
    }
}
