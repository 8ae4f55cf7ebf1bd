//! The laws by name, and those that need few words.

use crate::abduction::Visit;
use crate::reference::boundary::boundary;
use crate::reference::measured::MEASURED;
use crate::reference::planarity::planarity;
use crate::reference::told::{End, Story, Told};

/// The laws of profile `paper`.
pub const PAPER: [&str; 4] = ["determinism", "star-match", "travel-moves", "path-order"];

/// The laws of profile `default` but the measured ones.
pub const DEFAULT: [&str; 5] = ["determinism", "star-match", "travel-moves", "path-order", "planarity"];

/// Axioms that the reference does not state: it takes them to hold. It knows what was measured along a path segment and
/// around a place, [`Measured`](crate::reference::Measured), not where places lie.
pub const UNKNOWN: [&str; 2] = ["closure", "apart"];

/// Slots of a story mean something only where stars match, and far ends only where there is one.
const FIRST: [&str; 2] = ["star-match", "determinism"];

type Law = fn(&Told<'_>) -> bool;

const LAWS: [(&str, Law); 6] = [
    ("determinism", determinism),
    ("star-match", star_match),
    ("travel-moves", travel_moves),
    ("path-order", path_order),
    ("planarity", planarity),
    ("boundary", boundary),
];

/// Whether a story obeys a law. True of laws of measurements, and of those that the reference does not know, see
/// [`UNKNOWN`].
pub fn obeys(visits: &[Visit], story: &Story, law: &str) -> bool {
    holds(&Told::new(visits, story), law)
}

/// Whether the reference can judge a law.
pub fn knows(law: &str) -> bool {
    LAWS.iter().any(|(name, _)| *name == law) || MEASURED.contains(&law)
}

/// Whether it obeys `star-match`, `determinism` and some other laws.
pub(super) fn obeys_all(visits: &[Visit], story: &Story, laws: &[&str]) -> bool {
    let told = Told::new(visits, story);
    let others = laws.iter().filter(|law| !FIRST.contains(law));
    FIRST.iter().chain(others).all(|law| holds(&told, law))
}

fn holds(told: &Told<'_>, law: &str) -> bool {
    LAWS.iter().filter(|(name, _)| *name == law).all(|(_, holds)| holds(told))
}

/// Every travel and every travel back: equal gateways have equal far ends, and not themselves.
fn determinism(told: &Told<'_>) -> bool {
    let there_and_back: Vec<(End, End)> = told.travels.iter().flat_map(|&(a, b)| [(a, b), (b, a)]).collect();
    there_and_back.iter().all(|x| x.0 != x.1)
        && there_and_back.iter().all(|x| there_and_back.iter().all(|y| x.0 != y.0 || x.1 == y.1))
}

/// Every observation: each of its slots is the slot that far on of its place's star.
fn star_match(told: &Told<'_>) -> bool {
    told.visits.iter().zip(told.story).all(|(visit, &(place, rotation))| {
        let (own, seen) = (told.stars[place].slots(), visit.star.slots());
        let on = |slot: usize| (slot + rotation) % seen.len();
        own.len() == seen.len()
            && (0..seen.len()).all(|slot| {
                own[on(slot)].control == seen[slot].control
                    && own[on(slot)].navigable == seen[slot].navigable
                    && own[on(slot)].opposite.0 as usize == on(seen[slot].opposite.0 as usize)
            })
    })
}

fn travel_moves(told: &Told<'_>) -> bool {
    told.travels.iter().all(|(from, to)| from.0 != to.0)
}

/// Walking on from any dstate, no place comes twice.
fn path_order(told: &Told<'_>) -> bool {
    told.ends().into_iter().all(|start| {
        let mut passed = vec![start.0];
        let mut ahead = start;
        while let Some(far) = told.far_end(ahead) {
            if passed.contains(&far.0) {
                return false;
            }
            passed.push(far.0);
            ahead = told.opposite(far);
        }
        true
    })
}
