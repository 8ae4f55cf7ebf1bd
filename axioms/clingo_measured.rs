//! The measured axioms by clingo: bounds in whole numbers, and clashes handed in where rules do not reach.

use crate::clingo::{Clingo, on_random, on_the_same};
use crate::engine::{affordable, explain as explain_symbols, stories};
use crate::lengths_and_angles::{few_maps, measured_walks, symbols_and};
use crate::measured::{explain, recorded};
use crate::reference::{MEASURED, Measured, Story};
use crate::strategies::grid_walks;
use proptest::prelude::*;
use std::cell::{Cell, RefCell};
use std::sync::Arc;
use topostar::abduction::{
    Assignment, AxiomId, AxiomSet, Evidence, Profile, REGISTRY, Refutation, Visit, judge,
};
use topostar::export::answer_set::{Bounds, Nogood, Rounding, facts, solve_and_measure};
use topostar::map::PlaceId;
use topostar::metric::{Measurements, MetricParameters};
use topostar::trace::Sighting;

/// Bounds without a world, of the same kind for lengths and bearings.
fn bounds() -> impl Strategy<Value = Bounds> {
    let interval = || (0..20, 0..12).prop_map(|(low, wide)| (low * 300_000, (low + wide) * 300_000));
    let known = |interval| prop_oneof![9 => Just(Some(interval)), 1 => Just(None)];
    let interval = move || interval().prop_flat_map(known);
    let lengths = prop::collection::vec(interval(), 16);
    let bearings = prop::collection::vec(prop::collection::vec(interval(), 4), 16);
    (lengths, bearings).prop_map(|(lengths, bearings)| Bounds { lengths, bearings })
}

/// The bounds of a walk: as many bearings as slots.
fn fitted(bounds: &Bounds, visits: &[Visit]) -> Bounds {
    let mut bounds = bounds.first(visits.len());
    let sized = bounds.bearings.iter_mut().zip(visits);
    sized.for_each(|(slots, visit)| slots.truncate(visit.star.size()));
    bounds
}

#[test]
fn rules_refute_what_bounds_do() {
    let Some(clingo) = Clingo::start("rules_refute_what_bounds_do") else { return };
    let clingo = RefCell::new(clingo);
    let refuted = [Cell::new(0), Cell::new(0)];
    on_the_same(40, (grid_walks(14), bounds()), |(walk, bounds)| {
        let default = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, default);
        let bounds = fitted(&bounds, visits);
        let all = stories(&explain_symbols(visits, default));
        for (law, refuted) in MEASURED.iter().zip(&refuted) {
            let axiom = REGISTRY.iter().find(|axiom| axiom.name == *law).unwrap();
            let held = facts(visits, symbols_and(axiom.id), &[]) + &bounds.facts();
            let mut expected = all.clone();
            expected.retain(|story| !bounds.refute(visits, story, law));
            refuted.set(refuted.get() + all.len() - expected.len());
            prop_assert_eq!(clingo.borrow_mut().models(&held, visits.len(), false), expected, "{}", law);
        }
        Ok(())
    });
    assert!(refuted.iter().all(|count| count.get() > 20), "{refuted:?}");
}

/// A trace with what was measured, and its maps under some symbolic axioms.
struct Case {
    visits: Vec<Visit>,
    all: Vec<Story>,
    measured: Measured,
    evidence: Option<Arc<dyn Evidence>>,
}

/// What came of comparing a case by some axioms.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    /// Maps that the rules of clingo refute.
    by_rules: usize,
    /// Maps that only clashes refute.
    by_clashes: usize,
    /// Maps between bounds rounded outward and inward.
    between: usize,
}

impl Case {
    fn of(seen: &[Sighting], symbols: AxiomSet, most: usize) -> (&[Sighting], Case) {
        let (seen, visits, all) = few_maps(seen, symbols, most);
        let measured = Measured::new(seen, MetricParameters::default());
        let evidence = seen.iter().fold(Measurements::default(), |before, seen| before.with(seen)).evidence();
        (seen, Case { visits, all, measured, evidence })
    }

    /// The clash of a story with the measured axioms of a set: its beginning up to the first visit refuted, as the
    /// engine's measure judges it.
    fn clash(&self, story: &Story, axioms: AxiomSet) -> Option<Nogood> {
        let assignment = |&(place, rotation): &(usize, usize)| Assignment {
            place: PlaceId::new(place).unwrap(),
            rotation: rotation as u8,
        };
        let told: Vec<Assignment> = story.iter().map(assignment).collect();
        let measured = axioms.iter().filter(|axiom| axiom.is_measured());
        let judged = measured.fold(AxiomSet::built_in(), |set, axiom| set.with(axiom.id));
        let Refutation { observation, axiom, .. } =
            judge(&self.visits, self.evidence.as_deref(), judged, &told).err()?;
        Some(Nogood::beginning(axiom.name(), story, observation))
    }

    /// Whether clingo, told what it cannot know, has the maps of the search.
    fn compare(
        &self,
        clingo: &mut Clingo,
        axioms: AxiomSet,
        searched: Vec<Story>,
    ) -> Result<Outcome, TestCaseError> {
        let [outward, inward] = [Rounding::Outward, Rounding::Inward].map(|rounding| {
            let bounds = Bounds::of(&self.measured, rounding);
            facts(&self.visits, axioms, &[]) + &bounds.facts()
        });
        let mut models = |more: &str| clingo.models(more, self.visits.len(), false);
        let (outer, inner) = (models(&outward), models(&inward));
        let within =
            |few: &[Story], many: &[Story]| few.iter().all(|story| many.binary_search(story).is_ok());
        prop_assert!(within(&searched, &outer), "rules refute what is measured not to clash");
        prop_assert!(within(&inner, &outer));
        let found = solve_and_measure(
            |clashes| Ok::<_, TestCaseError>(models(&(outward.clone() + clashes))),
            |story| self.clash(story, axioms),
        )?;
        prop_assert_eq!(&found, &searched, "{:?}", axioms);
        Ok(Outcome {
            by_rules: self.all.len() - outer.len(),
            by_clashes: outer.len() - searched.len(),
            between: outer.len() - inner.len(),
        })
    }
}

/// Beside some symbolic axioms: each measured axiom alone and left out, with its id, then all.
fn measured_sets(symbols: AxiomSet) -> Vec<(AxiomSet, Option<AxiomId>)> {
    let ids: Vec<AxiomId> =
        REGISTRY.iter().filter(|axiom| axiom.is_measured()).map(|axiom| axiom.id).collect();
    let all = ids.iter().fold(symbols, |set, id| set.with(*id));
    let alone = ids.iter().map(|id| (symbols.with(*id), Some(*id)));
    let left_out = ids.iter().map(|id| (all.without(*id).unwrap(), None));
    alone.chain(left_out).chain([(all, None)]).collect()
}

/// Compares random walks by all these sets; for each of them, what came of all walks together.
fn on_walks(clingo: Clingo, symbols: AxiomSet, cases: u32, most: usize) -> Vec<Outcome> {
    let clingo = RefCell::new(clingo);
    let sets = measured_sets(symbols);
    let seen: Vec<Cell<Outcome>> = sets.iter().map(|_| Cell::default()).collect();
    on_the_same(cases, measured_walks(11), |walk| {
        let (walk, case) = Case::of(&walk, symbols, most);
        for ((axioms, _), sum) in sets.iter().zip(&seen) {
            let searched = stories(&explain(walk, *axioms));
            let more = case.compare(&mut clingo.borrow_mut(), *axioms, searched)?;
            let before = sum.get();
            sum.set(Outcome {
                by_rules: before.by_rules + more.by_rules,
                by_clashes: before.by_clashes + more.by_clashes,
                between: before.between + more.between,
            });
        }
        Ok(())
    });
    seen.into_iter().map(Cell::into_inner).collect()
}

#[test]
fn measured_axioms_map_by_map_on_random_walks() {
    let Some(clingo) = Clingo::start("measured_axioms_map_by_map_on_random_walks") else { return };
    let symbols = AxiomSet::of(Profile::Default).without_measured();
    for ((_, alone), found) in measured_sets(symbols).iter().zip(on_walks(clingo, symbols, 40, 100)) {
        let (Outcome { by_rules, by_clashes, between }, name) =
            (found, alone.map_or("several", AxiomId::name));
        println!("{name}: {by_rules} by rules, {by_clashes} by clashes, {between} between roundings");
        assert!(by_rules + by_clashes > 0, "{name} refutes nothing");
        assert_eq!(between, 0, "{name}");
        // A rule that says all leaves no clash; one that says something refutes something.
        match alone {
            Some(AxiomId::Distance) => assert_eq!(by_clashes, 0),
            Some(AxiomId::Closure | AxiomId::Apart) => assert_eq!(by_rules, 0),
            _ => assert!(by_rules > 0),
        }
    }
}

#[test]
fn measured_axioms_beside_fewer_symbolic_ones() {
    for symbols in [AxiomSet::of(Profile::Paper), AxiomSet::built_in()] {
        let Some(clingo) = Clingo::start("measured_axioms_beside_fewer_symbolic_ones") else { return };
        assert!(on_walks(clingo, symbols, 8, 60).iter().all(|found| found.between == 0));
    }
}

#[test]
fn measured_axioms_map_by_map_on_recorded_traces() {
    let Some(mut clingo) = Clingo::start("measured_axioms_map_by_map_on_recorded_traces") else { return };
    for name in ["grid4x4-drift", "rhombus", "ring-10-30"] {
        let seen = recorded(name);
        let symbols = AxiomSet::of(Profile::Default).without_measured();
        let (seen, case) = Case::of(&seen, symbols, 500);
        for (axioms, _) in measured_sets(symbols) {
            let searched = stories(&explain(seen, axioms));
            let outcome = case.compare(&mut clingo, axioms, searched);
            assert_eq!(outcome.unwrap_or_else(|error| panic!("{name}: {error}")).between, 0);
        }
    }
}

/// With bounds without a world, clashes found by measuring models do what rules do.
#[test]
fn measuring_models_and_solving_again_is_exact() {
    let Some(clingo) = Clingo::start("measuring_models_and_solving_again_is_exact") else { return };
    let clingo = RefCell::new(clingo);
    on_random(20, (grid_walks(14), bounds()), |(walk, bounds)| {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let bounds = fitted(&bounds, visits);
        let held = facts(visits, axioms, &[]);
        let solve = |more: &str| -> Result<Vec<Story>, TestCaseError> {
            Ok(clingo.borrow_mut().models(&format!("{held}{more}"), visits.len(), false))
        };
        let measure = |story: &Story| {
            let refuted =
                |length: &usize| bounds.refute(&visits[..*length], &story[..*length].to_vec(), "distance");
            let length = (1..=story.len()).find(refuted)?;
            Some(Nogood::beginning("distance", story, length - 1))
        };
        let mut expected = stories(&explain_symbols(visits, axioms));
        expected.retain(|story| !bounds.refute(visits, story, "distance"));
        prop_assert_eq!(solve_and_measure(solve, measure)?, expected);
        Ok(())
    });
}
