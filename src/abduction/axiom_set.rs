//! Which axioms a search holds.

use crate::abduction::{Axiom, AxiomId, Profile, REGISTRY};
use std::str::FromStr;
use thiserror::Error;

/// A set of axioms that holds all those that are not switchable.
///
/// `determinism` and `star-match` cannot be left out: a map is built from far ends, of which a gateway has one, and
/// a candidate from the rotations that lay stars onto each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AxiomSet {
    members: u32, // bit by position in the registry
}

/// Why a set of axioms was refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum AxiomError {
    /// No axiom has the name.
    #[error("there is no axiom `{0}`, expected some of {names}", names = names())]
    Unknown(String),
    /// An axiom that cannot be left out is not in the list, or was to be taken out.
    #[error("axiom `{name}` cannot be left out", name = .0.name())]
    BuiltIn(AxiomId),
}

impl AxiomSet {
    /// The axioms of a profile.
    pub fn of(profile: Profile) -> AxiomSet {
        let held = REGISTRY.iter().filter(|axiom| axiom.profiles.contains(&profile));
        held.fold(AxiomSet::built_in(), |set, axiom| set.with(axiom.id))
    }

    /// The axioms that cannot be left out.
    pub fn built_in() -> AxiomSet {
        let fixed = REGISTRY.iter().filter(|axiom| !axiom.switchable);
        fixed.fold(AxiomSet { members: 0 }, |set, axiom| set.with(axiom.id))
    }

    /// This set and one axiom more.
    #[must_use]
    pub fn with(self, id: AxiomId) -> AxiomSet {
        AxiomSet { members: self.members | bit(id) }
    }

    /// This set without an axiom, which must be switchable.
    pub fn without(self, id: AxiomId) -> Result<AxiomSet, AxiomError> {
        match id.axiom().switchable {
            true => Ok(AxiomSet { members: self.members & !bit(id) }),
            false => Err(AxiomError::BuiltIn(id)),
        }
    }

    /// This set without the axioms that speak of measurements.
    #[must_use]
    pub fn without_measured(self) -> AxiomSet {
        let measured = REGISTRY.iter().filter(|axiom| axiom.is_measured());
        AxiomSet { members: measured.fold(self.members, |members, axiom| members & !bit(axiom.id)) }
    }

    /// Whether the set holds an axiom.
    pub fn contains(self, id: AxiomId) -> bool {
        self.members & bit(id) != 0
    }

    /// The axioms of the set, in the order of the registry.
    pub fn iter(self) -> impl Iterator<Item = &'static Axiom> {
        REGISTRY.iter().filter(move |axiom| self.contains(axiom.id))
    }
}

impl FromStr for AxiomSet {
    type Err = AxiomError;

    /// Names separated by commas: exactly the axioms of the set, those that cannot be left out among them.
    fn from_str(names: &str) -> Result<Self, Self::Err> {
        let mut set = AxiomSet { members: 0 };
        for name in names.split(',').map(str::trim) {
            let axiom = REGISTRY.iter().find(|axiom| axiom.name == name);
            set = set.with(axiom.ok_or_else(|| AxiomError::Unknown(name.into()))?.id);
        }
        let missing = REGISTRY.iter().find(|axiom| !axiom.switchable && !set.contains(axiom.id));
        missing.map_or(Ok(set), |axiom| Err(AxiomError::BuiltIn(axiom.id)))
    }
}

fn bit(id: AxiomId) -> u32 {
    1 << id as u32
}

fn names() -> String {
    REGISTRY.each_ref().map(|axiom| axiom.name).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_registry_is_in_the_order_of_the_ids() {
        assert!(REGISTRY.iter().enumerate().all(|(position, axiom)| axiom.id as usize == position));
    }

    #[test]
    fn names_make_sets() {
        let paper = "determinism, star-match,travel-moves,path-order".parse();
        assert_eq!(paper, Ok(AxiomSet::of(Profile::Paper)));
        let default = AxiomSet::of(Profile::Default);
        assert_eq!(AxiomSet::of(Profile::Paper).with(AxiomId::Planarity), default.without_measured());
        assert_eq!("determinism".parse::<AxiomSet>(), Err(AxiomError::BuiltIn(AxiomId::StarMatch)));
        assert_eq!(
            "neatness".parse::<AxiomSet>().unwrap_err().to_string(),
            "there is no axiom `neatness`, expected some of determinism, star-match, travel-moves, path-order, \
             planarity, distance, angle, closure, apart"
        );
        assert_eq!(default.without(AxiomId::Determinism), Err(AxiomError::BuiltIn(AxiomId::Determinism)));
    }
}
