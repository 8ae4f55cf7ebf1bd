//! The slow reference of profile `classic`: all assignments of observations to dstates, each checked from the
//! definitions alone.
//!
//! Nothing here is clever, incremental or shared with [`crate::classic`] but the [`Sight`], the input of both. A
//! [`Story`] takes each observation for a dstate, numbered by first visit; a law is a question about a whole story.
//!
//! Costs are exponential in the observations, and polynomial of some degree for each story.

use crate::classic::{Action, Sight};
use std::collections::BTreeSet;

/// For each observation its dstate.
pub type Story = Vec<usize>;

/// The laws by name.
pub const LAWS: [&str; 6] = ["view", "determinism", "direction", "turn-path", "one-dstate", "path-order"];

/// All stories under which the laws hold, in lexicographic order. With `prune`, stories whose beginning breaks a
/// law are not followed; the laws are monotone, so that the answer is the same.
pub fn explanations(seen: &[Sight], laws: &[&str], prune: bool) -> Vec<Story> {
    let mut stories = beginning(seen);
    for last in 1..seen.len() {
        let seen = &seen[..=last];
        stories = match prune {
            true => extensions(seen, &stories, laws),
            false => stories.iter().flat_map(children).collect(),
        };
    }
    stories.retain(|story| laws.iter().all(|law| obeys(seen, story, law)));
    stories
}

/// The stories of the first observation alone, which no law speaks against: it is of dstate 0. None if there is none.
pub fn beginning(seen: &[Sight]) -> Vec<Story> {
    seen.first().map(|_| vec![0]).into_iter().collect()
}

/// The stories of all observations that begin with one of some stories of all but the last, and obey the laws. In
/// lexicographic order, if the stories are.
pub fn extensions(seen: &[Sight], stories: &[Story], laws: &[&str]) -> Vec<Story> {
    let children = stories.iter().flat_map(children);
    children.filter(|story| laws.iter().all(|law| obeys(seen, story, law))).collect()
}

/// The story gone on with in every way: the next observation is of each known dstate, or of a new one.
fn children(story: &Story) -> impl Iterator<Item = Story> {
    (0..=dstate_count(story)).map(|dstate| [story.as_slice(), &[dstate]].concat())
}

/// Whether a story obeys a law; true of laws that are not in [`LAWS`].
pub fn obeys(seen: &[Sight], story: &Story, law: &str) -> bool {
    let schemas = schemas(seen, story);
    let facts = || Facts::of(&schemas, dstate_count(story));
    match law {
        "view" => {
            let equal = |k: usize, l: usize| story[k] != story[l] || seen[k].view == seen[l].view;
            (0..story.len()).all(|k| (0..k).all(|l| equal(k, l)))
        }
        "determinism" => schemas
            .iter()
            .all(|(d, a, e)| schemas.iter().all(|(other, b, far)| (other, b) != (d, a) || far == e)),
        "direction" => {
            let opposed = facts().opposed;
            (0..opposed.len()).all(|d| !opposed[d][d])
        }
        "turn-path" => {
            let Facts { same, opposed, .. } = facts();
            let mut turns =
                schemas.iter().filter(|(_, action, _)| matches!(action, Action::Left | Action::Right));
            turns.all(|&(d, _, e)| !same[d][e] && !opposed[d][e])
        }
        "one-dstate" => {
            let Facts { same, together, .. } = facts();
            (0..same.len()).all(|d| (0..d).all(|e| !(together[d][e] && same[d][e])))
        }
        "path-order" => strictly_ordered(&schemas, &facts()),
        _ => true,
    }
}

/// The number of paths, travelled or not, and of places.
pub fn size(seen: &[Sight], story: &Story) -> (usize, usize) {
    let facts = Facts::of(&schemas(seen, story), dstate_count(story));
    let heads = |joined: &dyn Fn(usize, usize) -> bool| {
        (0..dstate_count(story)).filter(|&d| (0..d).all(|e| !joined(d, e))).count()
    };
    (heads(&|d, e| facts.same[d][e] || facts.opposed[d][e]), heads(&|d, e| facts.together[d][e]))
}

/// The simplest of some stories, all that are equally simple.
pub fn minimal(seen: &[Sight], stories: &[Story]) -> Vec<Story> {
    let least = stories.iter().map(|story| size(seen, story)).min();
    stories.iter().filter(|story| Some(size(seen, story)) == least).cloned().collect()
}

/// The number of the place of each observation, by first visit.
pub fn places(seen: &[Sight], story: &Story) -> Vec<usize> {
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
#[derive(Clone, PartialEq)]
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
        while facts.follow(count) {}
        facts
    }

    /// What follows from any two; whether anything new does.
    fn follow(&mut self, count: usize) -> bool {
        let before = self.clone();
        for (d, e, f) in triples(count) {
            self.together[d][f] |= self.together[d][e] && self.together[e][f];
            self.same[d][f] |= self.same[d][e] && self.same[e][f];
            self.same[d][f] |= self.opposed[d][e] && self.opposed[e][f];
            self.opposed[d][f] |= self.same[d][e] && self.opposed[e][f];
            self.opposed[d][f] |= self.opposed[d][e] && self.same[e][f];
        }
        *self != before
    }

    /// The least dstate that a relation joins to one.
    fn head(relation: &[Vec<bool>], dstate: usize) -> usize {
        relation[dstate].iter().position(|&joined| joined).unwrap_or(dstate)
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
