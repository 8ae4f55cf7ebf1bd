//! Visits that are not told yet, and what is known now of the way before them and after.
//!
//! A place is often understood only when the robot has come by more than once: on its way out it saw too little of it, or
//! went past a door that it uses later. As long as it remembers walls, its scans are matched with what it saw there, so that
//! what is one spot of the local frame is one place. So visits are held back for as long, and wherever the robot passed
//! through a place that is among them, that is a visit to it.

use crate::star::describe;
use crate::visit::passage::{is_through, passed};
use crate::visit::{Moment, Stage, Visit, VisitParameters};
use std::collections::VecDeque;

/// Visits in their order, the last of which the robot has left.
#[derive(Clone, Debug, Default)]
pub(super) struct Recollection {
    held: VecDeque<Known>,
    /// The last visit that was given away.
    told: Option<Known>,
}

#[derive(Clone, Debug)]
struct Known {
    visit: Visit,
    /// The first and the last moment at which the robot was near.
    inside: [Moment; 2],
    /// The distance from the middle to the nearest obstacle, metres.
    clearance: f64,
}

impl Recollection {
    /// Takes the next visit, and finds what the robot passed through unseen. `moments` are all that is remembered of its way.
    pub(super) fn add(
        &mut self,
        visit: Visit,
        inside: [Moment; 2],
        moments: &[Moment],
        parameters: &VisitParameters,
    ) {
        let Ok(place) = describe(&visit.lpm, &parameters.perception) else { return };
        self.held.push_back(Known { visit, inside, clearance: place.clearance });
        while let Some((at, unseen)) = self.unseen(moments, parameters) {
            self.held.insert(at, unseen);
        }
    }

    /// The visits to which nothing can come any more that was before them, when the robot has come to another place.
    pub(super) fn due(&mut self, now: &Moment, moments: &[Moment], memory: f64) -> Vec<Stage> {
        let due = |known: &mut Known| known.visit.departure.driven + memory < now.driven;
        let mut stages = Vec::new();
        while let Some(known) = self.held.pop_front_if(due) {
            stages.push(self.tell(known, moments));
        }
        stages
    }

    /// All that are left.
    pub(super) fn finish(mut self, moments: &[Moment]) -> Vec<Stage> {
        std::mem::take(&mut self.held).into_iter().map(|known| self.tell(known, moments)).collect()
    }

    /// Visits that the robot remembers, the latest first.
    pub(super) fn latest(&self) -> impl Iterator<Item = &Visit> {
        self.held.iter().rev().map(|known| &known.visit)
    }

    /// The last visit that was given away.
    pub(super) fn told(&self) -> Option<&Visit> {
        self.told.as_ref().map(|known| &known.visit)
    }

    fn tell(&mut self, known: Known, moments: &[Moment]) -> Stage {
        let visit = known.visit.clone();
        let from = self.told().map_or(0, |told| told.arrival.scan);
        let within = |moment: &&Moment| (from..=visit.arrival.scan).contains(&moment.scan);
        let way = moments.iter().filter(within).copied().collect();
        self.told = Some(known);
        Stage { way, visit }
    }

    /// A visit that was passed over, and where it belongs.
    fn unseen(&self, moments: &[Moment], parameters: &VisitParameters) -> Option<(usize, Known)> {
        let all = 0..self.held.len();
        all.clone()
            .flat_map(|leg| all.clone().map(move |place| (leg, place)))
            .find_map(|(leg, place)| Some((leg, self.passing(&self.held[place], leg, moments, parameters)?)))
    }

    /// A visit to a known place on the way to one of those held.
    fn passing(
        &self,
        known: &Known,
        leg: usize,
        moments: &[Moment],
        parameters: &VisitParameters,
    ) -> Option<Known> {
        let VisitParameters { matching, presence, agreement, perception, .. } = parameters;
        let to = &self.held[leg];
        let from = leg.checked_sub(1).map_or(self.told.as_ref(), |before| Some(&self.held[before]));
        let center = known.visit.center;
        let elsewhere = |other: &Known| (other.visit.center - center).norm() > 2.0 * agreement;
        if !elsewhere(to) || !from.is_none_or(elsewhere) {
            return None;
        }
        let left = from.map_or(0, |from| from.inside[1].scan);
        let remembered = |moment: &Moment| {
            moment.driven <= known.visit.departure.driven + matching.memory
                && moment.driven + matching.memory >= known.visit.arrival.driven
        };
        let near = |moment: &Moment| {
            (moment.local_from_robot.position() - center).norm() <= known.clearance + presence
        };
        let way = moments.iter().filter(|moment| (left..=to.inside[0].scan).contains(&moment.scan));
        let way: Vec<&Moment> = way.filter(|moment| remembered(moment)).collect();
        let runs = way.chunk_by(|a, b| near(a) == near(b)).filter(|run| near(run[0]));
        runs.filter_map(|run| {
            let inside = [*run[0], *run[run.len() - 1]];
            let scans = inside.map(|moment| moment.scan);
            let visit = passed(&center, &known.visit.lpm, moments, scans, perception)?;
            let after = left < visit.arrival.scan
                && from.is_none_or(|from| from.visit.departure.scan < visit.departure.scan);
            let before =
                inside[1].scan <= to.visit.arrival.scan && visit.departure.scan < to.visit.departure.scan;
            (after && before && is_through(&visit, perception)).then_some(Known { visit, inside, ..*known })
        })
        .next()
    }
}
