//! What differs between two candidates.

use crate::abduction::{Abduction, Candidate, Simplicity};
use crate::explanation::travels::{first_visit, travels};
use crate::map::Paths;

/// What differs between two candidates of one trace. Pairs of numbers are ascending, and lists too. Of a list of two,
/// the first is what holds in the first candidate only.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The first observation that they take for different things; none if they are the same.
    pub parting: Option<usize>,
    /// How simple each is.
    pub simplicity: [Simplicity; 2],
    /// The pairs of visits that are one place in one of them only.
    pub places: [Vec<[usize; 2]>; 2],
    /// The visits that are to the place of the same first visit in both, but turned otherwise.
    pub rotations: Vec<usize>,
    /// The pairs of travels, by the observation at their end, that lie on one path in one of them only.
    pub paths: [Vec<[usize; 2]>; 2],
}

impl Difference {
    /// The same, with the candidates changed over.
    #[must_use]
    pub fn reversed(mut self) -> Difference {
        self.simplicity.reverse();
        self.places.reverse();
        self.paths.reverse();
        self
    }
}

/// What differs between the candidates at two positions. Quadratic in the observations, as the pairs are.
pub fn difference(abduction: &Abduction, candidates: [usize; 2]) -> Option<Difference> {
    let [first, second] = candidates.map(|index| abduction.candidate(index));
    let both = [first?, second?];
    let firsts = both.each_ref().map(first_visits);
    let paths = both.each_ref().map(|candidate| paths(abduction, candidate));
    let visits = both.each_ref().map(|candidate| &candidate.visits);
    let turned = |&visit: &usize| {
        firsts[0][visit] == firsts[1][visit] && visits[0][visit].rotation != visits[1][visit].rotation
    };
    Some(Difference {
        parting: visits[0].iter().zip(visits[1]).position(|(one, other)| one != other),
        simplicity: both.each_ref().map(|candidate| candidate.simplicity(abduction.axioms())),
        places: joined_in_one(&firsts, 0),
        rotations: (0..visits[0].len()).filter(turned).collect(),
        paths: joined_in_one(&paths, 1),
    })
}

/// Of things numbered from `base`, the pairs that one of two partitions joins and the other does not.
fn joined_in_one(classes: &[Vec<usize>; 2], base: usize) -> [Vec<[usize; 2]>; 2] {
    let mut joined = [Vec::new(), Vec::new()];
    for b in 0..classes[0].len() {
        for a in 0..b {
            let [one, other] = classes.each_ref().map(|class| class[a] == class[b]);
            if one != other {
                joined[usize::from(other)].push([a + base, b + base]);
            }
        }
    }
    joined.each_mut().iter_mut().for_each(|pairs| pairs.sort_unstable());
    joined
}

/// For each visit the first one to its place.
fn first_visits(candidate: &Candidate) -> Vec<usize> {
    let first = |place| first_visit(&candidate.visits, place).unwrap_or_default();
    candidate.visits.iter().map(|assignment| first(assignment.place)).collect()
}

/// For each travel the path it lies on.
fn paths(abduction: &Abduction, candidate: &Candidate) -> Vec<usize> {
    let paths = Paths::of(&candidate.map);
    let path = |from| paths.along(&candidate.map, from).path.0 as usize;
    travels(abduction.visits(), candidate).iter().map(|travel| path(travel.from)).collect()
}
