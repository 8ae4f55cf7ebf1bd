//! One reading made equal to another, slot for slot, by what may have been read wrongly.
//!
//! Gateways are laid onto gateways in their clockwise order; those left over on one side are dropped, those on the
//! other added. Then the star is that of the other visit, and what differs from what was read are the changes. What
//! follows from a gateway dropped or added (a path that ends without it, or goes on through it) is no change of its own.

use crate::geometry::wrap_angle;
use crate::mending::{Doubt, Opening, Reading, Sum};
use crate::star::{ControlLaw, Slot, SlotIndex, SmallScaleStar};
use crate::trace::Sighting;
use std::f64::consts::{FRAC_PI_4, PI};

/// A reading that is taken otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The observation, counted from 0.
    pub observation: usize,
    /// The slot as it was read, clockwise; `None` for a gateway that was not read.
    pub slot: Option<SlotIndex>,
    /// Its outward direction in the frame of the observation, radians, where that is known.
    pub bearing: Option<f64>,
    /// What is taken otherwise.
    pub kind: ChangeKind,
    /// How far the reading was from it.
    pub doubt: Doubt,
    /// The observation whose place it is taken to be of.
    pub like: Option<usize>,
}

/// What is taken otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeKind {
    /// The control law.
    Label {
        /// As it was read.
        from: ControlLaw,
        /// As it is taken.
        to: ControlLaw,
    },
    /// Whether, and with which gateway, the slot is on one path.
    Path,
    /// The place of the end of a path among the gateways.
    Order,
    /// A gateway is none.
    Dropped,
    /// An opening that was a little too narrow is a gateway.
    Added,
    /// An opening too narrow for a gateway is one, because the robot went through it on another visit. That is as doubtful as
    /// anything may be: whether it is the same opening is what is to be found out.
    Driven,
    /// A gateway is none, and without it the place is none: the robot was on its way along a path.
    Passed,
    /// On the way there the robot passed the place of another observation unseen. That is as doubtful as anything may be, so
    /// that no reading is left as it was for it.
    Missed,
}

/// A reading likened to another one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Likening {
    /// The visit it is likened to.
    pub(super) target: usize,
    /// The visit as it is taken; its departure is by a slot of the visit before as that was read.
    pub(super) sighting: Sighting,
    /// The slot by which the robot left, on the star as it is taken.
    pub(super) departure: Option<SlotIndex>,
    pub(super) changes: Vec<Change>,
}

impl Likening {
    pub(super) fn sum(&self) -> Sum {
        Sum::default().and(self.changes.iter().map(|change| change.doubt))
    }
}

/// Readings of more gateways are left as they are.
const MOST_GATES: usize = 16;
/// So many gateways are dropped, and so many added, at most.
const MOST_CHANGED: usize = 2;
/// An opening lies no further than an eighth of a turn from where the other visit has its gateway.
const OPENING_TOLERANCE: f64 = FRAC_PI_4;

/// All ways of likening a visit to another one, the least doubtful first.
pub(super) fn likenings(readings: &[Reading], visit: usize, target: usize) -> Vec<Likening> {
    let Some(pair) = Pair::new(readings, visit, target) else { return Vec::new() };
    if pair.gates.iter().any(|gates| gates.len() > MOST_GATES) {
        return Vec::new();
    }
    let mut found: Vec<Likening> = pair.layings().iter().filter_map(|laying| pair.likened(laying)).collect();
    found.sort_by_key(Likening::sum);
    found
}

/// What must be taken otherwise for a visit to be none: all gateways but those of one path, on which the robot came in and
/// left again. `None` where that is beyond doubt, and at either end of the walk, where nothing tells.
pub(super) fn passing(readings: &[Reading], visit: usize) -> Option<Vec<Change>> {
    let Sighting { star, arrival, departure, .. } = &readings.get(visit)?.sighting;
    let left = readings.get(visit + 1)?.sighting.departure?;
    let through = departure.is_some() && left == *arrival && leads_out(star, *arrival);
    let others = gates(star).into_iter().filter(|&gate| gate != left && gate != star.opposite(left));
    let dropped = |gate: SlotIndex| {
        let (slot, bearing) = (Some(gate), star.slot(gate)?.bearing);
        let doubt = slot_doubt(star, gate)?;
        Some(Change { observation: visit, slot, bearing, kind: ChangeKind::Passed, doubt, like: None })
    };
    if through { others.map(dropped).collect() } else { None }
}

/// A visit, and the one it is likened to.
struct Pair<'a> {
    visit: usize,
    target: usize,
    seen: &'a Reading,
    like: &'a Reading,
    departure: Option<SlotIndex>,
    /// The slots of the outward gateways of each, clockwise.
    gates: [Vec<SlotIndex>; 2],
}

/// For each gateway of the other visit, in their order, the slot of this one that lies on it.
type Laying = Vec<Option<SlotIndex>>;

impl<'a> Pair<'a> {
    fn new(readings: &'a [Reading], visit: usize, target: usize) -> Option<Pair<'a>> {
        let (seen, like) = (readings.get(visit)?, readings.get(target)?);
        let departure = readings.get(visit + 1).and_then(|next| next.sighting.departure);
        let gates = [seen, like].map(|reading| gates(&reading.sighting.star));
        Some(Pair { visit, target, seen, like, departure, gates })
    }

    fn star(&self) -> &SmallScaleStar {
        &self.seen.sighting.star
    }

    fn wanted(&self) -> &SmallScaleStar {
        &self.like.sighting.star
    }

    /// Whether the robot passed a gateway on this visit.
    fn used(&self, gate: SlotIndex) -> bool {
        let Sighting { arrival, departure, .. } = self.seen.sighting;
        self.departure == Some(gate) || (departure.is_some() && self.star().opposite(arrival) == gate)
    }

    /// All ways of laying gateways onto gateways in their order.
    fn layings(&self) -> Vec<Laying> {
        let [own, wanted] = &self.gates;
        let droppable: Vec<usize> = (0..own.len())
            .filter(|&k| !self.used(own[k]) && slot_doubt(self.star(), own[k]).is_some())
            .collect();
        let all: Vec<usize> = (0..wanted.len()).collect();
        let most = MOST_CHANGED.min(self.seen.openings.len());
        let mut found = Vec::new();
        for dropped in subsets(&droppable, MOST_CHANGED) {
            let kept: Vec<SlotIndex> =
                (0..own.len()).filter(|k| !dropped.contains(k)).map(|k| own[k]).collect();
            let fitting = subsets(&all, most).into_iter();
            for added in fitting.filter(|added| wanted.len() == kept.len() + added.len() && !kept.is_empty())
            {
                found.extend((0..kept.len()).map(|shift| {
                    let mut next = kept.iter().cycle().skip(shift);
                    all.iter().map(|k| if added.contains(k) { None } else { next.next().copied() }).collect()
                }));
            }
        }
        found
    }

    /// The visit under a laying, if every change it needs is within the limit.
    fn likened(&self, laying: &Laying) -> Option<Likening> {
        let mut changes = self.dropped(laying)?;
        let openings = self.openings(laying)?;
        changes.extend(self.added(laying, &openings)?);
        let laid: Vec<(SlotIndex, SlotIndex)> =
            self.wanted().indices().filter_map(|slot| Some((slot, self.own(laying, slot)?))).collect();
        for &(slot, own) in &laid {
            changes.extend(self.changed(laying, slot, own)?);
        }
        let star = self.taken(laying, &openings)?;
        let on = |own: SlotIndex| laid.iter().find(|&&(_, other)| other == own).map(|&(slot, _)| slot);
        let departure = match self.departure {
            Some(own) => Some(on(own)?),
            None => None,
        };
        let seen = &self.seen.sighting;
        let arrival = match seen.departure {
            // The robot came in by a gateway, which was kept.
            Some(_) => star.opposite(on(self.star().opposite(seen.arrival))?),
            None => on(seen.arrival).unwrap_or(SlotIndex(0)),
        };
        let sighting = Sighting { star, arrival, ..seen.clone() };
        (!changes.is_empty()).then_some(Likening { target: self.target, sighting, departure, changes })
    }

    /// The slot of this visit that lies on one of the other: a gateway, or the end of a path that comes in by one.
    fn own(&self, laying: &Laying, slot: SlotIndex) -> Option<SlotIndex> {
        let gate = |gate: SlotIndex| {
            let at = self.gates[1].iter().position(|&other| other == gate)?;
            laying[at]
        };
        if leads_out(self.wanted(), slot) {
            return gate(slot);
        }
        let end = self.star().opposite(gate(self.wanted().opposite(slot))?);
        (!leads_out(self.star(), end)).then_some(end)
    }

    fn change(&self, slot: SlotIndex, kind: ChangeKind, doubt: Doubt) -> Change {
        let bearing = self.star().slot(slot).and_then(|slot| slot.bearing);
        Change { observation: self.visit, slot: Some(slot), bearing, kind, doubt, like: Some(self.target) }
    }

    fn dropped(&self, laying: &Laying) -> Option<Vec<Change>> {
        let gone = self.gates[0].iter().filter(|gate| !laying.contains(&Some(**gate)));
        gone.map(|&gate| Some(self.change(gate, ChangeKind::Dropped, slot_doubt(self.star(), gate)?)))
            .collect()
    }

    /// For each gateway added, in the order of the other visit's, the opening that it is; `None` where there is none.
    fn openings(&self, laying: &Laying) -> Option<Vec<Option<Opening>>> {
        let turned = self.turned(laying)?;
        let mut left = self.seen.openings.clone();
        let opening = |(&gate, own): (&SlotIndex, &Option<SlotIndex>)| {
            if own.is_some() {
                return Some(None);
            }
            let bearing = self.wanted().slot(gate)?.bearing? + turned;
            let off = |one: &Opening| wrap_angle(one.bearing - bearing).abs();
            let nearest = (0..left.len()).min_by(|&a, &b| off(&left[a]).total_cmp(&off(&left[b])))?;
            (off(&left[nearest]) <= OPENING_TOLERANCE).then(|| Some(left.remove(nearest)))
        };
        self.gates[1].iter().zip(laying).map(opening).collect()
    }

    /// By how much this visit's frame is turned against the other one's, as the gateways laid onto each other have it; 0
    /// where no bearings tell.
    fn turned(&self, laying: &Laying) -> Option<f64> {
        let bearing = |star: &SmallScaleStar, slot: SlotIndex| star.slot(slot)?.bearing;
        let pairs = self.gates[1].iter().zip(laying);
        let turns: Vec<f64> = pairs
            .filter_map(|(&gate, own)| Some(bearing(self.star(), (*own)?)? - bearing(self.wanted(), gate)?))
            .collect();
        let Some(&first) = turns.first() else { return Some(0.0) };
        let mean = turns.iter().map(|turn| wrap_angle(turn - first)).sum::<f64>() / turns.len() as f64;
        Some(first + mean)
    }

    fn added(&self, laying: &Laying, openings: &[Option<Opening>]) -> Option<Vec<Change>> {
        let new = self.gates[1].iter().zip(laying).zip(openings).filter(|((_, own), _)| own.is_none());
        new.map(|((gate, _), opening)| {
            let opening = (*opening)?;
            let (kind, doubt) = match self.like.driven.contains(gate) {
                true => (ChangeKind::Driven, Doubt::LIMIT),
                false => (ChangeKind::Added, opening.doubt?),
            };
            let (observation, like) = (self.visit, Some(self.target));
            Some(Change { observation, slot: None, bearing: Some(opening.bearing), kind, doubt, like })
        })
        .collect()
    }

    /// What is taken otherwise of a slot of this visit that lies on one of the other; an error, as `None`, if that is
    /// beyond doubt.
    fn changed(&self, laying: &Laying, slot: SlotIndex, own: SlotIndex) -> Option<Vec<Change>> {
        let (Some(wanted), Some(seen)) = (self.wanted().slot(slot), self.star().slot(own)) else {
            return Some(Vec::new());
        };
        let kind = if wanted.control != seen.control {
            ChangeKind::Label { from: seen.control, to: wanted.control }
        } else if wanted.outward.is_some() && self.is_repaired(laying, slot, own) {
            ChangeKind::Path
        } else if wanted.outward.is_none() && self.is_misplaced(laying, slot, own) {
            ChangeKind::Order
        } else {
            return Some(Vec::new());
        };
        Some(vec![self.change(own, kind, slot_doubt(self.star(), own)?)])
    }

    /// Whether the path of a gateway goes on otherwise, which nothing dropped or added explains.
    fn is_repaired(&self, laying: &Laying, slot: SlotIndex, own: SlotIndex) -> bool {
        let partner = |star: &SmallScaleStar, slot: SlotIndex| {
            Some(star.opposite(slot)).filter(|&other| leads_out(star, other))
        };
        let (wanted, seen) = (partner(self.wanted(), slot), partner(self.star(), own));
        let added = wanted.is_some_and(|partner| self.own(laying, partner).is_none());
        let dropped = seen.is_some_and(|partner| !laying.contains(&Some(partner)));
        match (wanted, seen) {
            (Some(wanted), Some(seen)) => !added && !dropped && self.own(laying, wanted) != Some(seen),
            (Some(_), None) => !added,
            (None, Some(_)) => !dropped,
            (None, None) => false,
        }
    }

    /// Whether the end of a path comes after another slot than it was read after, of those that lie on each other.
    fn is_misplaced(&self, laying: &Laying, slot: SlotIndex, own: SlotIndex) -> bool {
        let before = |star: &SmallScaleStar, at: SlotIndex, lies: &dyn Fn(SlotIndex) -> Option<SlotIndex>| {
            let n = star.slots().len();
            (1..n).find_map(|back| lies(SlotIndex(((usize::from(at.0) + n - back) % n) as u8)))
        };
        let ahead = before(self.wanted(), slot, &|slot| self.own(laying, slot));
        let laid: Vec<SlotIndex> =
            self.wanted().indices().filter_map(|slot| self.own(laying, slot)).collect();
        ahead != before(self.star(), own, &|slot| Some(slot).filter(|slot| laid.contains(slot)))
    }

    /// The star of the other visit with what was measured on this one.
    fn taken(&self, laying: &Laying, openings: &[Option<Opening>]) -> Option<SmallScaleStar> {
        let slot = |(slot, wanted): (SlotIndex, &Slot)| {
            let own = self.own(laying, slot).and_then(|own| self.star().slot(own));
            let (bearing, width, margin) = match own {
                Some(own) => (own.bearing, own.width, own.margin),
                None => {
                    let at = self.gates[1].iter().position(|&gate| gate == slot);
                    let opening = at.and_then(|at| openings.get(at).copied().flatten());
                    (opening.map(|one| one.bearing), opening.map(|one| one.width), None)
                }
            };
            Slot { bearing, width, margin, ..wanted.clone() }
        };
        let slots = self.wanted().indices().zip(self.wanted().slots()).map(slot);
        let mut slots: Vec<Slot> = slots.collect();
        for at in self.wanted().indices() {
            let behind = slots[usize::from(self.wanted().opposite(at).0)].bearing;
            let slot = &mut slots[usize::from(at.0)];
            if slot.outward.is_none() && slot.bearing.is_none() {
                slot.bearing = behind.map(|bearing| wrap_angle(bearing + PI));
            }
        }
        SmallScaleStar::new(slots).ok()
    }
}

/// The slots with an outward gateway, clockwise.
fn gates(star: &SmallScaleStar) -> Vec<SlotIndex> {
    star.indices().filter(|&slot| leads_out(star, slot)).collect()
}

fn leads_out(star: &SmallScaleStar, slot: SlotIndex) -> bool {
    star.slot(slot).is_some_and(|slot| slot.outward.is_some())
}

/// How doubtful a slot is, if it is.
fn slot_doubt(star: &SmallScaleStar, slot: SlotIndex) -> Option<Doubt> {
    star.slot(slot)?.margin.and_then(Doubt::of)
}

/// All subsets of so many at most, the smaller first.
fn subsets(of: &[usize], most: usize) -> Vec<Vec<usize>> {
    let mut found: Vec<Vec<usize>> = vec![Vec::new()];
    let mut start = 0;
    for _ in 0..most {
        let end = found.len();
        for at in start..end {
            let from =
                found[at].last().and_then(|last| of.iter().position(|one| one == last)).map_or(0, |k| k + 1);
            let longer: Vec<Vec<usize>> =
                of[from..].iter().map(|&next| [&found[at][..], &[next]].concat()).collect();
            found.extend(longer);
        }
        start = end;
    }
    found
}
