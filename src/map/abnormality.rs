//! Which paths cross others in a way that makes them no boundaries.

use crate::map::{Boundaries, Conflict, PathId, PathRegions, Regions, TopologicalMap};
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
    /// How many abnormalities a map needs. Quick where it needs none.
    pub fn fewest_abnormalities(map: &TopologicalMap) -> usize {
        match Boundaries::of(map).agree() {
            true => 0,
            false => Regions::of(map).abnormalities().len(),
        }
    }

    /// The fewest abnormalities under which no conflict is left, ascending; of several such sets always the same.
    /// None if and only if there is no conflict.
    ///
    /// Exact. Paths do not interact, so that for each path the paths that carry evidence about it form a graph with
    /// an edge for each conflict, of which the smallest vertex cover is sought, by branch and bound: at most `1.62^n`
    /// steps for a cover of `n`. Not monotone: an extension that makes two paths one makes two abnormalities one.
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
    // All of them are a cover.
    let cover = smaller_cover(&quarrels, quarrels.len() + 1);
    guilty.extend(cover.unwrap_or_default());
    guilty
}

/// The smallest set with an end of each edge, if one is smaller than `bound`: the vertex of most edges is in it, or
/// else all its neighbours are.
fn smaller_cover(quarrels: &Quarrels, bound: usize) -> Option<BTreeSet<PathId>> {
    if separate_edges(quarrels) >= bound {
        return None;
    }
    // Of equals the first by name.
    let most = quarrels.iter().rev().max_by_key(|(_, others)| others.len());
    let Some((&vertex, others)) = most else { return Some(BTreeSet::new()) };
    let taking = |taken: &BTreeSet<PathId>, bound: usize| {
        let mut rest = quarrels.clone();
        taken.iter().for_each(|&one| settle(&mut rest, one));
        let mut cover = smaller_cover(&rest, bound.checked_sub(taken.len())?)?;
        cover.extend(taken);
        Some(cover)
    };
    let with = taking(&BTreeSet::from([vertex]), bound);
    // An edge of its own needs one end, and either will do.
    if others.len() == 1 {
        return with;
    }
    let bound = with.as_ref().map_or(bound, BTreeSet::len);
    taking(others, bound).or(with)
}

/// So many edges without a common end that no other fits between them: each needs a vertex of its own.
fn separate_edges(quarrels: &Quarrels) -> usize {
    let mut used = BTreeSet::new();
    for (&vertex, others) in quarrels {
        let other = others.iter().find(|other| !used.contains(*other));
        if let Some(&other) = other.filter(|_| !used.contains(&vertex)) {
            used.extend([vertex, other]);
        }
    }
    used.len() / 2
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

#[cfg(test)]
mod tests {
    use super::*;

    /// All sets of vertices, against graphs whose edges are the bits of a number.
    #[test]
    fn covers_are_the_smallest() {
        let pairs: Vec<(u32, u32)> = (0..7).flat_map(|a| (0..a).map(move |b| (a, b))).collect();
        for step in 0..4000u32 {
            let bits = step.wrapping_mul(2_654_435_761);
            let edges: Vec<(u32, u32)> = pairs
                .iter()
                .enumerate()
                .filter(|(k, _)| bits >> (k % 32) & 1 == 1)
                .map(|(_, &e)| e)
                .collect();
            let mut quarrels = Quarrels::new();
            for &(a, b) in &edges {
                quarrels.entry(PathId(a)).or_default().insert(PathId(b));
                quarrels.entry(PathId(b)).or_default().insert(PathId(a));
            }
            let cover = smaller_cover(&quarrels, quarrels.len() + 1).unwrap();
            let covers = |set: u32| edges.iter().all(|&(a, b)| set >> a & 1 == 1 || set >> b & 1 == 1);
            let chosen = cover.iter().fold(0, |set, path| set | 1 << path.0);
            assert!(covers(chosen), "{edges:?}");
            let least = (0..1u32 << 7).filter(|&set| covers(set)).map(u32::count_ones).min();
            assert_eq!(Some(cover.len() as u32), least, "{edges:?}");
        }
    }
}
