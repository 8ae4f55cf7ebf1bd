//! What an axiom is.

use crate::abduction::{Clash, Evidence, Proposal};

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
    pub check: Check,
}

/// How an axiom is checked.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// By the map alone.
    Symbols {
        /// Whether it holds of a child.
        holds: fn(&Proposal<'_>) -> bool,
        /// Why it does not hold of a child; asked for only where it does not.
        clash: fn(&Proposal<'_>) -> Clash,
    },
    /// By what was measured: [`Evidence`] judges. Without measurements the axiom holds of everything.
    Measures,
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
    /// `boundary`
    Boundary,
    /// `distance`
    Distance,
    /// `angle`
    Angle,
    /// `closure`
    Closure,
    /// `apart`
    Apart,
}

/// A choice of axioms with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Profile {
    /// The axioms of the seed.
    Paper,
    /// With planarity, and the metrical axioms where the trace has measurements.
    Default,
}

/// The profiles whose traces are of stars.
pub(super) const STAR_PROFILES: &[Profile] = &[Profile::Paper, Profile::Default];

impl Axiom {
    /// Whether the axiom holds of a child, given what was measured.
    pub fn holds(&self, proposal: &Proposal<'_>, evidence: Option<&dyn Evidence>) -> bool {
        match (self.check, evidence) {
            (Check::Symbols { holds, .. }, _) => holds(proposal),
            (Check::Measures, Some(evidence)) => evidence.holds(self.id, proposal),
            (Check::Measures, None) => true,
        }
    }

    /// Why the axiom does not hold of a child, given what was measured; asked for only where it does not.
    pub fn clash(&self, proposal: &Proposal<'_>, evidence: Option<&dyn Evidence>) -> Clash {
        match (self.check, evidence) {
            (Check::Symbols { clash, .. }, _) => clash(proposal),
            (Check::Measures, Some(evidence)) => evidence.clash(self.id, proposal),
            // Unreached: without measurements it holds.
            (Check::Measures, None) => Clash { words: self.statement.into(), ..Clash::default() },
        }
    }

    /// Whether the axiom speaks of measurements.
    pub fn is_measured(&self) -> bool {
        matches!(self.check, Check::Measures)
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
