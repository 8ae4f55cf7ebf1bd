//! The children of one observation, cut to a limit while they are made.

use crate::abduction::children::Child;
use crate::abduction::tree::Node;
use crate::abduction::{AxiomSet, Simplicity};
use crate::map::TopologicalMap;

/// Children in the order in which they were made. Never many more than the limit are held at once: each is a map,
/// and one observation may make hundreds from every candidate.
pub(super) struct Kept {
    limit: Option<usize>,
    axioms: AxiomSet,
    nodes: Vec<Node>,
    /// The map of each node.
    maps: Vec<TopologicalMap>,
    /// Of all children, cut ones among them, how many are new maps.
    pub(super) made: u64,
    cut: bool,
}

/// Twice as many children may gather under any limit, so that cuts stay rare.
const SLACK: usize = 2048;

impl Kept {
    pub(super) fn new(limit: Option<usize>, axioms: AxiomSet) -> Self {
        Kept { limit, axioms, nodes: Vec::new(), maps: Vec::new(), made: 0, cut: false }
    }

    /// Adds the child of a candidate, which comes after all before it in the order of assignments.
    pub(super) fn push(&mut self, parent: u32, child: Child) {
        self.made += u64::from(child.made);
        self.nodes.push(Node { parent, assignment: child.assignment });
        self.maps.push(child.map);
        self.cut_to_slack();
    }

    /// Adds children that come after all before them, cut to the same limit.
    pub(super) fn append(&mut self, others: Kept) {
        self.cut |= others.cut;
        self.made += others.made;
        self.nodes.extend(others.nodes);
        self.maps.extend(others.maps);
        self.cut_to_slack();
    }

    /// The simplest, and of equally simple ones the first, in their order, and whether any was cut.
    pub(super) fn finish(mut self) -> (Vec<Node>, Vec<TopologicalMap>, bool) {
        self.cut_to_limit();
        (self.nodes, self.maps, self.cut)
    }

    fn cut_to_slack(&mut self) {
        if self.limit.is_some_and(|limit| self.maps.len() / 2 >= limit.max(SLACK)) {
            self.cut_to_limit();
        }
    }

    /// Cutting early changes nothing: what many simpler children push out stays out when more come.
    fn cut_to_limit(&mut self) {
        let Some(limit) = self.limit.filter(|&limit| self.maps.len() > limit) else { return };
        self.cut = true;
        let axioms = self.axioms;
        let simplicity = |(index, map)| (Simplicity::of(map, axioms), index);
        let mut ranked: Vec<(Simplicity, usize)> = self.maps.iter().enumerate().map(simplicity).collect();
        ranked.sort_unstable();
        let mut keep = vec![false; self.maps.len()];
        ranked[..limit].iter().for_each(|&(_, index)| keep[index] = true);
        let mut kept = keep.iter();
        self.nodes.retain(|_| kept.next() == Some(&true));
        let mut kept = keep.iter();
        self.maps.retain(|_| kept.next() == Some(&true));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abduction::Assignment;
    use crate::map::PlaceId;
    use crate::star::{ControlLaw, Direction, FragmentId, GatewayId, LargeScaleStar, Slot, SmallScaleStar};

    /// A star of so many fragments, so that a map of it has as many paths.
    fn star(fragments: u32) -> LargeScaleStar {
        let slot = |slot: u32| Slot {
            fragment: FragmentId(slot / 2),
            direction: if slot.is_multiple_of(2) { Direction::Plus } else { Direction::Minus },
            outward: Some(GatewayId(slot)),
            inward: Some(GatewayId(slot ^ 1)),
            control: ControlLaw::Midline,
            bearing: None,
            width: None,
            margin: None,
        };
        SmallScaleStar::new((0..2 * fragments).map(slot).collect()).unwrap().large_scale()
    }

    #[test]
    fn children_cut_while_they_are_made_are_those_cut_at_the_end() {
        let maps = [3, 1, 2].map(|fragments| TopologicalMap::new(&star(fragments)).unwrap());
        let child = |k: u32| Child {
            map: maps[(k * k) as usize % 3].clone(),
            assignment: Assignment { place: PlaceId::FIRST, rotation: 0 },
            made: true,
        };
        let all = 0..20_000u32;
        let axioms = AxiomSet::built_in();
        for limit in [1, 3, 5000, 15_000] {
            let mut ranked: Vec<(Simplicity, u32)> =
                all.clone().map(|k| (Simplicity::of(&child(k).map, axioms), k)).collect();
            ranked.sort_unstable();
            let mut expected: Vec<u32> = ranked[..limit].iter().map(|&(_, k)| k).collect();
            expected.sort_unstable();
            let mut kept = Kept::new(Some(limit), axioms);
            for k in all.clone() {
                kept.push(k, child(k));
                assert!(kept.maps.len() <= 2 * limit.max(SLACK));
            }
            assert_eq!(kept.made, 20_000);
            let (nodes, left, cut) = kept.finish();
            assert!(cut);
            assert_eq!(nodes.iter().map(|node| node.parent).collect::<Vec<u32>>(), expected);
            assert_eq!(left, expected.iter().map(|&k| child(k).map).collect::<Vec<_>>());
        }
    }
}
