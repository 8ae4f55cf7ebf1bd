//! Where to look next: what each gateway would tell the candidates apart by.

use crate::abduction::{Abduction, Candidate, Count};
use crate::explanation::together::counted;
use crate::explanation::travels::clockwise_by;
use crate::map::{DstateId, PlaceId, TopologicalMap};
use crate::star::LargeScaleStar;
use std::collections::{BTreeMap, VecDeque};

/// What the gateways of one candidate's map promise to tell, once the robot has gone there and looked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outlook {
    /// The candidate whose map it is, by position.
    pub candidate: usize,
    /// Where the robot is in that map, as it arrived.
    pub robot: DstateId,
    /// How many candidates there are to tell apart.
    pub candidates: Count,
    /// What each gateway promises, best first: most that are expected to fall, then most in the worst case, then the
    /// shortest route, then by gateway.
    pub prospects: Vec<Prospect>,
}

/// What travel through a gateway promises.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prospect {
    /// The gateway.
    pub gateway: DstateId,
    /// Whether the map knows its far end.
    pub explored: bool,
    /// The gateways to leave by, one travel after the other; the last is this one.
    pub route: Vec<DstateId>,
    /// The same as a robot does it: how many slots clockwise from the slot it came in on it finds each gateway.
    pub turns: Vec<u8>,
    /// What the candidates predict to be seen on the route, by travel, then star; each candidate is in one.
    pub predictions: Vec<Prediction>,
    /// How many candidates fall at least, whichever candidate is the true one.
    pub worst: u64,
    /// The sum, over the candidates taken for the true one in turn, of how many fall at least; divided by their
    /// number it is how many are expected to fall.
    pub expected: u64,
}

/// Candidates that predict the same of a route.
///
/// A candidate is followed along the route as long as it predicts what the map of the outlook does. At the first
/// travel of which it predicts something else, or nothing as the gateway is unexplored in it, and else at the last
/// travel, it is told by what it predicts there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prediction {
    /// The travel of the route, from 0.
    pub travel: usize,
    /// The star to be seen, listed from the gateway come in by; none if the candidate does not know.
    pub star: Option<LargeScaleStar>,
    /// How many candidates predict it.
    pub candidates: u64,
    /// How many candidates fall if it comes true; of candidates that do not know, the least over all that could be
    /// seen.
    pub falls: u64,
}

/// The outlook for the map of the candidate at a position, over all its gateways that can be reached by known path
/// segments, unexplored ones and others: also what looks known may be told otherwise by a rival.
///
/// A candidate *falls* if it predicts another star than is seen: then `star-match` refutes it. One that does not know
/// never falls at the travel of which it does not know, as what is seen there may be a new place. What measured
/// axioms would refute comes on top. Routes are shortest by travels. Linear in gateways times candidates, times the
/// length of routes.
pub fn outlook(abduction: &Abduction, candidate: usize) -> Option<Outlook> {
    let own = abduction.candidate(candidate)?;
    let all: Vec<Candidate> = abduction.candidates().collect();
    let routes = routes(&own);
    let mut prospects: Vec<Prospect> = routes.into_iter().map(|route| prospect(&own, &all, route)).collect();
    prospects.sort_by(|a, b| {
        let rank = |it: &Prospect| (it.expected, it.worst);
        rank(b).cmp(&rank(a)).then_with(|| (a.route.len(), a.gateway).cmp(&(b.route.len(), b.gateway)))
    });
    let candidates = counted(abduction, all.len() as u64);
    Some(Outlook { candidate, robot: own.robot, candidates, prospects })
}

/// For each gateway that can be reached the shortest way to it and through it, of equally short ones the first.
fn routes(own: &Candidate) -> Vec<Vec<DstateId>> {
    let map = &own.map;
    let mut ways: BTreeMap<PlaceId, Vec<DstateId>> = BTreeMap::from([(own.robot.place, Vec::new())]);
    let mut reached = VecDeque::from([own.robot.place]);
    let mut routes = Vec::new();
    while let Some(place) = reached.pop_front() {
        let way = ways[&place].clone();
        for gateway in map.dstates_at(place).filter(|&dstate| is_navigable(map, dstate)) {
            let route = [way.as_slice(), &[gateway]].concat();
            if let Some(far) = map.far_end(gateway)
                && !ways.contains_key(&far.place)
            {
                ways.insert(far.place, route.clone());
                reached.push_back(far.place);
            }
            routes.push(route);
        }
    }
    routes
}

fn is_navigable(map: &TopologicalMap, dstate: DstateId) -> bool {
    map.star(dstate.place).slots()[dstate.slot.0 as usize].navigable
}

fn prospect(own: &Candidate, all: &[Candidate], route: Vec<DstateId>) -> Prospect {
    let map = &own.map;
    let gateway = route.last().copied().unwrap_or(own.robot);
    let (turns, stars) = as_done(own, &route);
    let mut groups: BTreeMap<(usize, Option<LargeScaleStar>), u64> = BTreeMap::new();
    for candidate in all {
        *groups.entry(predict(candidate, &turns, &stars)).or_default() += 1;
    }
    let groups: Vec<Group> =
        groups.into_iter().map(|((travel, star), candidates)| Group { travel, star, candidates }).collect();
    let falls = Falls { groups: &groups, travels: route.len() };
    let predictions: Vec<Prediction> = groups.iter().map(|group| falls.prediction(group)).collect();
    Prospect {
        gateway,
        explored: map.far_end(gateway).is_some(),
        worst: predictions.iter().map(|prediction| prediction.falls).min().unwrap_or(0),
        expected: predictions.iter().map(|prediction| prediction.candidates * prediction.falls).sum(),
        route,
        turns,
        predictions,
    }
}

/// A route as a robot does it, and what the map says it sees after each travel.
fn as_done(own: &Candidate, route: &[DstateId]) -> (Vec<u8>, Vec<Option<LargeScaleStar>>) {
    let mut at = own.robot;
    let mut done = (Vec::new(), Vec::new());
    for &gateway in route {
        let size = own.map.star(gateway.place).size();
        done.0.push(((gateway.slot.0 as usize + size - at.slot.0 as usize) % size) as u8);
        let far = own.map.far_end(gateway);
        done.1.push(far.map(|far| own.map.star(far.place).listed_from(far.slot)));
        at = far.map_or(at, |far| own.map.opposite(far));
    }
    done
}

/// The travel at which a candidate is told, and what it predicts there.
fn predict(
    candidate: &Candidate,
    turns: &[u8],
    stars: &[Option<LargeScaleStar>],
) -> (usize, Option<LargeScaleStar>) {
    let map = &candidate.map;
    let mut at = candidate.robot;
    for (travel, (&turn, star)) in turns.iter().zip(stars).enumerate() {
        let Some(far) = map.far_end(clockwise_by(map, at, turn)) else { return (travel, None) };
        let predicted = Some(map.star(far.place).listed_from(far.slot));
        if predicted != *star || travel + 1 == turns.len() {
            return (travel, predicted);
        }
        at = map.opposite(far);
    }
    (0, None)
}

/// Candidates by what they predict.
struct Group {
    travel: usize,
    star: Option<LargeScaleStar>,
    candidates: u64,
}

/// How many candidates fall, whatever is seen.
struct Falls<'a> {
    groups: &'a [Group],
    travels: usize,
}

impl Falls<'_> {
    fn prediction(&self, group: &Group) -> Prediction {
        let &Group { travel, ref star, candidates } = group;
        let falls = match star {
            Some(star) => self.seen(travel, Some(star)),
            None => self.least_from(travel),
        };
        Prediction { travel, star: star.clone(), candidates, falls }
    }

    /// How many fall if the robot sees what the map predicts up to a travel, and at that one, where the map predicts
    /// something else or it is the last, a star; none is a star that no candidate predicts.
    fn seen(&self, travel: usize, star: Option<&LargeScaleStar>) -> u64 {
        let agrees = |group: &&Group| group.travel == travel && group.star.as_ref() == star;
        let falling = self.groups.iter().filter(|group| group.star.is_some() && !agrees(group));
        let known: u64 = falling.map(|group| group.candidates).sum();
        // Those that do not know of a later travel do know of this one: what the map predicts, which is not seen.
        let later = self.groups.iter().filter(|group| group.star.is_none() && group.travel > travel);
        known + later.map(|group| group.candidates).sum::<u64>()
    }

    /// The least that fall if what the map predicts is seen before a travel, and from then on anything may be.
    fn least_from(&self, travel: usize) -> u64 {
        let predicted = self.groups.iter().filter(|group| group.travel >= travel && group.star.is_some());
        let predicted = predicted.map(|group| self.seen(group.travel, group.star.as_ref()));
        predicted.chain((travel..self.travels).map(|travel| self.seen(travel, None))).min().unwrap_or(0)
    }
}
