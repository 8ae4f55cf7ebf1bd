//! The axioms of the causal and topological theory.

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
}

/// The name of an axiom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AxiomId {
    /// `view`
    View,
    /// `determinism`
    Determinism,
    /// `direction`
    Direction,
    /// `turn-path`
    TurnPath,
    /// `one-dstate`
    OneDstate,
    /// `path-order`
    PathOrder,
}

/// The axioms, in the order in which they judge: the first that does not hold is the one that refutes. Position is
/// [`AxiomId`]'s order.
///
/// Three laws need no judge, as they say what places and paths *are*. A turn keeps the place, and dstates are at one
/// place only if turns join them, directly or through others: a place is a class of dstates under turns. A travel
/// keeps path and direction, a turn around keeps the path and flips the direction, and nothing else puts two dstates
/// on one path: a path is a class of dstates under both. Every dstate faces along one path, travelled or not.
///
/// What follows: a turn around twice returns (`one-dstate`), and two dstates of which each is turned around to the
/// same third are one. What does not follow: that a left turn undoes a right turn, that so many left turns return,
/// that a travel back returns (it may end at a place that the travel there passed by), that of two places on a path
/// one comes first. Order is only what travels show.
pub static AXIOMS: [Axiom; 6] = [
    Axiom {
        id: AxiomId::View,
        name: "view",
        statement: "A dstate has one view.",
        source: "seed, section 3.1",
    },
    Axiom {
        id: AxiomId::Determinism,
        name: "determinism",
        statement: "The same action from the same dstate leads to the same dstate.",
        source: "seed, section 3.1; Remolina and Kuipers, IJCAI-01: causal schemas are deterministic",
    },
    Axiom {
        id: AxiomId::Direction,
        name: "direction",
        statement: "A dstate faces along one path in one of its two directions, never in both.",
        source: "Remolina and Kuipers, IJCAI-01: along; turn around and travel",
    },
    Axiom {
        id: AxiomId::TurnPath,
        name: "turn-path",
        statement: "A turn left or right leads onto another path.",
        source: "Remolina and Kuipers, IJCAI-01: turns that are not turn around",
    },
    Axiom {
        id: AxiomId::OneDstate,
        name: "one-dstate",
        statement: "A place has one dstate for each direction of each of its paths.",
        source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: topological indistinguishability",
    },
    Axiom {
        id: AxiomId::PathOrder,
        name: "path-order",
        statement: "A travel leads to a later place of its path, and the order of the places on a path is strict: no \
                    travel stays at its place, no place comes twice, no path is closed.",
        source: "seed, section 4.1; Remolina and Kuipers, IJCAI-01: order along a path",
    },
];

impl AxiomId {
    /// The axiom.
    pub fn axiom(self) -> &'static Axiom {
        &AXIOMS[self as usize]
    }

    /// The axiom's name outside.
    pub fn name(self) -> &'static str {
        self.axiom().name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axioms_are_in_the_order_of_their_ids() {
        assert!(AXIOMS.iter().enumerate().all(|(position, axiom)| axiom.id as usize == position));
    }
}
