//! The searches that follow the most promising map first.

use crate::classic::bound::{Ahead, ahead, least_possible};
use crate::classic::children::{Child, children};
use crate::classic::history::{History, NodeId};
use crate::classic::report::Tally;
use crate::classic::{
    Candidate, ClassicMap, DstateId, Report, Sights, Simplicity, StopReason, breadth_first,
};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// What makes a map promising.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Guide {
    /// That it is simple now. The search ends at the first map that explains everything, which may not be the
    /// simplest (seed, section 3.3).
    Simplest,
    /// That it may become simple: a bound that no map grown from it can fall below. The search ends when all
    /// simplest maps are known.
    Bound,
}

/// A search that always expands the most promising map by the next observation it has not explained. Of equally
/// promising ones it takes the one that explains most, then the one made first.
///
/// With [`Guide::Simplest`] a robot that observes as it goes on gets the same search: what is expanded next does not
/// depend on what comes later. No map is expanded once `most` were made; if none that explains everything was found
/// by then, the answer is that of a narrow breadth-first search.
pub fn best_first(seen: &Sights, guide: Guide, most: usize) -> Report {
    let mut search = Search::new(seen, guide, most);
    let stop = search.run();
    search.report(stop)
}

/// The candidates that a narrow search keeps.
const NARROW: usize = 10_000;

/// Less is more promising.
type Rank = (Simplicity, Reverse<usize>, NodeId);

struct Search<'a> {
    seen: &'a Sights,
    ahead: Vec<Ahead>,
    guide: Guide,
    most: usize,
    history: History,
    agenda: BTreeMap<Rank, ClassicMap>,
    /// Maps that explain everything and are as simple as any, in the order found.
    found: Vec<(ClassicMap, NodeId)>,
    tallies: Vec<Tally>,
    made: usize,
}

impl<'a> Search<'a> {
    fn new(seen: &'a Sights, guide: Guide, most: usize) -> Self {
        let sights = seen.as_slice();
        let mut search = Search {
            seen,
            ahead: ahead(sights),
            guide,
            most,
            history: History::default(),
            agenda: BTreeMap::new(),
            found: Vec::new(),
            tallies: vec![Tally::default(); sights.len()],
            made: 0,
        };
        if let Some(first) = sights.first() {
            search.push(
                0,
                None,
                Child { map: ClassicMap::first(first.view), at: DstateId::FIRST, made: true },
            );
        }
        search
    }

    fn run(&mut self) -> StopReason {
        while let Some(((promise, Reverse(observation), node), map)) = self.agenda.pop_first() {
            let least = self.found.first().map(|(map, _)| map.simplicity());
            if least.is_some_and(|least| promise > least) {
                return StopReason::MinimumProven;
            }
            if observation + 1 == self.seen.as_slice().len() {
                self.found.push((map, node));
                match self.guide {
                    Guide::Simplest => return StopReason::Found,
                    Guide::Bound => continue,
                }
            }
            if self.made >= self.most {
                self.agenda.insert((promise, Reverse(observation), node), map);
                return StopReason::Limit { observation: observation + 1 };
            }
            self.expand(observation + 1, &map, node);
        }
        StopReason::Exhausted
    }

    fn expand(&mut self, observation: usize, map: &ClassicMap, node: NodeId) {
        let sight = self.seen.as_slice()[observation];
        let mut refuted = self.tallies[observation].refuted;
        for child in children(map, self.history.at(node), sight, &mut refuted) {
            self.push(observation, Some(node), child);
        }
        self.tallies[observation].refuted = refuted;
    }

    fn push(&mut self, observation: usize, before: Option<NodeId>, child: Child) {
        let Child { map, at, made } = child;
        // None: four thousand million maps, which no memory holds.
        let Some(node) = self.history.push(before, at) else { return };
        self.tallies[observation].candidates += 1;
        self.tallies[observation].made += u64::from(made);
        self.made += usize::from(made);
        let promise = match self.guide {
            Guide::Simplest => map.simplicity(),
            Guide::Bound => least_possible(&map, self.ahead[observation]),
        };
        self.agenda.insert((promise, Reverse(observation), node), map);
    }

    fn report(self, stop: StopReason) -> Report {
        let exhausted = stop == StopReason::Exhausted;
        let minimal = self.minimal();
        let mut report = Report::new(&self.tallies, &|_| exhausted, minimal);
        if !exhausted {
            let all_known = stop == StopReason::MinimumProven;
            report.proven = all_known || self.bounds_prove(report.simplicity);
            report.unique = all_known && report.minimal.len() == 1;
            report.stop_reason = stop;
        }
        report
    }

    /// What was found; if that is nothing because of the limit, what a narrow search finds.
    fn minimal(&self) -> Vec<Candidate> {
        if self.found.is_empty() && !self.agenda.is_empty() {
            return breadth_first(self.seen, self.most.min(NARROW)).report().minimal;
        }
        let candidate = |(map, node): &(ClassicMap, NodeId)| Candidate {
            map: map.clone(),
            dstates: self.history.story(*node),
        };
        let mut minimal: Vec<Candidate> = self.found.iter().map(candidate).collect();
        minimal.sort_by(|a, b| a.dstates.cmp(&b.dstates));
        minimal
    }

    /// Whether the bounds of all maps that were not followed show that none becomes simpler.
    fn bounds_prove(&self, least: Option<Simplicity>) -> bool {
        let promise = self.agenda.first_key_value().map(|((promise, ..), _)| *promise);
        self.guide == Guide::Bound && least.is_some() && promise >= least
    }
}
