//! Stars told apart by number, so that maps that share stars share their storage.

use crate::star::LargeScaleStar;
use std::sync::Arc;

/// The distinct stars of a map and its kin. A table only grows at its end, so that a number keeps its meaning in
/// every later version of the table.
#[derive(Clone, Debug, Default)]
pub(crate) struct StarTable {
    stars: Vec<Arc<LargeScaleStar>>,
}

/// The number of a star in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StarId(u16);

/// A star with the table that knows it.
#[derive(Clone, Debug)]
pub(crate) struct InternedStar {
    pub(crate) table: Arc<StarTable>,
    pub(crate) id: StarId,
}

impl StarTable {
    /// The star's number, in this table if it knows the star, otherwise in a table that extends this one.
    /// None if the table is full.
    pub(crate) fn intern(self: &Arc<Self>, star: &LargeScaleStar) -> Option<InternedStar> {
        let known = self.stars.iter().position(|own| **own == *star);
        let id = StarId(u16::try_from(known.unwrap_or(self.stars.len())).ok()?);
        let mut table = Arc::clone(self);
        if known.is_none() {
            Arc::make_mut(&mut table).stars.push(Arc::new(star.clone()));
        }
        Some(InternedStar { table, id })
    }

    /// The star with a number given out by this table or one it extends.
    pub(crate) fn star(&self, id: StarId) -> &LargeScaleStar {
        &self.stars[id.0 as usize]
    }

    /// All stars, by number.
    pub(crate) fn stars(&self) -> impl Iterator<Item = &LargeScaleStar> {
        self.stars.iter().map(Arc::as_ref)
    }
}

impl InternedStar {
    /// The star.
    pub(crate) fn star(&self) -> &LargeScaleStar {
        self.table.star(self.id)
    }
}

impl StarId {
    /// The number.
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}
