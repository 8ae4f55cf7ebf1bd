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
    soft_boundary: bool,
}

/// How the axiom `boundary` is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Boundary {
    /// As a default, as in the theory: the fewer exceptions a map needs, the better it explains.
    Soft,
    /// As a law: a map that needs an exception is refuted.
    Hard,
}

/// Why a set of axioms was refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum AxiomError {
    /// No axiom has the name.
    #[error("there is no axiom `{0}`, expected some of {names}", names = names())]
    Unknown(String),
    /// An axiom held in two ways.
    #[error("boundary is held soft and hard, expected one of the two")]
    TwoBoundaries,
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
        fixed.fold(AxiomSet::none(), |set, axiom| set.with(axiom.id))
    }

    /// This set and one axiom more.
    #[must_use]
    pub fn with(self, id: AxiomId) -> AxiomSet {
        let soft_boundary = self.soft_boundary && id != AxiomId::Boundary;
        AxiomSet { members: self.members | bit(id), soft_boundary }
    }

    /// This set with boundaries held in a way; without them, if in none.
    #[must_use]
    pub fn with_boundary(self, boundary: Option<Boundary>) -> AxiomSet {
        let members = self.members & !bit(AxiomId::Boundary);
        let hard = if boundary == Some(Boundary::Hard) { bit(AxiomId::Boundary) } else { 0 };
        AxiomSet { members: members | hard, soft_boundary: boundary == Some(Boundary::Soft) }
    }

    /// This set without an axiom, which must be switchable.
    pub fn without(self, id: AxiomId) -> Result<AxiomSet, AxiomError> {
        match id.axiom().switchable {
            true => Ok(AxiomSet { members: self.members & !bit(id), ..self }),
            false => Err(AxiomError::BuiltIn(id)),
        }
    }

    /// This set without the axioms that speak of measurements.
    #[must_use]
    pub fn without_measured(self) -> AxiomSet {
        let measured = REGISTRY.iter().filter(|axiom| axiom.is_measured());
        let members = measured.fold(self.members, |members, axiom| members & !bit(axiom.id));
        AxiomSet { members, ..self }
    }

    /// How the set holds boundaries, if it does.
    pub fn boundary(self) -> Option<Boundary> {
        match (self.contains(AxiomId::Boundary), self.soft_boundary) {
            (true, _) => Some(Boundary::Hard),
            (false, true) => Some(Boundary::Soft),
            (false, false) => None,
        }
    }

    /// Whether the set holds an axiom, so that it refutes; a boundary held soft does not.
    pub fn contains(self, id: AxiomId) -> bool {
        self.members & bit(id) != 0
    }

    /// The axioms that refute, in the order of the registry.
    pub fn iter(self) -> impl Iterator<Item = &'static Axiom> {
        REGISTRY.iter().filter(move |axiom| self.contains(axiom.id))
    }

    /// The names of all that the set holds, such as parse to it again.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        let soft = self.soft_boundary.then_some(SOFT_BOUNDARY);
        self.iter().map(|axiom| axiom.name).chain(soft)
    }

    fn none() -> AxiomSet {
        AxiomSet { members: 0, soft_boundary: false }
    }
}

impl FromStr for AxiomSet {
    type Err = AxiomError;

    /// Names separated by commas: exactly the axioms of the set, those that cannot be left out among them.
    /// `boundary=soft` and `boundary=hard`, or `boundary` for short, say how boundaries are held.
    fn from_str(names: &str) -> Result<Self, Self::Err> {
        let mut set = AxiomSet::none();
        let mut soft = false;
        for name in names.split(',').map(str::trim) {
            let axiom = REGISTRY.iter().find(|axiom| axiom.name == name);
            match (name, axiom) {
                (SOFT_BOUNDARY, _) => soft = true,
                ("boundary=hard", _) => set = set.with(AxiomId::Boundary),
                (_, Some(axiom)) => set = set.with(axiom.id),
                (_, None) => return Err(AxiomError::Unknown(name.into())),
            }
        }
        match (soft, set.boundary()) {
            (true, Some(_)) => return Err(AxiomError::TwoBoundaries),
            (true, None) => set = set.with_boundary(Some(Boundary::Soft)),
            (false, _) => (),
        }
        let missing = REGISTRY.iter().find(|axiom| !axiom.switchable && !set.contains(axiom.id));
        missing.map_or(Ok(set), |axiom| Err(AxiomError::BuiltIn(axiom.id)))
    }
}

fn bit(id: AxiomId) -> u32 {
    1 << id as u32
}

const SOFT_BOUNDARY: &str = "boundary=soft";

fn names() -> String {
    let names: Vec<&str> = REGISTRY.iter().map(|axiom| axiom.name).chain([SOFT_BOUNDARY]).collect();
    names.join(", ")
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
             planarity, boundary, distance, angle, closure, apart, boundary=soft"
        );
        assert_eq!(default.without(AxiomId::Determinism), Err(AxiomError::BuiltIn(AxiomId::Determinism)));
    }

    #[test]
    fn boundaries_are_held_in_one_way() {
        let parse = |how: &str| format!("determinism,star-match,{how}").parse::<AxiomSet>();
        let held = |how| AxiomSet::built_in().with_boundary(how);
        assert_eq!(parse("boundary"), Ok(held(Some(Boundary::Hard))));
        assert_eq!(parse("boundary=hard"), Ok(held(Some(Boundary::Hard))));
        assert_eq!(parse("boundary=soft"), Ok(held(Some(Boundary::Soft))));
        assert_eq!(parse("boundary,boundary=soft"), Err(AxiomError::TwoBoundaries));
        assert_eq!(parse("boundary=firm"), Err(AxiomError::Unknown("boundary=firm".into())));
        for how in [None, Some(Boundary::Soft), Some(Boundary::Hard)] {
            let set = AxiomSet::of(Profile::Default).with_boundary(how);
            assert_eq!(set.boundary(), how);
            assert_eq!(set.names().collect::<Vec<_>>().join(",").parse(), Ok(set));
            assert_eq!(set.with_boundary(None), AxiomSet::of(Profile::Default));
        }
        assert_eq!(held(Some(Boundary::Soft)).with(AxiomId::Boundary), held(Some(Boundary::Hard)));
    }
}
