//! The reasons given are true: counted by brute force, judged by the reference, and tried out on the search.

use crate::engine::{affordable, axiom_sets, explain, stories, story};
use crate::reference::{self, Story};
use crate::strategies::{grid_walks, lies, tangled_walks};
use proptest::prelude::*;
use std::collections::BTreeSet;
use topostar::abduction::{
    Abduction, Assertion, Assignment, AxiomId, AxiomSet, Candidate, Limits, Profile, REGISTRY, Refutation,
    Visit, proposed,
};
use topostar::explanation::{
    Ending, Node, Opinion, Prospect, Reason, Verdict, children, difference, ended, node, outlook, together,
    verdict,
};
use topostar::map::{DstateId, PlaceId, TopologicalMap};
use topostar::star::{LargeScaleStar, SlotIndex};

fn is_refuted_by_the_reference(
    visits: &[Visit],
    beginning: &[Assignment],
    assignment: Assignment,
    refutation: &Refutation,
) -> Result<(), TestCaseError> {
    let whole = [beginning, &[assignment]].concat();
    let story: Story = whole.iter().map(|it| (it.place.index(), it.rotation as usize)).collect();
    let name = refutation.axiom.name();
    prop_assert!(!reference::obeys(&visits[..story.len()], &story, name), "{:?} by {}", story, name);
    prop_assert_eq!(refutation.observation, beginning.len());
    let clash = &refutation.clash;
    prop_assert!(
        clash.observations.is_sorted() && clash.observations.last() == Some(&refutation.observation)
    );
    prop_assert!(!clash.words.is_empty() && !clash.places.is_empty());
    Ok(())
}

/// What is proposed once more for every candidate is what the search made and counted.
fn proposals_are_those_of_the_search(visits: &[Visit], axioms: AxiomSet) -> Result<(), TestCaseError> {
    for seen in 1..visits.len() {
        let (before, after) = (explain(&visits[..seen], axioms), explain(&visits[..=seen], axioms));
        let mut counts = vec![0; REGISTRY.len()];
        let mut kept: Vec<Vec<Assignment>> = Vec::new();
        for candidate in before.candidates() {
            for child in proposed(visits, None, axioms, &candidate.visits).unwrap() {
                match &child.refutation {
                    None => kept.push([candidate.visits.as_slice(), &[child.assignment]].concat()),
                    Some(refutation) => {
                        counts[refutation.axiom as usize] += 1;
                        is_refuted_by_the_reference(visits, &candidate.visits, child.assignment, refutation)?;
                    }
                }
            }
        }
        let made: Vec<Vec<Assignment>> = after.candidates().map(|candidate| candidate.visits).collect();
        prop_assert_eq!(kept, made);
        let counted = after.report().refuted_per_observation[seen];
        let expected: Vec<u64> = REGISTRY.iter().map(|axiom| counted.by(axiom.id)).collect();
        prop_assert_eq!(counts, expected);
    }
    Ok(())
}

/// Whether a candidate takes a visit for the place of another under the same turn as another candidate does.
fn agrees(own: &Candidate, other: &Candidate, visit: usize, first: usize) -> bool {
    let size = own.map.star(own.visits[visit].place).size();
    let turn = |it: &Candidate| {
        (size + it.visits[visit].rotation as usize - it.visits[first].rotation as usize) % size
    };
    other.visits[visit].place == other.visits[first].place && turn(own) == turn(other)
}

fn what_is_said_of_two_visits_is_true(
    abduction: &Abduction,
    index: usize,
    pair: [usize; 2],
) -> Result<(), TestCaseError> {
    let all: Vec<Candidate> = abduction.candidates().collect();
    let own = &all[index];
    let is_one = |it: &Candidate| it.visits[pair[0]].place == it.visits[pair[1]].place;
    let found = together(abduction, index, pair).unwrap();
    let one = all.iter().filter(|it| is_one(it)).count() as u64;
    prop_assert_eq!((found.together.value, found.apart.value), (one, all.len() as u64 - one));
    let rivals = || (0..all.len()).filter(|&it| is_one(&all[it]) != is_one(own));
    let simplest = rivals().min_by_key(|&it| (all[it].simplicity(abduction.axioms()), it));
    prop_assert_eq!(found.rival.as_ref().map(|rival| rival.candidate), simplest);
    prop_assert_eq!(
        found.rival.map(|rival| rival.simplicity),
        simplest.map(|it| all[it].simplicity(abduction.axioms()))
    );
    let minimal = abduction.minimal();
    prop_assert_eq!(found.minimal_rivals, rivals().filter(|it| minimal.contains(it)).collect::<Vec<_>>());
    match found.opinion {
        Opinion::One { place, reasons } => {
            prop_assert!(is_one(own) && own.visits[pair[1]].place == place && !reasons.is_empty());
            let closes = |it: &Candidate, reason: &Reason| match *reason {
                Reason::Closure { observation, first, .. } => agrees(own, it, observation, first),
                Reason::Known { .. } => true,
            };
            for other in all.iter().filter(|it| reasons.iter().all(|reason| closes(it, reason))) {
                prop_assert!(is_one(other));
            }
        }
        Opinion::Two { alternatives, difference, .. } => {
            prop_assert!(!is_one(own));
            prop_assert_eq!(alternatives.is_empty(), difference.is_some());
            let later = pair[0].max(pair[1]);
            let visits: Vec<Visit> = abduction.visits().iter().map(|visit| visit.as_ref().clone()).collect();
            let then = explain(&visits[..=later], abduction.axioms());
            for child in alternatives {
                let whole = [&own.visits[..later], &[child.assignment]].concat();
                let open = then.candidates().any(|it| it.visits == whole);
                prop_assert_eq!(child.refutation.as_ref().is_none_or(|it| it.observation > later), open);
                let alive = all.iter().any(|it| it.visits.starts_with(&whole));
                prop_assert_eq!(child.refutation.is_none(), alive);
                if let Some(refutation) = child.refutation {
                    let then = explain(&visits[..refutation.observation], abduction.axioms());
                    let alive = then.candidates().any(|it| it.visits.starts_with(&whole));
                    prop_assert_eq!(alive, refutation.observation > later);
                }
            }
        }
    }
    Ok(())
}

/// Whether two dstates lie on one path: walking on from one in both directions the other is passed.
fn on_one_path(map: &TopologicalMap, a: DstateId, b: DstateId) -> bool {
    let passed = |start: DstateId| {
        let mut passed = vec![start];
        while let Some(next) = map.far_end(passed[passed.len() - 1]).map(|far| map.opposite(far)) {
            if next == start {
                break;
            }
            passed.push(next);
        }
        passed
    };
    [a, map.opposite(a)].into_iter().flat_map(passed).any(|it| it == b || map.opposite(it) == b)
}

fn left_by(visits: &[Visit], candidate: &Candidate, travel: usize) -> DstateId {
    let before = candidate.visits[travel - 1];
    let size = candidate.map.star(before.place).size();
    let slot = (visits[travel].departure.unwrap().0 as usize + before.rotation as usize) % size;
    DstateId { place: before.place, slot: SlotIndex(slot as u8) }
}

fn pairs(from: usize, to: usize, joined: impl Fn(usize, usize) -> bool) -> Vec<[usize; 2]> {
    (from..to).flat_map(|a| (a + 1..to).map(move |b| [a, b])).filter(|&[a, b]| joined(a, b)).collect()
}

fn the_difference_is_that_of_the_pairs(
    visits: &[Visit],
    abduction: &Abduction,
    both: [usize; 2],
) -> Result<(), TestCaseError> {
    let found = difference(abduction, both).unwrap();
    let [one, other] = both.map(|index| abduction.candidate(index).unwrap());
    let n = visits.len();
    let place = |it: &Candidate, a: usize, b: usize| it.visits[a].place == it.visits[b].place;
    let path = |it: &Candidate, a, b| on_one_path(&it.map, left_by(visits, it, a), left_by(visits, it, b));
    let places = [
        pairs(0, n, |a, b| place(&one, a, b) && !place(&other, a, b)),
        pairs(0, n, |a, b| !place(&one, a, b) && place(&other, a, b)),
    ];
    let paths = [
        pairs(1, n, |a, b| path(&one, a, b) && !path(&other, a, b)),
        pairs(1, n, |a, b| !path(&one, a, b) && path(&other, a, b)),
    ];
    prop_assert_eq!((&found.places, &found.paths), (&places, &paths));
    prop_assert_eq!(found.parting, (0..n).find(|&k| story(&one)[k] != story(&other)[k]));
    prop_assert_eq!(found.parting.is_none(), both[0] == both[1]);
    if both[0] == both[1] {
        prop_assert!(places.iter().chain(&paths).all(Vec::is_empty) && found.rotations.is_empty());
    }
    let other_way = difference(abduction, [both[1], both[0]]).unwrap();
    prop_assert_eq!(other_way.reversed(), found);
    Ok(())
}

/// The walk along a route, with these stars seen, each listed from the gateway come in by.
fn walked(abduction: &Abduction, turns: &[u8], stars: &[LargeScaleStar]) -> Abduction {
    let mut walked = abduction.clone();
    for (turn, star) in turns.iter().zip(stars) {
        let last = walked.visits().last().unwrap().clone();
        let departure = SlotIndex(((last.arrival.0 as usize + *turn as usize) % last.star.size()) as u8);
        let arrival = star.slots()[0].opposite;
        walked.observe(&Visit { departure: Some(departure), star: star.clone(), arrival }).unwrap();
    }
    walked
}

/// How many candidates nothing comes of.
fn fallen(before: &Abduction, after: &Abduction) -> u64 {
    let alive: BTreeSet<Vec<Assignment>> =
        after.candidates().map(|it| it.visits[..before.observations()].to_vec()).collect();
    (before.len() - alive.len()) as u64
}

/// What the map of a candidate says is seen on a route.
fn expected_stars(own: &Candidate, prospect: &Prospect) -> Vec<LargeScaleStar> {
    let seen = |gateway: &DstateId| {
        let far = own.map.far_end(*gateway)?;
        Some(own.map.star(far.place).listed_from(far.slot))
    };
    prospect.route.iter().map_while(seen).collect()
}

fn what_falls_is_what_the_search_refutes(abduction: &Abduction, index: usize) -> Result<(), TestCaseError> {
    let outlook = outlook(abduction, index).unwrap();
    let own = abduction.candidate(index).unwrap();
    // Seen nowhere: stars of the strategies have fewer fragments.
    let novel = crate::strategies::unheard_of();
    for prospect in &outlook.prospects {
        let expected = expected_stars(&own, prospect);
        let total: u64 = prospect.predictions.iter().map(|it| it.candidates).sum();
        prop_assert_eq!((total, outlook.candidates.value), (abduction.len() as u64, abduction.len() as u64));
        // What could be seen: what is predicted for a travel, and what nobody predicts.
        let mut outcomes: Vec<(usize, Option<LargeScaleStar>, u64)> = Vec::new();
        let predicted =
            prospect.predictions.iter().filter_map(|it| Some((it.travel, Some(it.star.clone()?))));
        for (travel, star) in predicted.chain((0..prospect.route.len()).map(|travel| (travel, None))) {
            let last = star.clone().unwrap_or_else(|| novel.clone());
            let stars: Vec<LargeScaleStar> = expected[..travel].iter().cloned().chain([last]).collect();
            let falls = fallen(abduction, &walked(abduction, &prospect.turns, &stars));
            outcomes.push((travel, star, falls));
        }
        for prediction in &prospect.predictions {
            let possible = outcomes.iter().filter(|(travel, star, _)| match &prediction.star {
                Some(own) => *travel == prediction.travel && star.as_ref() == Some(own),
                None => *travel >= prediction.travel,
            });
            prop_assert_eq!(Some(prediction.falls), possible.map(|outcome| outcome.2).min());
        }
        prop_assert_eq!(Some(prospect.worst), prospect.predictions.iter().map(|it| it.falls).min());
    }
    // Every gateway is named that a walk along known path segments reaches, which is every one of a connected map.
    let named: BTreeSet<DstateId> = outlook.prospects.iter().map(|it| it.gateway).collect();
    let navigable = |it: &DstateId| own.map.star(it.place).slots()[it.slot.0 as usize].navigable;
    prop_assert_eq!(named, own.map.dstates().filter(navigable).collect::<BTreeSet<_>>());
    Ok(())
}

fn the_tree_holds_all_candidates(
    visits: &[Visit],
    abduction: &Abduction,
    parent: &Node,
) -> Result<(), TestCaseError> {
    let alive = children(abduction, parent);
    let beginning = abduction.candidate(parent.first).unwrap().visits[..=parent.observation].to_vec();
    let begins_so = |it: &Candidate| it.visits[..=parent.observation] == beginning[..];
    prop_assert_eq!(abduction.candidates().filter(begins_so).count(), parent.leaves);
    let dead = ended(abduction, parent);
    if parent.observation + 1 == visits.len() {
        prop_assert!(alive.is_empty() && dead.is_empty());
        return Ok(());
    }
    prop_assert_eq!(alive.iter().map(|child| child.leaves).sum::<usize>(), parent.leaves);
    prop_assert!(alive.is_sorted_by(|a, b| a.assignment < b.assignment));
    for child in &dead {
        prop_assert!(alive.iter().all(|it| it.assignment != child.assignment));
        if let Ending::Refuted(refutation) = &child.ending {
            is_refuted_by_the_reference(visits, &beginning, child.assignment, refutation)?;
        }
    }
    alive.iter().try_for_each(|child| the_tree_holds_all_candidates(visits, abduction, child))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn refuted_children_are_found_again(tangled in tangled_walks(7), lies in lies(7)) {
        for axioms in axiom_sets() {
            proposals_are_those_of_the_search(affordable(&tangled.visits, axioms), axioms)?;
            proposals_are_those_of_the_search(affordable(&lies, axioms), axioms)?;
        }
    }

    #[test]
    fn any_assignment_has_its_verdict(
        walk in tangled_walks(5),
        drawn in prop::collection::vec((0usize..4, 0u8..5), 6),
        said in prop::option::of((0usize..6, 0usize..6, any::<bool>())),
    ) {
        let axioms = AxiomSet::of(Profile::Default);
        let visits = affordable(&walk.visits, axioms);
        let mut abduction = explain(visits, axioms);
        if let Some((a, b, same)) = said.filter(|(a, b, _)| a != b && *a.max(b) < visits.len()) {
            abduction.assert(Assertion { id: 0, visits: [a, b], same }).unwrap();
        }
        let free = stories(&explain(visits, axioms));
        let assignment = |&(place, rotation): &(usize, u8)| Assignment { place: PlaceId::new(place).unwrap(), rotation };
        let drawn: Vec<Assignment> = drawn.iter().take(visits.len()).map(assignment).collect();
        let kept: Vec<Candidate> = abduction.candidates().collect();
        for whole in explain(visits, axioms).candidates().map(|it| it.visits).chain([drawn]) {
            let told: Story = whole.iter().map(|it| (it.place.index(), it.rotation as usize)).collect();
            let position = kept.iter().position(|it| it.visits == whole);
            match verdict(&abduction, &whole).unwrap() {
                Verdict::Kept(index) => prop_assert_eq!(position, Some(index)),
                Verdict::Forbidden(said) => prop_assert!(free.contains(&told) && !said.is_empty() && position.is_none()),
                Verdict::Refuted(_) => prop_assert!(!free.contains(&told)),
                Verdict::Cut => prop_assert!(false, "nothing was cut"),
            }
        }
        prop_assert_eq!(verdict(&abduction, &[]), None);
    }

    #[test]
    fn two_visits(tangled in tangled_walks(8), grid in grid_walks(14), a in 0usize..15, b in 0usize..15, at in 0usize..120) {
        for visits in [tangled.visits, grid.visits] {
            let axioms = AxiomSet::of(Profile::Paper);
            let visits = affordable(&visits, axioms);
            let abduction = explain(visits, axioms);
            let [a, b] = [a % visits.len(), b % visits.len()];
            if a == b {
                prop_assert_eq!(together(&abduction, 0, [a, b]), None);
            } else {
                what_is_said_of_two_visits_is_true(&abduction, at % abduction.len(), [a, b])?;
            }
        }
    }

    #[test]
    fn differences(tangled in tangled_walks(8), grid in grid_walks(14), one in 0usize..120, other in 0usize..120) {
        for visits in [tangled.visits, grid.visits] {
            let axioms = AxiomSet::of(Profile::Paper);
            let visits = affordable(&visits, axioms);
            let abduction = explain(visits, axioms);
            the_difference_is_that_of_the_pairs(visits, &abduction, [one % abduction.len(), other % abduction.len()])?;
        }
    }

    #[test]
    fn outlooks(tangled in tangled_walks(7), grid in grid_walks(12), at in 0usize..120) {
        for visits in [tangled.visits, grid.visits] {
            let axioms = AxiomSet::of(Profile::Default);
            let visits = affordable(&visits, axioms);
            let abduction = explain(visits, axioms);
            what_falls_is_what_the_search_refutes(&abduction, at % abduction.len())?;
        }
    }

    #[test]
    fn trees(tangled in tangled_walks(8), lies in lies(8)) {
        for visits in [&tangled.visits, &lies] {
            let axioms = AxiomSet::of(Profile::Default);
            let visits = affordable(visits, axioms);
            let abduction = explain(visits, axioms);
            let Some(root) = node(&abduction, 0, 0) else { continue };
            prop_assert_eq!(root.leaves, abduction.len());
            the_tree_holds_all_candidates(visits, &abduction, &root)?;
        }
    }
}

/// A limit makes the counts lower bounds, and an assignment that it cut is told as cut.
#[test]
fn what_was_cut_is_said() {
    let visits = crate::traces::visits("aces-stars");
    let all = explain(&visits, AxiomSet::of(Profile::Paper));
    let mut few =
        Abduction::new(AxiomSet::of(Profile::Paper), Limits { max_candidates: Some(3), ..Limits::default() });
    visits.iter().for_each(|visit| few.observe(visit).unwrap());
    let cut = all.candidates().filter(|it| verdict(&few, &it.visits) == Some(Verdict::Cut)).count();
    assert_eq!(cut, 32);
    let found = together(&few, 0, [0, 4]).unwrap();
    assert_eq!(found.together.relation, topostar::abduction::Relation::AtLeast);
}

/// The examples of the axioms are refutations, and every axiom of the ACES route has one.
#[test]
fn each_axiom_has_an_example() {
    let visits = crate::traces::visits("aces-stars");
    let abduction = explain(&visits, AxiomSet::of(Profile::Default));
    let found = topostar::explanation::examples(&abduction, abduction.minimal()[0]);
    let refuted: Vec<AxiomId> = abduction.report().refuted.iter().map(|(id, _)| id).collect();
    assert_eq!(found.keys().copied().collect::<Vec<_>>(), refuted);
    for (id, refutation) in found {
        println!("{} {}", id.name(), refutation.clash.words);
        assert_eq!(id, refutation.axiom);
    }
}
