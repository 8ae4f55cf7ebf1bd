//! The registry of axioms.

use crate::abduction::Proposal;

/// A law that every candidate obeys.
#[derive(Debug)]
pub struct Axiom {
    /// Its name in the code.
    pub id: AxiomId,
    /// Its name outside.
    pub name: &'static str,
    /// What it says.
    pub statement: &'static str,
    /// Where it is from.
    pub source: &'static str,
    /// The profiles that hold it.
    pub profiles: &'static [Profile],
    /// Whether a search may go without it. The others are what a map and a candidate are made of.
    pub switchable: bool,
    /// Whether a child of a candidate that obeys the law obeys it too.
    pub holds: fn(&Proposal<'_>) -> bool,
}

/// The name of an axiom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AxiomId {
    /// `determinism`
    Determinism,
    /// `star-match`
    StarMatch,
    /// `travel-moves`
    TravelMoves,
    /// `path-order`
    PathOrder,
    /// `planarity`
    Planarity,
}

/// A choice of axioms with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Profile {
    /// The axioms of the seed.
    Paper,
    /// With planarity.
    Default,
}

const EVERY: &[Profile] = &[Profile::Paper, Profile::Default];

/// The axioms, in the order in which they judge: the first that does not hold is the one that refutes. Position
/// is [`AxiomId`]'s order.
pub static REGISTRY: [Axiom; 5] = [
    Axiom {
        id: AxiomId::Determinism,
        name: "determinism",
        statement: "The same travel leads from the same dstate to the same dstate: a gateway has one far end, \
                    another gateway, and travelling back through that one returns.",
        source: "seed, section 3.1; Remolina and Kuipers, IJCAI-01: causal schemas are deterministic",
        profiles: EVERY,
        switchable: false,
        holds: |proposal| match proposal {
            Proposal::Closure { branch, to } => branch.map().far_end(*to).is_none(),
            Proposal::Known { .. } | Proposal::NewPlace { .. } => true,
        },
    },
    Axiom {
        id: AxiomId::StarMatch,
        name: "star-match",
        statement: "Two visits are to one place only under a rotation that lays one star onto the other with \
                    order, pairing, control laws and navigability kept; a known path segment fixes the rotation.",
        source: "seed, sections 4.3 and 4.4",
        profiles: EVERY,
        switchable: false,
        holds: |proposal| !matches!(proposal, Proposal::Known { matches: false, .. }),
    },
    Axiom {
        id: AxiomId::TravelMoves,
        name: "travel-moves",
        statement: "A travel leads to another place.",
        source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: travel goes along a path to a later place",
        profiles: EVERY,
        switchable: true,
        holds: |proposal| match proposal {
            Proposal::Closure { branch, to } => to.place != branch.from().place,
            Proposal::Known { .. } | Proposal::NewPlace { .. } => true,
        },
    },
    Axiom {
        id: AxiomId::PathOrder,
        name: "path-order",
        statement: "The places on a path are strictly ordered: no place is twice on a path, no path is closed, \
                    and two path fragments of a place are never on one path.",
        source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: order along a path",
        profiles: EVERY,
        switchable: true,
        holds: |proposal| match proposal {
            Proposal::Closure { branch, to } => branch.paths_apart(*to),
            Proposal::Known { .. } | Proposal::NewPlace { .. } => true,
        },
    },
    Axiom {
        id: AxiomId::Planarity,
        name: "planarity",
        statement: "The rotation system of travelled path segments has genus 0.",
        source: "Savelli and Kuipers, IROS 2004",
        profiles: &[Profile::Default],
        switchable: true,
        holds: |proposal| match proposal {
            Proposal::Closure { branch, to } => branch.one_face(*to),
            Proposal::Known { .. } | Proposal::NewPlace { .. } => true,
        },
    },
];

impl AxiomId {
    /// The axiom.
    pub fn axiom(self) -> &'static Axiom {
        &REGISTRY[self as usize]
    }

    /// The axiom's name outside.
    pub fn name(self) -> &'static str {
        self.axiom().name
    }
}

impl Profile {
    /// All profiles.
    pub const ALL: [Profile; 2] = [Profile::Paper, Profile::Default];

    /// Its name outside.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Paper => "paper",
            Profile::Default => "default",
        }
    }
}
