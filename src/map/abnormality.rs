//! Which paths cross others in a way that makes them no boundaries.

use crate::map::{Conflict, PathId, PathRegions, Regions};
use std::collections::{BTreeMap, BTreeSet};

/// `ab(pa, pa')`: a path of whose neighbours nothing is said, in spite of all evidence, as far as another path
/// carries them (Remolina and Kuipers, IJCAI-01: the boundary axiom is a default).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Abnormality {
    /// The path that is no boundary here.
    pub path: PathId,
    /// The path that carries places from one side of it to the other, or back onto it.
    pub carrier: PathId,
}

/// Which paths must not both be taken at their word.
type Quarrels = BTreeMap<PathId, BTreeSet<PathId>>;

impl Regions {
    /// The fewest abnormalities under which no conflict is left, ascending; of several such sets always the same.
    /// None if and only if there is no conflict.
    ///
    /// Exact. Paths do not interact, so that for each path the paths that carry evidence about it form a graph with
    /// an edge for each conflict, of which the smallest vertex cover is sought: at most `1.62^n` steps for a cover
    /// of `n`. Not monotone: an extension that makes two paths one makes two abnormalities one.
    pub fn abnormalities(&self) -> Vec<Abnormality> {
        let of_path = |path: &PathRegions| {
            let name = path.path;
            let carriers = fewest_carriers(path.conflicts());
            carriers.into_iter().map(move |carrier| Abnormality { path: name, carrier })
        };
        self.iter().flat_map(of_path).collect()
    }
}

/// The fewest carriers such that each conflict is due to one of them.
fn fewest_carriers(conflicts: impl Iterator<Item = Conflict>) -> BTreeSet<PathId> {
    let mut guilty = BTreeSet::new();
    let mut quarrels = Quarrels::new();
    for Conflict { beside, right, .. } in conflicts {
        match right.map(|right| right.carrier).filter(|&other| other != beside.carrier) {
            None => {
                guilty.insert(beside.carrier);
            }
            Some(other) => {
                quarrels.entry(beside.carrier).or_default().insert(other);
                quarrels.entry(other).or_default().insert(beside.carrier);
            }
        }
    }
    guilty.iter().for_each(|&carrier| settle(&mut quarrels, carrier));
    guilty.extend(smallest_cover(quarrels));
    guilty
}

/// The smallest set with an end of each edge: the vertex of most edges is in it, or else all its neighbours are.
fn smallest_cover(quarrels: Quarrels) -> BTreeSet<PathId> {
    // Of equals the first by name.
    let most = quarrels.iter().rev().max_by_key(|(_, others)| others.len());
    let Some((&vertex, others)) = most else { return BTreeSet::new() };
    let others = others.clone();
    let taking = |taken: &BTreeSet<PathId>| {
        let mut rest = quarrels.clone();
        taken.iter().for_each(|&one| settle(&mut rest, one));
        let mut cover = smallest_cover(rest);
        cover.extend(taken);
        cover
    };
    let with = taking(&BTreeSet::from([vertex]));
    // An edge of its own needs one end, and either will do.
    if others.len() == 1 {
        return with;
    }
    let without = taking(&others);
    if without.len() < with.len() { without } else { with }
}

/// Takes a vertex and its edges out.
fn settle(quarrels: &mut Quarrels, vertex: PathId) {
    for other in quarrels.remove(&vertex).unwrap_or_default() {
        if let Some(others) = quarrels.get_mut(&other) {
            others.remove(&vertex);
            if others.is_empty() {
                quarrels.remove(&other);
            }
        }
    }
}
