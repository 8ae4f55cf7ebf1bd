//! The map itself.

use crate::map::{DstateId, InternedStar, PlaceId, SegmentId, StarId, StarTable};
use crate::star::{LargeScaleStar, LargeSlot, SlotIndex};
use std::sync::Arc;
use thiserror::Error;

/// A topological map: places with the stars of their first visits, and the path segments between them.
///
/// Law: path segments are an involution without fixed point on navigable dstates; that is the axiom
/// `determinism`, built in. A map made by [`TopologicalMap::with_new_place`] and [`TopologicalMap::with_segment`]
/// from one place is connected. Extending and cloning copy two small arrays, linear in dstates. Equality compares stars
/// and path segments.
#[derive(Clone, Debug)]
pub struct TopologicalMap {
    stars: Arc<StarTable>,
    pub(super) places: Vec<Place>,
    /// Of each dstate, by its position among all.
    pub(super) ways: Vec<Way>,
    pub(super) segments: u32,
    pub(super) closed_paths: u32,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    star: StarId,
    /// The number of its slots.
    size: u16,
    /// The position of its first dstate.
    first: u32,
}

/// Where a dstate leads; in four bytes, since maps are copied by the million.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Way {
    /// The place of the far end, if that is known, and its slot.
    far_place: Option<PlaceId>,
    far_slot: SlotIndex,
    /// The slot of the other direction of the same path, as the star has it.
    opposite: SlotIndex,
}

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
        let star = self.stars.intern(star).ok_or(MapError::Full)?;
        let to = DstateId { place: self.next_place().ok_or(MapError::Full)?, slot: gateway };
        match star.star().slots().get(gateway.0 as usize) {
            None => Err(MapError::UnknownDstate(to)),
            Some(slot) if !slot.navigable => Err(MapError::NotNavigable(to)),
            Some(_) => Ok(self.grown(from, &star, to)),
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
        let way = self.ways[self.index(dstate)];
        way.far_place.map(|place| DstateId { place, slot: way.far_slot })
    }

    /// The dstate of the other direction of the same path at the same place.
    pub fn opposite(&self, dstate: DstateId) -> DstateId {
        DstateId { slot: self.ways[self.index(dstate)].opposite, ..dstate }
    }

    /// The dstate one slot further clockwise at the same place.
    pub fn clockwise(&self, dstate: DstateId) -> DstateId {
        let next = dstate.slot.0 + 1;
        let last = u16::from(next) == self.places[dstate.place.index()].size;
        DstateId { slot: SlotIndex(if last { 0 } else { next }), ..dstate }
    }

    /// The star of a place, as it was at the first visit.
    pub fn star(&self, place: PlaceId) -> &LargeScaleStar {
        self.stars.star(self.star_id(place))
    }

    /// All places, by number.
    pub fn places(&self) -> impl Iterator<Item = PlaceId> + use<> {
        PlaceId::all().take(self.place_count())
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
        self.places.len()
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
        self.ways.len()
    }

    /// No map yet: memory to make one in, with stars from a table.
    pub(crate) fn blank(stars: Arc<StarTable>) -> Self {
        TopologicalMap { stars, places: Vec::new(), ways: Vec::new(), segments: 0, closed_paths: 0 }
    }

    /// The map of one place, its star interned.
    pub(crate) fn first(star: &InternedStar) -> Self {
        let mut map = TopologicalMap::blank(Arc::clone(&star.table));
        map.add_place(star);
        map
    }

    /// The number the next place gets, unless the map is full.
    pub(crate) fn next_place(&self) -> Option<PlaceId> {
        PlaceId::new(self.place_count())
    }

    /// This map with place `to.place`, its next one, behind `from`. The star's table extends the map's.
    pub(crate) fn grown(&self, from: DstateId, star: &InternedStar, to: DstateId) -> Self {
        let mut map = self.clone();
        map.grow(from, star, to);
        map
    }

    /// This map with a path segment between two different dstates, both navigable and without far end.
    pub(crate) fn joined(&self, from: DstateId, to: DstateId) -> Self {
        let mut map = self.clone();
        map.join(from, to);
        map
    }

    /// Makes this map the one that [`TopologicalMap::grown`] gives.
    pub(crate) fn grow(&mut self, from: DstateId, star: &InternedStar, to: DstateId) {
        self.add_place(star);
        self.add_segment(from, to);
    }

    /// Makes this map the one that [`TopologicalMap::joined`] gives.
    pub(crate) fn join(&mut self, from: DstateId, to: DstateId) {
        self.closed_paths += u32::from(self.closes(from, to));
        self.add_segment(from, to);
    }

    /// Whether a path segment between two dstates without far end makes a path closed.
    pub(crate) fn closes(&self, from: DstateId, to: DstateId) -> bool {
        self.other_end(from) == to
    }

    /// Which star of the table a place has.
    pub(crate) fn star_id(&self, place: PlaceId) -> StarId {
        self.places[place.index()].star
    }

    /// All places, by number, and which star of the table each has.
    pub(crate) fn places_with_stars(&self) -> impl Iterator<Item = (PlaceId, StarId)> {
        PlaceId::all().zip(self.places.iter().map(|place| place.star))
    }

    /// The position of a dstate among all dstates.
    pub(crate) fn index(&self, dstate: DstateId) -> usize {
        self.places[dstate.place.index()].first as usize + dstate.slot.0 as usize
    }

    /// The other end of the path that ends at `end`, a dstate without far end.
    fn other_end(&self, end: DstateId) -> DstateId {
        let mut at = self.opposite(end);
        while let Some(far) = self.far_end(at) {
            at = self.opposite(far);
        }
        at
    }

    fn add_place(&mut self, star: &InternedStar) {
        let slots = star.star().slots();
        if !Arc::ptr_eq(&self.stars, &star.table) {
            self.stars = Arc::clone(&star.table);
        }
        self.places.push(Place { star: star.id, size: slots.len() as u16, first: self.ways.len() as u32 });
        let way = |slot: &LargeSlot| Way { far_place: None, far_slot: SlotIndex(0), opposite: slot.opposite };
        self.ways.extend(slots.iter().map(way));
    }

    fn add_segment(&mut self, from: DstateId, to: DstateId) {
        for (near, far) in [(from, to), (to, from)] {
            let index = self.index(near);
            let way = &mut self.ways[index];
            (way.far_place, way.far_slot) = (Some(far.place), far.slot);
        }
        self.segments += 1;
    }

    fn joinable(&self, dstate: DstateId) -> Result<(), MapError> {
        let place = self.places.get(dstate.place.index()).ok_or(MapError::UnknownDstate(dstate))?;
        let slots = self.stars.star(place.star).slots();
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

impl PartialEq for TopologicalMap {
    fn eq(&self, other: &Self) -> bool {
        let same_star = |place| self.star(place) == other.star(place);
        self.ways == other.ways && self.place_count() == other.place_count() && self.places().all(same_star)
    }
}

impl Eq for TopologicalMap {}
