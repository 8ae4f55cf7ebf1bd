//! The exhaustive search: all candidates, one observation after the other.

use crate::classic::children::{Child, children};
use crate::classic::history::{History, NodeId};
use crate::classic::report::Tally;
use crate::classic::{Candidate, ClassicMap, DstateId, Report, Sight, Sights, Simplicity, StopReason};

/// All candidates that explain what was seen, in the order of their assignments.
#[derive(Debug)]
pub struct Exhaustive {
    history: History,
    layer: Vec<(ClassicMap, NodeId)>,
    tallies: Vec<Tally>,
    first_cut: Option<usize>,
}

/// Follows all candidates (seed, section 4.4: exhaustive breadth-first search).
///
/// After an observation no more than `most` are kept: the simplest, and of equally simple ones the first. Time and
/// memory are exponential in turns and travels in the worst case.
pub fn breadth_first(seen: &Sights, most: usize) -> Exhaustive {
    let mut found =
        Exhaustive { history: History::default(), layer: Vec::new(), tallies: Vec::new(), first_cut: None };
    for (observation, &sight) in seen.as_slice().iter().enumerate() {
        let cut = if observation == 0 { found.start(sight) } else { found.extend(sight, most) };
        if cut {
            found.first_cut = found.first_cut.or(Some(observation));
        }
    }
    found
}

impl Exhaustive {
    /// The candidates kept.
    pub fn candidates(&self) -> impl Iterator<Item = Candidate> {
        self.layer.iter().map(|entry| self.candidate(entry))
    }

    /// What the search has found.
    pub fn report(&self) -> Report {
        let exact = |observation| self.first_cut.is_none_or(|cut| observation < cut);
        let report = Report::new(&self.tallies, &exact, self.minimal());
        match self.first_cut {
            Some(observation) => Report { stop_reason: StopReason::Limit { observation }, ..report },
            None => report,
        }
    }

    fn start(&mut self, sight: Sight) -> bool {
        let first = self.history.push(None, DstateId::FIRST);
        self.layer = first.into_iter().map(|node| (ClassicMap::first(sight.view), node)).collect();
        self.tallies.push(Tally { candidates: 1, made: 1, ..Tally::default() });
        false
    }

    /// Explains one more observation; whether the limit cut.
    fn extend(&mut self, sight: Sight, most: usize) -> bool {
        let mut tally = Tally::default();
        let mut made = Made { most, children: Vec::new(), cut: false };
        for (map, node) in &self.layer {
            for child in children(map, self.history.at(*node), sight, &mut tally.refuted) {
                tally.made += u64::from(child.made);
                made.push(*node, child);
            }
        }
        made.cut_to_most();
        self.layer.clear();
        for (node, Child { map, at, .. }) in made.children {
            match self.history.push(Some(node), at) {
                Some(node) => self.layer.push((map, node)),
                None => made.cut = true,
            }
        }
        tally.candidates = self.layer.len() as u64;
        self.tallies.push(tally);
        made.cut
    }

    fn minimal(&self) -> Vec<Candidate> {
        let least = self.layer.iter().map(|(map, _)| map.simplicity()).min();
        let minimal = self.layer.iter().filter(|(map, _)| Some(map.simplicity()) == least);
        minimal.map(|entry| self.candidate(entry)).collect()
    }

    fn candidate(&self, (map, node): &(ClassicMap, NodeId)) -> Candidate {
        Candidate { map: map.clone(), dstates: self.history.story(*node) }
    }
}

/// Children in the order in which they were made, which is that of their assignments.
struct Made {
    most: usize,
    children: Vec<(NodeId, Child)>,
    cut: bool,
}

/// Twice as many children may gather under any limit, so that cuts stay rare.
const SLACK: usize = 2048;

impl Made {
    fn push(&mut self, before: NodeId, child: Child) {
        self.children.push((before, child));
        if self.children.len() / 2 >= self.most.max(SLACK) {
            self.cut_to_most();
        }
    }

    /// Keeps the simplest, and of equally simple ones the first, in their order. Cutting early changes nothing: what
    /// many simpler children push out stays out when more come.
    fn cut_to_most(&mut self) {
        if self.children.len() <= self.most {
            return;
        }
        self.cut = true;
        let simplicity = |(index, (_, child)): (usize, &(NodeId, Child))| (child.map.simplicity(), index);
        let mut ranked: Vec<(Simplicity, usize)> = self.children.iter().enumerate().map(simplicity).collect();
        ranked.sort_unstable();
        let mut keep = vec![false; self.children.len()];
        ranked[..self.most].iter().for_each(|&(_, index)| keep[index] = true);
        let mut keep = keep.into_iter();
        self.children.retain(|_| keep.next().unwrap_or(false));
    }
}
