//! Profile `classic`: the searches find the maps of the reference and only these, and every axiom refutes exactly
//! what breaks it.

use crate::reference::views::{self as reference, LAWS, Story};
use proptest::prelude::*;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use topostar::classic::{
    AXIOMS, Action, Candidate, ClassicMap, Exhaustive, Guide, Report, Sight, Sights, StopReason, ViewId,
    best_first, breadth_first,
};

const NO_LIMIT: usize = usize::MAX;

fn sights(seen: &[Sight]) -> Sights {
    let mut sights = Sights::default();
    seen.iter().for_each(|&sight| sights.push(sight).unwrap());
    sights
}

pub(crate) fn exhaustive(seen: &[Sight]) -> Exhaustive {
    breadth_first(&sights(seen), NO_LIMIT)
}

fn story(candidate: &Candidate) -> Story {
    candidate.dstates.iter().map(|dstate| dstate.index()).collect()
}

pub(crate) fn stories(found: &Exhaustive) -> Vec<Story> {
    found.candidates().map(|candidate| story(&candidate)).collect()
}

pub(crate) fn minimal(report: &Report) -> Vec<Story> {
    report.minimal.iter().map(story).collect()
}

/// The property of an axiom: exactly those stories are candidates that the other axioms allow and that obey it.
fn refutes_what_breaks_it(law: &str, seen: &[Sight]) -> Result<(), TestCaseError> {
    let others: Vec<&str> = LAWS.into_iter().filter(|other| *other != law).collect();
    let allowed = reference::explanations(seen, &others, true);
    let expected: Vec<Story> =
        allowed.into_iter().filter(|story| reference::obeys(seen, story, law)).collect();
    prop_assert_eq!(stories(&exhaustive(seen)), expected, "{}", law);
    Ok(())
}

#[test]
fn every_axiom_has_its_law_and_refutes_what_no_other_does() {
    assert_eq!(AXIOMS.each_ref().map(|axiom| axiom.name), LAWS);
    let step = |action, view| Sight { action, view: ViewId(view) };
    let (left, right) = (step(Action::Left, 0), step(Action::Right, 0));
    let (around, travel) = (step(Action::Around, 0), step(Action::Travel, 0));
    let alone: [(&str, &[Sight], Story); 6] = [
        ("view", &[left, step(Action::Left, 1), right, left], vec![0, 1, 0, 1]),
        ("determinism", &[left, left, right, left], vec![0, 1, 0, 2]),
        ("direction", &[left, around], vec![0, 0]),
        ("turn-path", &[left, left], vec![0, 0]),
        ("one-dstate", &[left, around, around], vec![0, 1, 2]),
        ("path-order", &[left, travel], vec![0, 0]),
    ];
    for (law, seen, story) in alone {
        let broken: Vec<&str> =
            LAWS.into_iter().filter(|other| !reference::obeys(seen, &story, other)).collect();
        assert_eq!(broken, [law]);
        assert!(!stories(&exhaustive(seen)).contains(&story), "{law}");
        let refuted: Vec<&str> =
            exhaustive(seen).report().refuted.iter().map(|(axiom, _)| axiom.name()).collect();
        // A known schema has one outcome, so that no map is ever proposed that breaks determinism.
        assert!(law == "determinism" || refuted.contains(&law), "{law}: {refuted:?}");
    }
}

/// What the theory says of turns, and what it leaves open.
#[test]
fn turns_around_return_and_other_turns_need_not() {
    let ends = |actions: &[Action]| -> Vec<usize> {
        let first = Sight { action: Action::Left, view: ViewId(0) };
        let rest = actions.iter().map(|&action| Sight { action, view: ViewId(0) });
        let seen: Vec<Sight> = [first].into_iter().chain(rest).collect();
        let mut ends: Vec<usize> =
            stories(&exhaustive(&seen)).iter().map(|story| story[seen.len() - 1]).collect();
        ends.sort_unstable();
        ends.dedup();
        ends
    };
    use Action::{Around, Left, Right, Travel};
    assert_eq!(ends(&[Around, Around]), [0]);
    assert_eq!(ends(&[Left, Right]), [0, 2]);
    assert_eq!(ends(&[Left, Left, Left, Left]), [0, 1, 2, 4]);
    // Back by the same path: to where it came from, or to another place on the way.
    assert_eq!(ends(&[Travel, Around, Travel, Around]), [0, 4]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn candidates_are_those_of_the_reference(walk in view_walks(8), lies in lies(7)) {
        for seen in [&walk.seen, &lies] {
            let found = exhaustive(seen);
            prop_assert_eq!(stories(&found), reference::explanations(seen, &LAWS, true));
            for candidate in found.candidates() {
                let story = story(&candidate);
                let size = candidate.map.simplicity();
                prop_assert_eq!((size.paths, size.places), reference::size(seen, &story));
                prop_assert_eq!(candidate.places(), reference::places(seen, &story));
                prop_assert_eq!(candidate.map.places().len(), size.places);
                let paths = candidate.map.paths();
                prop_assert_eq!(paths.len(), size.paths);
                for path in &paths {
                    let position = |place| path.places.iter().position(|own| *own == place);
                    prop_assert!(path.segments.iter().all(|[a, b]| position(*a) < position(*b)));
                }
                let travelled = travels(seen, &story, &reference::places(seen, &story));
                let segments: BTreeSet<[usize; 2]> = paths.iter().flat_map(|path| path.segments.clone()).collect();
                prop_assert_eq!(segments.into_iter().map(sorted).collect::<BTreeSet<_>>(), travelled);
            }
        }
    }

    #[test]
    fn pruning_changes_nothing(walk in view_walks(5), lies in lies(5)) {
        for seen in [&walk.seen, &lies] {
            let all = reference::explanations(seen, &LAWS, false);
            prop_assert_eq!(all, reference::explanations(seen, &LAWS, true));
        }
    }

    #[test]
    fn axioms_refute_exactly_what_breaks_them(walk in view_walks(5), lies in lies(5)) {
        for law in LAWS {
            refutes_what_breaks_it(law, &walk.seen)?;
            refutes_what_breaks_it(law, &lies)?;
        }
    }

    #[test]
    fn the_truth_is_a_candidate_if_it_obeys(walk in view_walks(9)) {
        let obeys = LAWS.iter().all(|law| reference::obeys(&walk.seen, &walk.truth, law));
        prop_assert_eq!(stories(&exhaustive(&walk.seen)).contains(&walk.truth), obeys);
    }

    #[test]
    fn the_minimum_is_that_of_the_reference(walk in view_walks(8), lies in lies(7)) {
        for seen in [&walk.seen, &lies] {
            let expected = reference::minimal(seen, &reference::explanations(seen, &LAWS, true));
            for report in [exhaustive(seen).report(), best_first(&sights(seen), Guide::Bound, NO_LIMIT)] {
                prop_assert_eq!(minimal(&report), expected.clone());
                prop_assert!(report.proven);
                prop_assert_eq!(report.unique, expected.len() == 1);
            }
        }
    }

    #[test]
    fn minimal_maps_are_counted_without_the_numbers_of_their_dstates(walk in view_walks(6), lies in lies(6)) {
        for seen in [&walk.seen, &lies] {
            let report = exhaustive(seen).report();
            let mut different: Vec<&ClassicMap> = Vec::new();
            for candidate in &report.minimal {
                if !different.iter().any(|other| renumbered(other, &candidate.map)) {
                    different.push(&candidate.map);
                }
            }
            prop_assert_eq!(report.minimal_maps(), different.len());
        }
    }

    #[test]
    fn the_bound_loses_no_minimum_on_longer_walks(walk in view_walks(16)) {
        let most = 3000;
        let all = breadth_first(&sights(&walk.seen), most).report();
        let found = best_first(&sights(&walk.seen), Guide::Bound, NO_LIMIT);
        prop_assert!(found.proven && found.simplicity <= all.simplicity);
        if all.complete {
            prop_assert_eq!((minimal(&found), found.unique), (minimal(&all), all.unique));
        }
    }

    #[test]
    fn simplest_first_takes_the_simplest_map_each_time(walk in view_walks(8), lies in lies(7)) {
        for seen in [&walk.seen, &lies] {
            let report = best_first(&sights(seen), Guide::Simplest, NO_LIMIT);
            let (answer, made) = simplest_first(seen);
            prop_assert_eq!(minimal(&report), answer.clone().into_iter().collect::<Vec<Story>>());
            prop_assert_eq!(report.maps_created.value, made);
            prop_assert_eq!(report.proven, answer.is_none());
        }
    }

    #[test]
    fn limits_cut_honestly(walk in view_walks(8), most in 1..12usize) {
        let exact = exhaustive(&walk.seen);
        let all = stories(&exact);
        let least = exact.report().simplicity;
        let cut = breadth_first(&sights(&walk.seen), most);
        prop_assert!(stories(&cut).iter().all(|story| all.contains(story)));
        let widths = exact.report().candidates_per_observation;
        let within = widths.iter().all(|count| count.value <= most as u64);
        prop_assert_eq!(cut.report().complete, within);
        let reports = [
            cut.report(),
            best_first(&sights(&walk.seen), Guide::Simplest, most),
            best_first(&sights(&walk.seen), Guide::Bound, most),
        ];
        for report in reports {
            prop_assert!(minimal(&report).iter().all(|story| all.contains(story)));
            prop_assert!(report.candidates.value <= all.len() as u64);
            prop_assert!(!report.proven || report.simplicity == least);
            prop_assert!(!report.unique || report.minimal.len() == 1);
            let limited = matches!(report.stop_reason, StopReason::Limit { .. });
            prop_assert!(!(limited && (report.complete || report.unique)));
            prop_assert!(report.complete || report.stop_reason != StopReason::Exhausted);
        }
    }
}

/// The pairs of places that a travel joined.
fn travels(seen: &[Sight], story: &Story, places: &[usize]) -> BTreeSet<[usize; 2]> {
    let travelled = (1..story.len()).filter(|&k| seen[k].action == Action::Travel);
    travelled.map(|k| sorted([places[k - 1], places[k]])).collect()
}

fn sorted(mut pair: [usize; 2]) -> [usize; 2] {
    pair.sort_unstable();
    pair
}

/// Whether some renumbering of dstates makes one map the other: all are tried.
fn renumbered(a: &ClassicMap, b: &ClassicMap) -> bool {
    let count = a.dstates().len();
    let fits = |number: &[usize]| {
        a.dstates().iter().enumerate().all(|(own, dstate)| {
            let other = &b.dstates()[number[own]];
            let after = dstate.after.map(|to| to.map(|to| number[to.index()]));
            dstate.view == other.view && after == other.after.map(|to| to.map(|to| to.index()))
        })
    };
    count == b.dstates().len() && permutations(count).iter().any(|number| fits(number))
}

fn permutations(count: usize) -> Vec<Vec<usize>> {
    (0..count).fold(vec![Vec::new()], |shorter: Vec<Vec<usize>>, next| {
        let insert = |number: &Vec<usize>, at: usize| [&number[..at], &[next], &number[at..]].concat();
        shorter.iter().flat_map(|number| (0..=next).map(move |at| insert(number, at))).collect()
    })
}

/// The search as the seed tells it, over whole stories: the answer, and how many maps were made.
fn simplest_first(seen: &[Sight]) -> (Option<Story>, u64) {
    let mut agenda: Vec<(u64, Story)> = vec![(0, vec![0])];
    let (mut nodes, mut made) = (0, 1);
    loop {
        let rank = |(node, story): &(u64, Story)| (reference::size(seen, story), Reverse(story.len()), *node);
        let Some(next) = (0..agenda.len()).min_by_key(|&index| rank(&agenda[index])) else {
            return (None, made);
        };
        let (_, story) = agenda.remove(next);
        if story.len() == seen.len() {
            return (Some(story), made);
        }
        let known = (1..story.len())
            .any(|k| story[k - 1] == story[story.len() - 1] && seen[k].action == seen[story.len()].action);
        for child in reference::extensions(&seen[..=story.len()], std::slice::from_ref(&story), &LAWS) {
            nodes += 1;
            made += u64::from(!known);
            agenda.push((nodes, child));
        }
    }
}

/// A walk through a world of views, as observed and as it was.
#[derive(Clone, Debug)]
pub(crate) struct ViewWalk {
    pub(crate) seen: Vec<Sight>,
    truth: Story,
}

/// Walks through worlds whose places have two to four dstates, opposite ones half the circle apart, few views, and
/// travels joined at random. Such a world need not obey the order of paths.
pub(crate) fn view_walks(most: usize) -> impl Strategy<Value = ViewWalk> {
    let place = prop::sample::select(vec![2usize, 4, 4]);
    let places = prop::collection::vec((place, prop::collection::vec(0..3u16, 4)), 1..4);
    let joins = prop::collection::vec(any::<u16>(), 16);
    let steps = prop::collection::vec(0..6u8, 0..most);
    (places, joins, steps).prop_map(|(places, joins, steps)| walk(&places, &joins, &steps))
}

fn walk(places: &[(usize, Vec<u16>)], joins: &[u16], steps: &[u8]) -> ViewWalk {
    let mut free: Vec<(usize, usize)> = places
        .iter()
        .enumerate()
        .flat_map(|(place, (size, _))| (0..*size).map(move |slot| (place, slot)))
        .collect();
    let mut far = Vec::new();
    for &join in joins {
        if free.len() < 2 {
            break;
        }
        let a = free.remove(0);
        let b = free.remove(usize::from(join) % free.len());
        far.extend([(a, b), (b, a)]);
    }
    let opposite = |(place, slot): (usize, usize)| (place, (slot + places[place].0 / 2) % places[place].0);
    let mut at = (0, 0);
    let mut met = vec![at];
    let sight = |action, at: (usize, usize)| Sight { action, view: ViewId(places[at.0].1[at.1]) };
    let mut walk = ViewWalk { seen: vec![sight(Action::Travel, at)], truth: vec![0] };
    for &step in steps {
        let size = places[at.0].0;
        let out = far.iter().find(|(from, _)| *from == at);
        let (action, next) = match (step, out) {
            (0, _) if size > 2 => (Action::Left, (at.0, (at.1 + size - 1) % size)),
            (1, _) if size > 2 => (Action::Right, (at.0, (at.1 + 1) % size)),
            (2.., Some((_, to))) if step > 3 => (Action::Travel, opposite(*to)),
            _ => (Action::Around, opposite(at)),
        };
        at = next;
        let known = met.iter().position(|dstate| *dstate == at);
        walk.truth.push(known.unwrap_or(met.len()));
        if known.is_none() {
            met.push(at);
        }
        walk.seen.push(sight(action, at));
    }
    walk
}

/// Observations without a world.
pub(crate) fn lies(most: usize) -> impl Strategy<Value = Vec<Sight>> {
    let sight = (prop::sample::select(Action::ALL.to_vec()), 0..2u16)
        .prop_map(|(action, view)| Sight { action, view: ViewId(view) });
    prop::collection::vec(sight, 1..most)
}
