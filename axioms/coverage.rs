//! What random inputs are made of: every kind of star and trace that a test should meet occurs.

use crate::classic;
use crate::clingo::on_the_same;
use crate::engine::{axiom_sets, explain};
use crate::lengths_and_angles::measured_walks;
use crate::strategies::{grid_walks, lies, tangled_walks};
use proptest::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeMap;
use topostar::abduction::{AxiomSet, Profile, REGISTRY, Visit};
use topostar::classic::{Action, Sight};
use topostar::star::{ControlLaw, LargeScaleStar};
use topostar::trace::Sighting;

/// Something that an input may show.
type Kind<T> = (&'static str, fn(&T) -> bool);

const STARS: [Kind<LargeScaleStar>; 7] = [
    ("symmetric", |star| (1..star.size() as u8).any(|rotation| star.matches(star, rotation))),
    ("without symmetry", |star| !(1..star.size() as u8).any(|rotation| star.matches(star, rotation))),
    ("pairing not antipodal", |star| {
        let half = star.size() / 2;
        star.slots()
            .iter()
            .enumerate()
            .any(|(slot, it)| it.opposite.0 as usize != (slot + half) % star.size())
    }),
    ("dead end", |star| star.slots().iter().any(|slot| slot.control == ControlLaw::DeadEnd)),
    ("slot without control", |star| star.slots().iter().any(|slot| slot.control == ControlLaw::None)),
    ("one fragment", |star| star.size() == 2),
    ("three fragments", |star| star.size() == 6),
];

const WALKS: [Kind<Vec<Visit>>; 3] = [
    ("a symmetric star seen twice", |visits| {
        let symmetric = |visit: &Visit| STARS[0].1(&visit.star);
        let twice = |k: usize| (0..k).any(|i| visits[k].star.size() == visits[i].star.size());
        (0..visits.len()).any(|k| symmetric(&visits[k]) && twice(k))
    }),
    ("a turn back", |visits| {
        let back = |pair: &[Visit]| {
            pair[1].departure == Some(pair[0].star.slots()[pair[0].arrival.0 as usize].opposite)
        };
        visits.windows(2).any(back)
    }),
    ("no map", |visits| explain(visits, AxiomSet::of(Profile::Default)).is_empty()),
];

const MEASUREMENTS: [Kind<Vec<Sighting>>; 4] = [
    ("a travel without odometry", |seen| seen[1..].iter().any(|it| it.motion.is_none())),
    ("a start that is guessed", |seen| {
        seen.iter().any(|it| it.motion.as_ref().is_some_and(|motion| !motion.start_given))
    }),
    ("a start that is given", |seen| {
        seen.iter().any(|it| it.motion.as_ref().is_some_and(|motion| motion.start_given))
    }),
    ("a slot without bearing", |seen| {
        seen.iter().any(|it| it.star.slots().iter().any(|slot| slot.bearing.is_none()))
    }),
];

const VIEWS: [Kind<Vec<Sight>>; 5] = [
    ("a turn left", |seen| seen[1..].iter().any(|sight| sight.action == Action::Left)),
    ("a turn right", |seen| seen[1..].iter().any(|sight| sight.action == Action::Right)),
    ("a turn around", |seen| seen[1..].iter().any(|sight| sight.action == Action::Around)),
    ("a travel", |seen| seen[1..].iter().any(|sight| sight.action == Action::Travel)),
    ("a view seen twice", |seen| (1..seen.len()).any(|k| (0..k).any(|i| seen[k].view == seen[i].view))),
];

/// Of 256 inputs that are always the same, how many show each kind; as many as asked for do.
fn occur<T>(what: &str, inputs: impl Strategy<Value = T>, kinds: &[Kind<T>], at_least: usize)
where
    T: std::fmt::Debug,
{
    let counts = RefCell::new(BTreeMap::new());
    on_the_same(256, inputs, |input| {
        for (name, shows) in kinds {
            *counts.borrow_mut().entry(*name).or_insert(0) += usize::from(shows(&input));
        }
        Ok(())
    });
    for (name, count) in counts.into_inner() {
        assert!(count >= at_least, "{what}: {name} in {count} of 256");
    }
}

/// One of the stars of a walk.
fn a_star(walks: impl Strategy<Value = Vec<Visit>>) -> impl Strategy<Value = LargeScaleStar> {
    (walks, any::<prop::sample::Index>())
        .prop_map(|(visits, which)| visits[which.index(visits.len())].star.clone())
}

#[test]
fn every_kind_of_star_occurs() {
    occur("worlds", a_star(tangled_walks(7).prop_map(|walk| walk.visits)), &STARS, 12);
    occur("lies", a_star(lies(7)), &STARS, 12);
    // Grids have neither odd pairings nor slots without control.
    occur("grids", a_star(grid_walks(14).prop_map(|walk| walk.visits)), &[STARS[0], STARS[1], STARS[3]], 12);
}

#[test]
fn every_kind_of_walk_occurs() {
    occur("worlds", tangled_walks(7).prop_map(|walk| walk.visits), &WALKS[..2], 12);
    occur("lies", lies(7), &WALKS, 12);
    occur("measured", measured_walks(11), &MEASUREMENTS, 12);
    occur("views", classic::view_walks(8).prop_map(|walk| walk.seen), &VIEWS, 12);
    occur("lies about views", classic::lies(7), &VIEWS, 12);
}

#[test]
fn every_axiom_is_held_alone_and_left_out() {
    let sets = axiom_sets();
    let (built_in, default) = (AxiomSet::built_in(), AxiomSet::of(Profile::Default));
    assert!(Profile::ALL.into_iter().all(|profile| sets.contains(&AxiomSet::of(profile))));
    for axiom in REGISTRY.iter().filter(|axiom| axiom.switchable && !axiom.is_measured()) {
        assert!(sets.contains(&built_in.with(axiom.id)), "{} alone", axiom.name);
        let other =
            if default.contains(axiom.id) { default.without(axiom.id) } else { Ok(default.with(axiom.id)) };
        assert!(sets.contains(&other.unwrap()), "{} left out", axiom.name);
    }
}

/// Each of them refutes something in the random worlds on which the theories are compared.
#[test]
fn every_axiom_refutes_in_random_worlds() {
    let default = AxiomSet::of(Profile::Default).without_measured();
    for axiom in REGISTRY.iter().filter(|axiom| !axiom.is_measured()) {
        let refuted = RefCell::new(0);
        on_the_same(256, (tangled_walks(7), lies(7)), |(walk, lies)| {
            for visits in [&walk.visits, &lies] {
                let report = explain(visits, default.with(axiom.id)).report();
                *refuted.borrow_mut() += report.refuted.by(axiom.id);
            }
            Ok(())
        });
        assert!(*refuted.borrow() > 0, "{} refutes nothing in 512 worlds", axiom.name);
    }
}
