//! Visits that are not told yet, and what is known now of the ways between them.
//!
//! A place is often understood only when the robot has come by more than once: on its way out it saw too little of it, or
//! went past a door that it uses later. As long as it remembers walls, its scans are matched with what it saw there, so that
//! what is one spot of the local frame is one place. So visits are held back for as long; and where the robot came into a place
//! that is among them by a gateway that it has, and left it by one, that is a visit to it.

use crate::visit::stay::Stay;
use crate::visit::{Moment, Stage, Visit, VisitParameters};
use std::collections::VecDeque;

/// Stays in their order, the last of which is over.
#[derive(Clone, Debug)]
pub(super) struct Recollection {
    parameters: VisitParameters,
    held: VecDeque<Stay>,
    /// The last one that was told.
    told: Option<Stay>,
}

impl Recollection {
    pub(super) fn new(parameters: VisitParameters) -> Recollection {
        Recollection { parameters, held: VecDeque::new(), told: None }
    }

    /// Takes the next stay, and finds what the robot passed through before it was known. `moments` are all that is remembered of
    /// its way.
    pub(super) fn add(&mut self, stay: Stay, moments: &[Moment]) {
        self.held.push_back(stay);
        // It ends: what is found arrives later than what was before, and each moment is one arrival at most.
        while let Some((at, missed)) = self.missed(moments) {
            self.held.insert(at, missed);
        }
    }

    /// The visits before which nothing can be found any more, when the robot has come to another place.
    pub(super) fn due(&mut self, now: &Moment, moments: &[Moment]) -> Vec<Stage> {
        let memory = self.parameters.matching.memory;
        let due = |stay: &mut Stay| stay.visit.departure.driven + memory < now.driven;
        let mut stages = Vec::new();
        while let Some(stay) = self.held.pop_front_if(due) {
            stages.push(self.tell(stay, moments));
        }
        stages
    }

    /// All that are left.
    pub(super) fn finish(mut self, moments: &[Moment]) -> Vec<Stage> {
        std::mem::take(&mut self.held).into_iter().map(|stay| self.tell(stay, moments)).collect()
    }

    /// Stays that are not told, the latest first.
    pub(super) fn latest(&self) -> impl Iterator<Item = &Stay> {
        self.held.iter().rev()
    }

    /// The stay before the one that is to come.
    pub(super) fn before(&self) -> Option<&Stay> {
        self.held.back().or(self.told.as_ref())
    }

    /// The last visit that was told.
    pub(super) fn told(&self) -> Option<&Visit> {
        self.told.as_ref().map(|stay| &stay.visit)
    }

    fn tell(&mut self, stay: Stay, moments: &[Moment]) -> Stage {
        let visit = stay.visit.clone();
        let from = self.told().map_or(0, |told| told.arrival.scan);
        let way = Moment::between(moments, from, visit.arrival.scan).to_vec();
        self.told = Some(stay);
        Stage { way, visit }
    }

    /// A stay that was missed, and where it belongs; at a place as it was read last, if it was read more than once.
    fn missed(&self, moments: &[Moment]) -> Option<(usize, Stay)> {
        let legs = 0..self.held.len();
        legs.flat_map(|leg| self.latest().map(move |place| (leg, place)))
            .find_map(|(leg, place)| Some((leg, self.missed_on(leg, place, moments)?)))
    }

    /// A stay at a known place on the way to one of those held.
    fn missed_on(&self, leg: usize, place: &Stay, moments: &[Moment]) -> Option<Stay> {
        let VisitParameters { matching, presence, hysteresis, perception, .. } = &self.parameters;
        let to = self.held.get(leg)?;
        let from = leg.checked_sub(1).map_or(self.told.as_ref(), |before| self.held.get(before));
        let there = |end: &Stay| self.parameters.is_one_place(&end.visit.center, &place.visit.center);
        if there(to) || from.is_some_and(there) {
            return None;
        }
        let first = from.map_or(0, |from| from.inside[1].scan);
        let way = Moment::between(moments, first, to.inside[0].scan);
        place.stretches(way, *presence).into_iter().find_map(|stretch| {
            let inside = [stretch.first().copied()?, stretch.last().copied()?];
            let long = inside[1].driven - inside[0].driven >= *hysteresis;
            if !long || !inside.iter().any(|moment| place.is_remembered(moment, matching.memory)) {
                return None;
            }
            let found = place.again(moments, inside, perception)?;
            let between = from.is_none_or(|from| from.is_over_before(&found)) && found.is_over_before(to);
            (between && found.is_through(perception)).then_some(found)
        })
    }
}
