//! Profile `classic` by clingo: the maps of the reference by every set of axioms, those of the search by all.

use crate::classic::{exhaustive, lies, minimal, stories, view_walks};
use crate::classic_golden::recorded_views;
use crate::clingo::{Clingo, on_the_same};
use crate::reference::views::{self as reference, LAWS};
use proptest::prelude::*;
use std::cell::{Cell, RefCell};
use topostar::classic::Sight;
use topostar::export::answer_set::{VIEWS, view_facts};

/// All axioms, none, each alone and each left out.
fn law_sets() -> Vec<Vec<&'static str>> {
    let alone = LAWS.map(|law| vec![law]);
    let left_out = LAWS.map(|law| LAWS.into_iter().filter(|other| *other != law).collect());
    [LAWS.to_vec(), Vec::new()].into_iter().chain(alone).chain(left_out).collect()
}

/// Candidates and preferred candidates of search, reference and clingo.
fn all_agree(clingo: &mut Clingo, seen: &[Sight]) -> Result<(), TestCaseError> {
    let facts = view_facts(seen, &LAWS);
    let mut models = |preferred| clingo.models_of(&VIEWS, &facts, seen.len(), preferred);
    let found = exhaustive(seen);
    prop_assert_eq!(models(false), stories(&found));
    prop_assert_eq!(models(true), minimal(&found.report()));
    Ok(())
}

#[test]
fn random_views_in_every_set_of_axioms() {
    let Some(clingo) = Clingo::start("random_views_in_every_set_of_axioms") else { return };
    let clingo = RefCell::new(clingo);
    let sets = law_sets();
    let maps: Vec<Cell<usize>> = sets.iter().map(|_| Cell::default()).collect();
    on_the_same(40, (view_walks(6), lies(6)), |(walk, lies)| {
        for seen in [&walk.seen, &lies] {
            for (laws, maps) in sets.iter().zip(&maps) {
                let expected = reference::explanations(seen, laws, true);
                maps.set(maps.get() + expected.len());
                let facts = view_facts(seen, laws);
                let models = clingo.borrow_mut().models_of(&VIEWS, &facts, seen.len(), false);
                prop_assert_eq!(models, expected, "{:?}", laws);
            }
            all_agree(&mut clingo.borrow_mut(), seen)?;
        }
        Ok(())
    });
    // Each axiom refutes something by itself, and something that no other does.
    let [all, none] = [0, 1].map(|set| maps[set].get());
    for (law, set) in LAWS.iter().zip(2..) {
        assert!(maps[set].get() < none, "{law} alone refutes nothing");
        assert!(maps[set + LAWS.len()].get() > all, "nothing is refuted by {law} only");
    }
}

#[test]
fn the_recorded_route_as_far_as_it_is_short() {
    let Some(mut clingo) = Clingo::start("the_recorded_route_as_far_as_it_is_short") else { return };
    let seen = recorded_views();
    for length in [1, 8, 16] {
        all_agree(&mut clingo, &seen.as_slice()[..length])
            .unwrap_or_else(|error| panic!("{length}: {error}"));
    }
}
