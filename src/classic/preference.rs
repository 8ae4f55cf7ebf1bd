//! Which map explains best.

/// How simple a map is: less is simpler. First the paths, travelled or not, then the places; all else varies. This
/// counts what the prioritised circumscription of the seed, section 3.2, minimises by inclusion, so its minima are
/// among theirs. Not monotone: an action may make two paths one, or two places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Simplicity {
    /// The number of paths.
    pub paths: usize,
    /// The number of places.
    pub places: usize,
}
