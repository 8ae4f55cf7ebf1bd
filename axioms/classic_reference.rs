//! The slow reference of profile `classic`: all assignments of observations to dstates, each checked from the
//! definitions alone.
//!
//! Nothing here is clever, incremental or shared with the engine. A story takes each observation for a dstate,
//! numbered by first visit; a law is a question about a whole story.

use std::collections::BTreeSet;
use topostar::classic::{Action, Sight};

/// For each observation its dstate.
pub(crate) type Story = Vec<usize>;

pub(crate) const LAWS: [&str; 6] =
    ["view", "determinism", "direction", "turn-path", "one-dstate", "path-order"];

/// All stories under which the laws hold, in lexicographic order. With `prune`, stories whose beginning breaks a
/// law are not followed; the laws are monotone, so that the answer is the same.
pub(crate) fn explanations(seen: &[Sight], laws: &[&str], prune: bool) -> Vec<Story> {
    let mut found = Vec::new();
    if !seen.is_empty() {
        follow(seen, laws, prune, &mut vec![0], &mut found);
    }
    found
}

fn follow(seen: &[Sight], laws: &[&str], prune: bool, story: &mut Story, found: &mut Vec<Story>) {
    let whole = story.len() == seen.len();
    if (whole || prune) && !laws.iter().all(|law| obeys(&seen[..story.len()], story, law)) {
        return;
    }
    if whole {
        return found.push(story.clone());
    }
    for dstate in 0..=dstate_count(story) {
        story.push(dstate);
        follow(seen, laws, prune, story, found);
        story.pop();
    }
}

/// The stories that explain one observation more, in order.
pub(crate) fn children(seen: &[Sight], story: &Story) -> Vec<Story> {
    let longer = (0..=dstate_count(story)).map(|dstate| [&story[..], &[dstate]].concat());
    longer.filter(|story| LAWS.iter().all(|law| obeys(&seen[..story.len()], story, law))).collect()
}

/// Whether a story obeys a law.
pub(crate) fn obeys(seen: &[Sight], story: &Story, law: &str) -> bool {
    let schemas = schemas(seen, story);
    let facts = Facts::of(&schemas, dstate_count(story));
    let dstates = 0..dstate_count(story);
    match law {
        "view" => {
            let equal = |k: usize, l: usize| story[k] != story[l] || seen[k].view == seen[l].view;
            (0..story.len()).all(|k| (0..k).all(|l| equal(k, l)))
        }
        "determinism" => schemas
            .iter()
            .all(|(d, a, e)| schemas.iter().all(|(other, b, far)| (other, b) != (d, a) || far == e)),
        "direction" => dstates.clone().all(|d| !facts.opposed[d][d]),
        "turn-path" => schemas
            .iter()
            .filter(|(_, action, _)| matches!(action, Action::Left | Action::Right))
            .all(|&(d, _, e)| !facts.same[d][e] && !facts.opposed[d][e]),
        "one-dstate" => dstates
            .clone()
            .all(|d| dstates.clone().all(|e| d == e || !(facts.together[d][e] && facts.same[d][e]))),
        "path-order" => strictly_ordered(&schemas, &facts),
        law => panic!("the reference does not know the law {law}"),
    }
}

/// The number of paths, travelled or not, and of places.
pub(crate) fn size(seen: &[Sight], story: &Story) -> (usize, usize) {
    let facts = Facts::of(&schemas(seen, story), dstate_count(story));
    let heads = |joined: &dyn Fn(usize, usize) -> bool| {
        (0..dstate_count(story)).filter(|&d| (0..d).all(|e| !joined(d, e))).count()
    };
    (heads(&|d, e| facts.same[d][e] || facts.opposed[d][e]), heads(&|d, e| facts.together[d][e]))
}

/// The simplest of some stories, all that are equally simple.
pub(crate) fn minimal(seen: &[Sight], stories: &[Story]) -> Vec<Story> {
    let least = stories.iter().map(|story| size(seen, story)).min();
    stories.iter().filter(|story| Some(size(seen, story)) == least).cloned().collect()
}

/// The number of the place of each observation, by first visit.
pub(crate) fn places(seen: &[Sight], story: &Story) -> Vec<usize> {
    let facts = Facts::of(&schemas(seen, story), dstate_count(story));
    let mut first: Vec<usize> = Vec::new();
    let number = |&dstate: &usize| match first.iter().position(|&known| facts.together[known][dstate]) {
        Some(number) => number,
        None => {
            first.push(dstate);
            first.len() - 1
        }
    };
    story.iter().map(number).collect()
}

/// What follows from causal schemas for pairs of dstates.
struct Facts {
    /// They face along one path in one direction.
    same: Vec<Vec<bool>>,
    /// They face along one path in opposite directions.
    opposed: Vec<Vec<bool>>,
    /// They are at one place.
    together: Vec<Vec<bool>>,
}

impl Facts {
    fn of(schemas: &[(usize, Action, usize)], count: usize) -> Facts {
        let mut same = vec![vec![false; count]; count];
        (0..count).for_each(|d| same[d][d] = true);
        let mut facts = Facts { together: same.clone(), opposed: vec![vec![false; count]; count], same };
        for &(d, action, e) in schemas {
            let relation = match action {
                Action::Travel => &mut facts.same,
                Action::Around => &mut facts.opposed,
                Action::Left | Action::Right => &mut facts.together,
            };
            (relation[d][e], relation[e][d]) = (true, true);
            if action == Action::Around {
                (facts.together[d][e], facts.together[e][d]) = (true, true);
            }
        }
        // Until nothing more follows, as each round of all triples may.
        for _ in 0..=2 * count {
            for (d, e, f) in triples(count) {
                facts.together[d][f] |= facts.together[d][e] && facts.together[e][f];
                facts.same[d][f] |= facts.same[d][e] && facts.same[e][f];
                facts.same[d][f] |= facts.opposed[d][e] && facts.opposed[e][f];
                facts.opposed[d][f] |= facts.same[d][e] && facts.opposed[e][f];
                facts.opposed[d][f] |= facts.opposed[d][e] && facts.same[e][f];
            }
        }
        facts
    }

    /// The least dstate that a relation joins to one.
    fn head(relation: &[Vec<bool>], dstate: usize) -> usize {
        relation[dstate].iter().position(|&joined| joined).unwrap()
    }
}

/// What travels say of a directed path: that one place comes before another. Whatever is said of a direction is said
/// the other way round of the opposite one. Nothing may come before itself.
fn strictly_ordered(schemas: &[(usize, Action, usize)], facts: &Facts) -> bool {
    let count = facts.same.len();
    let mut before: BTreeSet<(usize, usize, usize)> = BTreeSet::new();
    for &(d, _, e) in schemas.iter().filter(|(_, action, _)| *action == Action::Travel) {
        let (p, q) = (Facts::head(&facts.together, d), Facts::head(&facts.together, e));
        before.insert((Facts::head(&facts.same, d), p, q));
        for back in (0..count).filter(|&back| facts.opposed[d][back]) {
            before.insert((Facts::head(&facts.same, back), q, p));
        }
    }
    loop {
        let further: Vec<(usize, usize, usize)> = before
            .iter()
            .flat_map(|x| before.iter().filter(|y| (x.0, x.2) == (y.0, y.1)).map(|y| (x.0, x.1, y.2)))
            .filter(|fact| !before.contains(fact))
            .collect();
        if further.is_empty() {
            return before.iter().all(|(_, p, q)| p != q);
        }
        before.extend(further);
    }
}

fn schemas(seen: &[Sight], story: &Story) -> Vec<(usize, Action, usize)> {
    (1..story.len()).map(|k| (story[k - 1], seen[k].action, story[k])).collect()
}

fn triples(count: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..count).flat_map(move |d| (0..count).flat_map(move |e| (0..count).map(move |f| (d, e, f))))
}

fn dstate_count(story: &Story) -> usize {
    story.iter().map(|dstate| dstate + 1).max().unwrap_or(0)
}
