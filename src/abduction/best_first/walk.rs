//! The experience as the quotient needs it: every star in one row of dstates.

use super::rotations::Rotations;
use crate::abduction::Visit;
use crate::star::LargeScaleStar;

/// A walk: the stars as observed, the gateways left by and come in by. It grows by a visit at a time.
#[derive(Clone, Debug, Default)]
pub(super) struct Walk {
    visits: Vec<Stop>,
    /// The visit of each dstate.
    owner: Vec<u16>,
    opposite: Vec<u8>,
    /// The stars told apart.
    stars: Vec<LargeScaleStar>,
    /// For each two of them the rotations that lay the first onto the second.
    matches: Vec<Vec<Vec<u8>>>,
}

#[derive(Clone, Copy, Debug)]
struct Stop {
    /// The position of its first dstate among those of all visits.
    first: u32,
    size: u8,
    star: u16,
    departure: u8,
    gateway: u8,
    blocked: u8,
    navigable: Rotations,
}

impl Walk {
    /// Goes on to a visit, which follows on the last one in the trace. Linear in the stars told apart.
    pub(super) fn push(&mut self, visit: &Visit) {
        let star = self.number(&visit.star);
        let slots = visit.star.slots();
        self.visits.push(Stop {
            first: self.opposite.len() as u32,
            size: slots.len() as u8,
            star: star as u16,
            departure: visit.departure.map_or(0, |slot| slot.0),
            gateway: slots[visit.arrival.0 as usize].opposite.0,
            navigable: navigable(&visit.star),
            blocked: slots.iter().filter(|slot| !slot.navigable).count() as u8,
        });
        self.owner.extend(std::iter::repeat_n(self.visits.len() as u16 - 1, slots.len()));
        self.opposite.extend(slots.iter().map(|slot| slot.opposite.0));
    }

    fn number(&mut self, star: &LargeScaleStar) -> usize {
        if let Some(known) = self.stars.iter().position(|known| known == star) {
            return known;
        }
        for (known, matches) in self.stars.iter().zip(&mut self.matches) {
            matches.push(star.alignments(known));
        }
        self.stars.push(star.clone());
        self.matches.push(self.stars.iter().map(|known| known.alignments(star)).collect());
        self.stars.len() - 1
    }

    /// Bytes held, as many as there is something in them.
    pub(super) fn bytes(&self) -> usize {
        let stars: usize = self.stars.iter().map(|star| size_of_val(star.slots())).sum();
        let rotations: usize =
            self.matches.iter().flatten().map(|matches| size_of::<Vec<u8>>() + matches.len()).sum();
        size_of_val(self.visits.as_slice())
            + size_of_val(self.owner.as_slice())
            + self.opposite.len()
            + stars
            + rotations
    }

    /// The number of visits.
    pub(super) fn len(&self) -> usize {
        self.visits.len()
    }

    /// The number of dstates of all stars observed.
    pub(super) fn dstates(&self) -> usize {
        self.opposite.len()
    }

    /// The number of slots of a visit's star.
    pub(super) fn size(&self, visit: usize) -> usize {
        self.visits[visit].size as usize
    }

    /// The position of a slot of a visit's star among all dstates.
    pub(super) fn dstate(&self, visit: usize, slot: usize) -> usize {
        self.visits[visit].first as usize + slot
    }

    /// The visit and slot of a dstate by its position.
    pub(super) fn place_of(&self, dstate: usize) -> (usize, usize) {
        let visit = self.owner[dstate] as usize;
        (visit, dstate - self.visits[visit].first as usize)
    }

    /// The dstate one slot further clockwise at the same visit.
    pub(super) fn clockwise(&self, dstate: usize) -> usize {
        let stop = &self.visits[self.owner[dstate] as usize];
        let next = dstate + 1;
        if next == stop.first as usize + stop.size as usize { stop.first as usize } else { next }
    }

    /// The slot of the other direction of the same path fragment.
    pub(super) fn opposite(&self, visit: usize, slot: usize) -> usize {
        self.opposite[self.dstate(visit, slot)] as usize
    }

    /// The slots with an outward gateway, one bit each; none for stars without sets.
    pub(super) fn navigable(&self, visit: usize) -> Rotations {
        self.visits[visit].navigable
    }

    /// The number of slots of a visit's star at which a path ends.
    pub(super) fn blocked(&self, visit: usize) -> usize {
        self.visits[visit].blocked as usize
    }

    /// The gateway of the visit before by which the robot left, and that of this visit by which it came.
    pub(super) fn travel(&self, visit: usize) -> (usize, usize) {
        (self.visits[visit].departure as usize, self.visits[visit].gateway as usize)
    }

    /// The rotations that lay the star of one visit onto that of another, ascending.
    pub(super) fn matches(&self, visit: usize, onto: usize) -> &[u8] {
        &self.matches[self.visits[visit].star as usize][self.visits[onto].star as usize]
    }

    /// Whether sets of rotations are kept for a visit's star.
    pub(super) fn tracked(&self, visit: usize) -> bool {
        self.size(visit) <= Rotations::BITS as usize
    }
}

fn navigable(star: &LargeScaleStar) -> Rotations {
    match star.size() <= Rotations::BITS as usize {
        true => star.slots().iter().rev().fold(0, |set, slot| set << 1 | Rotations::from(slot.navigable)),
        false => 0,
    }
}
