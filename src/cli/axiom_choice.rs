//! Which axioms a user asks for: options of several verbs.

use crate::abduction::{AxiomSet, Boundary, Profile};
use clap::{Args, ValueEnum};

/// Which axioms are held.
#[derive(Debug, Args)]
pub(super) struct AxiomChoice {
    /// A choice of axioms; `default` unless the trace is one of views, then `classic`.
    #[arg(long, value_enum)]
    profile: Option<ProfileName>,
    /// Hold boundaries too: a path divides what is right of it from what is left.
    #[arg(long, value_enum)]
    boundary: Option<BoundaryName>,
    /// Exactly these axioms in place of a profile, names with commas between.
    #[arg(long, conflicts_with_all = ["profile", "boundary"])]
    axioms: Option<AxiomSet>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ProfileName {
    /// The axioms of Beeson et al. 2003.
    Paper,
    /// With planarity.
    Default,
    /// The original SSH, for traces of views.
    Classic,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum BoundaryName {
    /// Maps with fewer exceptions are preferred to others.
    Soft,
    /// Maps with an exception are refuted.
    Hard,
}

impl AxiomChoice {
    /// Whether the profile for traces of views is named.
    pub(super) fn is_classic(&self) -> bool {
        self.profile == Some(ProfileName::Classic)
    }

    /// The axioms for a trace of stars or grids, or what does not go with one.
    pub(super) fn for_stars(&self) -> Result<AxiomSet, &'static str> {
        let profile = match self.profile {
            None | Some(ProfileName::Default) => Profile::Default,
            Some(ProfileName::Paper) => Profile::Paper,
            Some(ProfileName::Classic) => {
                return Err("is no trace of views, and profile classic explains nothing else");
            }
        };
        let boundary = self.boundary.map(|name| match name {
            BoundaryName::Soft => Boundary::Soft,
            BoundaryName::Hard => Boundary::Hard,
        });
        Ok(self.axioms.unwrap_or_else(|| AxiomSet::of(profile).with_boundary(boundary)))
    }

    /// Nothing, as a trace of views has its own axioms, or what does not go with one.
    pub(super) fn for_views(&self) -> Result<(), &'static str> {
        match self.profile {
            _ if self.axioms.is_some() || self.boundary.is_some() => {
                Err("is a trace of views, which holds the axioms of profile classic")
            }
            None | Some(ProfileName::Classic) => Ok(()),
            Some(_) => Err("is a trace of views, which profile classic alone explains"),
        }
    }
}
