//! The children of one observation, cut to a limit while they are made.

use crate::abduction::tree::Node;
use crate::abduction::{Learned, Simplicity};

/// Children in the order in which they were made. Never many more than the limit are held at once: one observation
/// may make hundreds from every candidate.
pub(super) struct Kept {
    limit: Option<usize>,
    nodes: Vec<Node>,
    /// How simple the map of each node is; nothing without a limit.
    simplicities: Vec<Simplicity>,
    /// What evidence learned of each; nothing without evidence.
    learned: Option<Vec<Learned>>,
    /// How many were added, cut ones among them.
    pub(super) added: u64,
    /// How many of these have new maps.
    pub(super) made: u64,
    cut: bool,
}

/// Twice as many children may gather under any limit, so that cuts stay rare.
const SLACK: usize = 2048;

impl Kept {
    /// No children yet; `measured` says that evidence judges them.
    pub(super) fn new(limit: Option<usize>, measured: bool) -> Self {
        let learned = measured.then(Vec::new);
        Kept { limit, nodes: Vec::new(), simplicities: Vec::new(), learned, added: 0, made: 0, cut: false }
    }

    /// Adds a child, which comes after all before it in the order of assignments; `made` says that its map is new.
    pub(super) fn push(
        &mut self,
        child: Node,
        made: bool,
        simplicity: impl FnOnce() -> Simplicity,
        learned: impl FnOnce() -> Learned,
    ) {
        self.added += 1;
        self.made += u64::from(made);
        self.nodes.push(child);
        if let Some(all) = &mut self.learned {
            all.push(learned());
        }
        if self.limit.is_some() {
            self.simplicities.push(simplicity());
            self.cut_to_slack();
        }
    }

    /// Adds children that come after all before them, cut to the same limit.
    pub(super) fn append(&mut self, others: Kept) {
        self.cut |= others.cut;
        self.added += others.added;
        self.made += others.made;
        self.nodes.extend(others.nodes);
        self.simplicities.extend(others.simplicities);
        if let Some(all) = &mut self.learned {
            all.extend(others.learned.unwrap_or_default());
        }
        self.cut_to_slack();
    }

    /// The most places of a map; zero without a limit.
    pub(super) fn most_places(&self) -> usize {
        self.simplicities.iter().map(|simplicity| simplicity.places).max().unwrap_or(0)
    }

    /// The simplest, and of equally simple ones the first, in their order, with what was learned of each, and whether any was
    /// cut.
    pub(super) fn finish(mut self) -> (Vec<Node>, Vec<Learned>, bool) {
        self.cut_to_limit();
        (self.nodes, self.learned.unwrap_or_default(), self.cut)
    }

    fn cut_to_slack(&mut self) {
        if self.limit.is_some_and(|limit| self.nodes.len() / 2 >= limit.max(SLACK)) {
            self.cut_to_limit();
        }
    }

    /// Cutting early changes nothing: what many simpler children push out stays out when more come.
    fn cut_to_limit(&mut self) {
        let Some(limit) = self.limit.filter(|&limit| self.nodes.len() > limit) else { return };
        self.cut = true;
        let mut ranked: Vec<(Simplicity, usize)> = self.simplicities.iter().copied().zip(0..).collect();
        ranked.sort_unstable();
        let mut keep = vec![false; self.nodes.len()];
        ranked[..limit].iter().for_each(|&(_, index)| keep[index] = true);
        retain(&mut self.nodes, &keep);
        retain(&mut self.simplicities, &keep);
        self.learned.iter_mut().for_each(|all| retain(all, &keep));
    }
}

/// Drops what is not to be kept; what there is nothing about stays.
pub(super) fn retain<T>(all: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    all.retain(|_| kept.next() != Some(&false));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abduction::{Assignment, Lore};
    use crate::map::PlaceId;
    use std::collections::HashSet;

    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Number(u32);

    impl Lore for Number {
        fn bytes(&self, _: &mut HashSet<usize>) -> usize {
            4
        }
    }

    fn child(parent: u32) -> Node {
        Node { parent, assignment: Assignment { place: PlaceId::FIRST, rotation: 0 } }
    }

    fn simplicity(child: u32) -> Simplicity {
        Simplicity { abnormalities: None, paths: [3, 1, 2][(child * child) as usize % 3], places: 1 }
    }

    #[test]
    fn children_cut_while_they_are_made_are_those_cut_at_the_end() {
        let all = 0..20_000u32;
        for limit in [1, 3, 5000, 15_000] {
            let mut ranked: Vec<(Simplicity, u32)> = all.clone().map(|k| (simplicity(k), k)).collect();
            ranked.sort_unstable();
            let mut expected: Vec<u32> = ranked[..limit].iter().map(|&(_, k)| k).collect();
            expected.sort_unstable();
            let mut kept = Kept::new(Some(limit), true);
            for k in all.clone() {
                kept.push(child(k), true, || simplicity(k), || Learned::of(Number(k)));
                assert!(kept.nodes.len() <= 2 * limit.max(SLACK));
            }
            assert_eq!(kept.made, 20_000);
            let (nodes, learned, cut) = kept.finish();
            assert!(cut);
            assert_eq!(nodes.iter().map(|node| node.parent).collect::<Vec<u32>>(), expected);
            assert_eq!(Learned::bytes(&[learned.as_slice(), &learned].concat()), 4 * limit, "each once");
            let number = |learned: &Learned| learned.get().map(|&Number(number)| number);
            assert_eq!(learned.iter().map(number).collect::<Option<Vec<u32>>>(), Some(expected));
        }
    }
}
