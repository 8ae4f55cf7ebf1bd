//! Pose graphs as files: g2o and TORO in and out, TUM trajectories out.
//!
//! Both are lines of words. g2o (Kümmerle, Grisetti, Strasdat, Konolige and Burgard 2011) writes `VERTEX_SE2 id x y theta`,
//! `EDGE_SE2 i j x y theta` with the upper triangle of the information row by row (11 12 13 22 23 33), and `FIX id`. TORO
//! (Grisetti, Stachniss and Burgard 2009) writes `VERTEX2`, `EDGE2` and the information as 11 12 22 33 13 23; it has no
//! word for poses held, so that `FIX` is read with the tags of either and written in g2o alone. No file says which order it
//! has, and some have the other one: see [`InformationOrder`].

mod line;
mod read;
mod write;

pub use read::{FormatError, ReadGraph, read_graph};
pub use write::{write_g2o, write_toro, write_trajectory, write_tum};

/// The order of the six numbers of an information matrix on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InformationOrder {
    /// 11 12 13 22 23 33, row by row.
    G2o,
    /// 11 12 22 33 13 23.
    Toro,
}

impl InformationOrder {
    /// The name, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            InformationOrder::G2o => "g2o",
            InformationOrder::Toro => "toro",
        }
    }

    fn other(self) -> InformationOrder {
        match self {
            InformationOrder::G2o => InformationOrder::Toro,
            InformationOrder::Toro => InformationOrder::G2o,
        }
    }

    /// Where the six numbers stand in the matrix: row and column of each.
    fn places(self) -> [(usize, usize); 6] {
        match self {
            InformationOrder::G2o => [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)],
            InformationOrder::Toro => [(0, 0), (0, 1), (1, 1), (2, 2), (0, 2), (1, 2)],
        }
    }
}

#[cfg(test)]
mod tests;
