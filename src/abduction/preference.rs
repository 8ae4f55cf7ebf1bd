//! Which map explains best.

use crate::abduction::{AxiomSet, Boundary};
use crate::map::{Regions, TopologicalMap};

/// How simple a map is: less is simpler. First the abnormal pairs of paths, if the axiom `boundary` is held soft,
/// then the paths, travelled or not, then the places; all else varies. This counts what the prioritised
/// circumscription of the seed, section 3.2, and of Remolina and Kuipers, IJCAI-01, minimises by inclusion, so its
/// minima are among theirs.
///
/// Not monotone: an observation may take one path away as it joins two, and abnormalities with it. But a map that
/// has an abnormality has one in all its extensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Simplicity {
    /// The fewest abnormalities that leave its boundaries without conflict; none if that is not asked for.
    pub abnormalities: Option<usize>,
    /// The number of paths.
    pub paths: usize,
    /// The number of places.
    pub places: usize,
}

impl Simplicity {
    /// How simple a map is under these axioms.
    pub fn of(map: &TopologicalMap, axioms: AxiomSet) -> Self {
        let soft = axioms.boundary() == Some(Boundary::Soft);
        let abnormalities = soft.then(|| Regions::fewest_abnormalities(map));
        Simplicity { abnormalities, paths: map.path_count(), places: map.place_count() }
    }
}
