//! The map itself.

use crate::map::{DstateId, InternedStar, PlaceId, SegmentId, StarId, StarTable};
use crate::star::{LargeScaleStar, SlotIndex};
use std::collections::VecDeque;
use std::iter;
use std::sync::Arc;
use thiserror::Error;

/// A topological map: places with the stars of their first visits, and the path segments between them.
///
/// Law: path segments are an involution without fixed point on navigable dstates; that is the axiom
/// `determinism`, built in. A map made by [`TopologicalMap::with_new_place`] and [`TopologicalMap::with_segment`]
/// from one place is connected. Extending copies one small array, linear in dstates, and for a new place those that
/// describe the places; a clone shares all. Equality compares stars and path segments.
#[derive(Clone, Debug)]
pub struct TopologicalMap {
    ground: Arc<Ground>,
    far_ends: Arc<[Option<DstateId>]>,
    segments: u32,
    closed_paths: u32,
}

/// The places without the path segments: a path segment adds nothing to it, so that many maps share one.
#[derive(Clone, Debug)]
struct Ground {
    stars: Arc<StarTable>,
    places: Box<[Place]>,
    /// For each dstate the slot of the other direction of its path, as its star has it.
    opposite: Box<[SlotIndex]>,
}

/// The places of maps just grown, for other maps that grow alike.
#[derive(Debug, Default)]
pub(crate) struct Grown(VecDeque<[Arc<Ground>; 2]>);

/// A path segment: one stretch of a path between two places next to each other on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Segment {
    /// Its name.
    pub id: SegmentId,
    /// The two dstates that face each other along it, the lower one first.
    pub ends: [DstateId; 2],
}

/// Why a map cannot be extended as asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum MapError {
    /// The place or the slot does not exist.
    #[error("the map has no dstate {0}")]
    UnknownDstate(DstateId),
    /// The slot has no outward gateway.
    #[error("dstate {0} has no outward gateway, expected one to join a path segment to")]
    NotNavigable(DstateId),
    /// The gateway has a far end.
    #[error("the gateway of dstate {0} has a far end already")]
    Taken(DstateId),
    /// A path segment from a gateway to itself.
    #[error("dstate {0} is given as both ends, expected two different gateways")]
    OneGateway(DstateId),
    /// More than [`PlaceId::LIMIT`] places.
    #[error("the map has {limit} places, which is the most it may have", limit = PlaceId::LIMIT)]
    Full,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    star: StarId,
    /// The number of its slots.
    size: u16,
    /// The position of its first dstate.
    first: u32,
}

/// How many a [`Grown`] remembers: candidates that grow alike are close in the order of candidates.
const REMEMBERED: usize = 16;

impl TopologicalMap {
    /// A map of one place.
    pub fn new(star: &LargeScaleStar) -> Result<Self, MapError> {
        let star = Arc::new(StarTable::default()).intern(star).ok_or(MapError::Full)?;
        Ok(TopologicalMap::first(&star))
    }

    /// This map with a new place at the far end of `from`, which lies beyond the new place's slot `gateway`.
    pub fn with_new_place(
        &self,
        from: DstateId,
        star: &LargeScaleStar,
        gateway: SlotIndex,
    ) -> Result<Self, MapError> {
        self.joinable(from)?;
        let star = self.ground.stars.intern(star).ok_or(MapError::Full)?;
        let to = DstateId { place: self.next_place().ok_or(MapError::Full)?, slot: gateway };
        match star.star().slots().get(gateway.0 as usize) {
            None => Err(MapError::UnknownDstate(to)),
            Some(slot) if !slot.navigable => Err(MapError::NotNavigable(to)),
            Some(_) => Ok(self.grown(from, &star, to, &mut Grown::default())),
        }
    }

    /// This map with a path segment between two gateways without far end.
    pub fn with_segment(&self, from: DstateId, to: DstateId) -> Result<Self, MapError> {
        self.joinable(from)?;
        self.joinable(to)?;
        if from == to {
            return Err(MapError::OneGateway(from));
        }
        Ok(self.joined(from, to))
    }

    /// The dstate reached by travelling away along `dstate`, facing back, if that is known.
    pub fn far_end(&self, dstate: DstateId) -> Option<DstateId> {
        self.far_ends[self.index(dstate)]
    }

    /// The dstate of the other direction of the same path at the same place.
    pub fn opposite(&self, dstate: DstateId) -> DstateId {
        DstateId { slot: self.ground.opposite[self.index(dstate)], ..dstate }
    }

    /// The dstate one slot further clockwise at the same place.
    pub fn clockwise(&self, dstate: DstateId) -> DstateId {
        let next = dstate.slot.0 + 1;
        let slot = SlotIndex(if u16::from(next) == self.ground.places[dstate.place.index()].size {
            0
        } else {
            next
        });
        DstateId { slot, ..dstate }
    }

    /// The star of a place, as it was at the first visit.
    pub fn star(&self, place: PlaceId) -> &LargeScaleStar {
        self.ground.stars.star(self.star_id(place))
    }

    /// All places, by number.
    pub fn places(&self) -> impl Iterator<Item = PlaceId> + use<> {
        (0..self.place_count()).filter_map(PlaceId::new)
    }

    /// The dstates of a place, clockwise.
    pub fn dstates_at(&self, place: PlaceId) -> impl Iterator<Item = DstateId> + use<> {
        (0..self.star(place).size() as u8).map(move |slot| DstateId { place, slot: SlotIndex(slot) })
    }

    /// All dstates, by place, then clockwise.
    pub fn dstates(&self) -> impl Iterator<Item = DstateId> + '_ {
        self.places().flat_map(|place| self.dstates_at(place))
    }

    /// All path segments, by lower end.
    pub fn segments(&self) -> Vec<Segment> {
        let lower = |near| self.far_end(near).filter(|&far| near < far).map(|far| [near, far]);
        let named = |(id, ends)| Segment { id: SegmentId(id), ends };
        (0..).zip(self.dstates().filter_map(lower)).map(named).collect()
    }

    /// The number of places.
    pub fn place_count(&self) -> usize {
        self.ground.places.len()
    }

    /// The number of path segments.
    pub fn segment_count(&self) -> usize {
        self.segments as usize
    }

    /// The number of paths, travelled or not: each path segment makes one path of two, unless it closes a path.
    pub fn path_count(&self) -> usize {
        self.dstate_count() / 2 - self.segment_count() + self.closed_paths as usize
    }

    /// The number of distinctive states.
    pub fn dstate_count(&self) -> usize {
        self.far_ends.len()
    }

    /// The map of one place, its star interned.
    pub(crate) fn first(star: &InternedStar) -> Self {
        let none = Ground { stars: Arc::default(), places: Box::default(), opposite: Box::default() };
        TopologicalMap {
            ground: Arc::new(none.with(star)),
            far_ends: iter::repeat_n(None, star.star().size()).collect(),
            segments: 0,
            closed_paths: 0,
        }
    }

    /// The number the next place gets, unless the map is full.
    pub(crate) fn next_place(&self) -> Option<PlaceId> {
        PlaceId::new(self.place_count())
    }

    /// This map with place `to.place`, its next one, behind `from`. The star's table extends the map's.
    /// The same memory serves maps that grow by one star alone.
    pub(crate) fn grown(&self, from: DstateId, star: &InternedStar, to: DstateId, known: &mut Grown) -> Self {
        let first = self.dstate_count();
        let new = iter::repeat_n(None, star.star().size());
        let mut far_ends: Arc<[_]> = self.far_ends.iter().copied().chain(new).collect();
        let cells = Arc::make_mut(&mut far_ends);
        cells[self.index(from)] = Some(to);
        cells[first + to.slot.0 as usize] = Some(from);
        TopologicalMap {
            ground: known.with(&self.ground, star),
            far_ends,
            segments: self.segments + 1,
            closed_paths: self.closed_paths,
        }
    }

    /// This map with a path segment between two different dstates, both navigable and without far end.
    pub(crate) fn joined(&self, from: DstateId, to: DstateId) -> Self {
        let mut far_ends = Arc::clone(&self.far_ends);
        let cells = Arc::make_mut(&mut far_ends);
        cells[self.index(from)] = Some(to);
        cells[self.index(to)] = Some(from);
        TopologicalMap {
            ground: Arc::clone(&self.ground),
            far_ends,
            segments: self.segments + 1,
            closed_paths: self.closed_paths + u32::from(self.other_end(from) == to),
        }
    }

    /// Which star of the table a place has.
    pub(crate) fn star_id(&self, place: PlaceId) -> StarId {
        self.ground.places[place.index()].star
    }

    /// The position of a dstate among all dstates.
    pub(crate) fn index(&self, dstate: DstateId) -> usize {
        self.ground.places[dstate.place.index()].first as usize + dstate.slot.0 as usize
    }

    /// The other end of the path that ends at `end`, a dstate without far end.
    fn other_end(&self, end: DstateId) -> DstateId {
        let mut at = self.opposite(end);
        while let Some(far) = self.far_end(at) {
            at = self.opposite(far);
        }
        at
    }

    fn joinable(&self, dstate: DstateId) -> Result<(), MapError> {
        let place = self.ground.places.get(dstate.place.index()).ok_or(MapError::UnknownDstate(dstate))?;
        let slots = self.ground.stars.star(place.star).slots();
        let slot = slots.get(dstate.slot.0 as usize).ok_or(MapError::UnknownDstate(dstate))?;
        if !slot.navigable {
            return Err(MapError::NotNavigable(dstate));
        }
        match self.far_end(dstate) {
            Some(_) => Err(MapError::Taken(dstate)),
            None => Ok(()),
        }
    }
}

impl Ground {
    /// These places and one more. The star's table extends that of the places.
    fn with(&self, star: &InternedStar) -> Ground {
        let slots = star.star().slots();
        let place = Place { star: star.id, size: slots.len() as u16, first: self.opposite.len() as u32 };
        Ground {
            stars: Arc::clone(&star.table),
            places: self.places.iter().copied().chain([place]).collect(),
            opposite: self.opposite.iter().copied().chain(slots.iter().map(|slot| slot.opposite)).collect(),
        }
    }
}

impl Grown {
    fn with(&mut self, ground: &Arc<Ground>, star: &InternedStar) -> Arc<Ground> {
        if let Some([_, grown]) = self.0.iter().find(|[known, _]| Arc::ptr_eq(known, ground)) {
            return Arc::clone(grown);
        }
        let grown = Arc::new(ground.with(star));
        self.0.truncate(REMEMBERED - 1);
        self.0.push_front([Arc::clone(ground), Arc::clone(&grown)]);
        grown
    }
}

impl PartialEq for TopologicalMap {
    fn eq(&self, other: &Self) -> bool {
        let same_star = |place| self.star(place) == other.star(place);
        self.far_ends == other.far_ends
            && self.place_count() == other.place_count()
            && self.places().all(same_star)
    }
}

impl Eq for TopologicalMap {}
