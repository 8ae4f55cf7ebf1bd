//! The name of a map in URLs.

use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// One to 64 letters, digits, dots, underscores and hyphens.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MapName(String);

/// A name that is not one.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{0}` is not the name of a map, expected 1 to 64 characters of A-Z a-z 0-9 . _ -")]
pub struct MapNameError(String);

/// The most characters of a name.
const MAX_CHARACTERS: usize = 64;

impl FromStr for MapName {
    type Err = MapNameError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let allowed = |b: u8| b.is_ascii_alphanumeric() || b"._-".contains(&b);
        // A path of `.` or `..` is taken away by clients before it is sent, and must not name a file later.
        let dots = name == "." || name == "..";
        if (1..=MAX_CHARACTERS).contains(&name.len()) && name.bytes().all(allowed) && !dots {
            return Ok(MapName(name.to_owned()));
        }
        Err(MapNameError(name.chars().take(MAX_CHARACTERS + 1).collect()))
    }
}

impl MapName {
    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for MapName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_and_plain() {
        let longest = "x".repeat(64);
        for name in ["a", "Office_2.floor-1", longest.as_str()] {
            assert!(name.parse::<MapName>().is_ok(), "{name}");
        }
        let too_long = "x".repeat(65);
        for name in ["", ".", "..", "a/b", "a b", "ä", too_long.as_str()] {
            assert!(name.parse::<MapName>().is_err(), "{name}");
        }
    }
}
