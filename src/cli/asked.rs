//! What an operator asks and says on the command line of two observations.

use crate::trace::Assert;
use std::str::FromStr;

/// What is to be explained.
#[derive(Clone, Copy, Debug)]
pub(super) enum Asked {
    /// The preferred map.
    All,
    /// Two observations.
    Visits([usize; 2]),
}

impl FromStr for Asked {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text.is_empty() {
            return Ok(Asked::All);
        }
        let pair = text.split_once(',').and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
        pair.map(Asked::Visits).ok_or_else(|| "expected two observations, counted from 0, as 0,8".into())
    }
}

/// An operator's word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said(pub(super) Assert);

impl FromStr for Said {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (pair, same) = match text.split_once("!=") {
            Some(pair) => (Some(pair), false),
            None => (text.split_once('='), true),
        };
        let visits = pair.and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
        let said = visits.map(|visits| Said(Assert { visits, same }));
        said.ok_or_else(|| "expected two observations, counted from 0, as 0=8 or 3!=5".into())
    }
}
