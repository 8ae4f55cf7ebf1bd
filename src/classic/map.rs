//! The map of a candidate: dstates, and what follows for places and paths.

use crate::classic::order::check_stops;
use crate::classic::{Action, AxiomId, Simplicity, ViewId};
use std::num::NonZeroU16;
use std::sync::Arc;

/// A dstate of a map, numbered by first visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DstateId(NonZeroU16); // one more than the number, so that an absent one takes no room

/// What a map says of a dstate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Dstate {
    /// Its view.
    pub view: ViewId,
    /// Where each action leads from it, in the order of [`Action::ALL`]; none where that was not tried.
    pub after: [Option<DstateId>; 4],
    /// The place it is at, named by the place's first dstate.
    pub place: DstateId,
    /// The path it faces along, named by the path's first dstate.
    pub path: DstateId,
    /// Whether it faces against the path's first dstate.
    pub reversed: bool,
}

/// Causal schemas under which the axioms hold, and the places and paths that follow from them.
///
/// Equal if and only if dstates, schemas and views are. Sixteen bytes a dstate; a clone shares them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ClassicMap {
    dstates: Arc<[Dstate]>,
}

impl ClassicMap {
    /// The map of one dstate.
    pub fn first(view: ViewId) -> ClassicMap {
        ClassicMap { dstates: Arc::new([Dstate::alone(view, DstateId::FIRST)]) }
    }

    /// The dstates, by number.
    pub fn dstates(&self) -> &[Dstate] {
        &self.dstates
    }

    /// The dstates by name, ascending.
    pub fn ids(&self) -> impl Iterator<Item = DstateId> + use<> {
        (0..self.dstates.len()).filter_map(DstateId::new)
    }

    /// What the map says of a dstate, which must be one of its own.
    pub fn dstate(&self, id: DstateId) -> &Dstate {
        &self.dstates[id.index()]
    }

    /// Where a known causal schema leads.
    pub fn after(&self, from: DstateId, action: Action) -> Option<DstateId> {
        self.dstate(from).after[action as usize]
    }

    /// The map with one causal schema more, between its own dstates, or the axiom that does not hold then. The
    /// schema must be new. Linear in the dstates but for a sort.
    pub fn joined(&self, from: DstateId, action: Action, to: DstateId) -> Result<ClassicMap, AxiomId> {
        with_schema(self.dstates.to_vec(), from, action, to)
    }

    /// The same with a new dstate to which the schema leads, and its name.
    pub fn grown(
        &self,
        from: DstateId,
        action: Action,
        view: ViewId,
    ) -> Option<(DstateId, Result<ClassicMap, AxiomId>)> {
        let to = DstateId::new(self.dstates.len())?;
        let mut dstates = Vec::with_capacity(self.dstates.len() + 1);
        dstates.extend_from_slice(&self.dstates);
        dstates.push(Dstate::alone(view, to));
        Some((to, with_schema(dstates, from, action, to)))
    }

    /// How many paths, travelled or not, and places.
    pub fn simplicity(&self) -> Simplicity {
        let heads = |name: fn(&Dstate) -> DstateId| {
            self.ids().zip(&*self.dstates).filter(|(id, dstate)| name(dstate) == *id).count()
        };
        Simplicity { paths: heads(|dstate| dstate.path), places: heads(|dstate| dstate.place) }
    }
}

impl DstateId {
    /// The first dstate.
    pub const FIRST: DstateId = DstateId(NonZeroU16::MIN);
    /// The most dstates that a map may have.
    pub const LIMIT: usize = u16::MAX as usize;

    /// The dstate of a number from 0, if it is below [`DstateId::LIMIT`].
    pub fn new(index: usize) -> Option<DstateId> {
        u16::try_from(index + 1).ok().and_then(NonZeroU16::new).map(DstateId)
    }

    /// Its number, from 0.
    pub fn index(self) -> usize {
        usize::from(self.0.get()) - 1
    }
}

impl Dstate {
    /// A dstate that nothing is known of but its view.
    fn alone(view: ViewId, own: DstateId) -> Dstate {
        Dstate { view, after: [None; 4], place: own, path: own, reversed: false }
    }
}

/// Adds a schema to dstates whose places and paths are right without it.
fn with_schema(
    mut dstates: Vec<Dstate>,
    from: DstateId,
    action: Action,
    to: DstateId,
) -> Result<ClassicMap, AxiomId> {
    dstates[from.index()].after[action as usize] = Some(to);
    if action.is_turn() {
        join_places(&mut dstates, from, to);
    }
    if !action.changes_path() {
        join_paths(&mut dstates, from, to, action == Action::Around)?;
    }
    check_turns(&dstates)?;
    check_stops(&dstates)?;
    Ok(ClassicMap { dstates: dstates.into() })
}

/// Makes the places of two dstates one, under the lesser name.
fn join_places(dstates: &mut [Dstate], a: DstateId, b: DstateId) {
    let (a, b) = (dstates[a.index()].place, dstates[b.index()].place);
    let (name, gone) = (a.min(b), a.max(b));
    dstates.iter_mut().filter(|dstate| dstate.place == gone).for_each(|dstate| dstate.place = name);
}

/// Makes the paths of two dstates one, under the lesser name, such that they face the same way or, if `against`,
/// opposite ways. Fails where they are on one path already and do not.
fn join_paths(dstates: &mut [Dstate], a: DstateId, b: DstateId, against: bool) -> Result<(), AxiomId> {
    let (a, b) = (dstates[a.index()], dstates[b.index()]);
    let flip = (a.reversed != b.reversed) != against;
    if a.path == b.path {
        return if flip { Err(AxiomId::Direction) } else { Ok(()) };
    }
    let (name, gone) = (a.path.min(b.path), a.path.max(b.path));
    for dstate in dstates.iter_mut().filter(|dstate| dstate.path == gone) {
        (dstate.path, dstate.reversed) = (name, dstate.reversed != flip);
    }
    Ok(())
}

fn check_turns(dstates: &[Dstate]) -> Result<(), AxiomId> {
    let stays = |dstate: &Dstate| {
        let turned = Action::ALL.into_iter().filter(|action| action.changes_path());
        let mut turned = turned.filter_map(|action| dstate.after[action as usize]);
        turned.any(|to| dstates[to.index()].path == dstate.path)
    };
    if dstates.iter().any(stays) { Err(AxiomId::TurnPath) } else { Ok(()) }
}
