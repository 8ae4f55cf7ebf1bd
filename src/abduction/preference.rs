//! Which map explains best.

use crate::map::TopologicalMap;

/// How simple a map is: less is simpler. First the paths, travelled or not, then the places; all else varies.
/// This counts what the prioritised circumscription of the seed, section 3.2, and of Remolina and Kuipers, IJCAI-01,
/// minimises by inclusion, so its minima are among theirs.
///
/// Not monotone: an observation may take one path away as it joins two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Simplicity {
    /// The number of paths.
    pub paths: usize,
    /// The number of places.
    pub places: usize,
}

impl Simplicity {
    /// How simple a map is.
    pub fn of(map: &TopologicalMap) -> Self {
        Simplicity { paths: map.path_count(), places: map.place_count() }
    }
}
