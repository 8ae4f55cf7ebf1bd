//! Which unknowns meet in the normal equations, and in which order they are eliminated.
//!
//! Ordering and structure speak of poses, not of their coordinates: a graph of a third of the size, found and ordered
//! once for every system over the same poses, of one, two or three unknowns each.

use crate::patchwork::pose_graph::RelaxError;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// The place of something that is not among the unknowns.
pub(super) const NOWHERE: u32 = u32::MAX;

/// The upper triangle of a symmetric matrix of blocks, column by column, with nodes in the order of elimination.
#[derive(Clone, Debug)]
pub(super) struct Structure {
    /// Where the rows of each column begin, and after the last their number.
    pub(super) starts: Vec<u32>,
    /// The rows above the diagonal, ascending in each column.
    pub(super) rows: Vec<u32>,
    /// The place in `rows` of each pair given, [`NOWHERE`] for one that is no pair of nodes.
    pub(super) places: Vec<u32>,
}

impl Structure {
    /// The structure over so many nodes, of which some pairs meet; a pair with [`NOWHERE`] in it is none.
    /// Linear in nodes and pairs.
    pub(super) fn new(nodes: usize, pairs: &[[u32; 2]]) -> Structure {
        let is_pair = |pair: &[u32; 2]| pair[0] != NOWHERE && pair[1] != NOWHERE && pair[0] != pair[1];
        let mut starts = vec![0_u32; nodes + 1];
        // Sorted by rows first and then, keeping that order, by columns: each column's rows come out ascending.
        let mut by_row: Vec<u32> = (0..pairs.len() as u32).filter(|k| is_pair(&pairs[*k as usize])).collect();
        by_row = counting_sort(&by_row, nodes, |k| pairs[k as usize][0].min(pairs[k as usize][1]));
        let by_column = counting_sort(&by_row, nodes, |k| pairs[k as usize][0].max(pairs[k as usize][1]));
        let mut rows: Vec<u32> = Vec::with_capacity(by_column.len());
        let mut places = vec![NOWHERE; pairs.len()];
        let mut last = [NOWHERE; 2];
        for k in by_column {
            let [a, b] = pairs[k as usize];
            let (row, column) = (a.min(b), a.max(b));
            if last != [row, column] {
                rows.push(row);
                starts[column as usize + 1] += 1;
                last = [row, column];
            }
            places[k as usize] = rows.len() as u32 - 1;
        }
        for node in 0..nodes {
            starts[node + 1] += starts[node];
        }
        Structure { starts, rows, places }
    }

    /// How many nodes there are.
    pub(super) fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// The position of each node in an order of elimination that leaves little fill (approximate minimum degree,
    /// Amestoy, Davis and Duff 1996).
    pub(super) fn elimination_order(&self) -> Result<Vec<u32>, RelaxError> {
        let nodes = self.nodes();
        let (mut order, mut position) = (vec![0_u32; nodes], vec![0_u32; nodes]);
        let pattern = SymbolicSparseColMatRef::new_checked(nodes, nodes, &self.starts, None, &self.rows);
        let scratch = amd::order_scratch::<u32>(nodes, self.rows.len());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| RelaxError::Memory)?;
        let stack = MemStack::new(&mut memory);
        amd::order(&mut order, &mut position, pattern, amd::Control::default(), stack)
            .map_err(|_| RelaxError::Memory)?;
        Ok(position)
    }
}

fn counting_sort(items: &[u32], keys: usize, key: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut starts = vec![0_u32; keys + 1];
    for &item in items {
        starts[key(item) as usize + 1] += 1;
    }
    for k in 0..keys {
        starts[k + 1] += starts[k];
    }
    let mut sorted = vec![0; items.len()];
    for &item in items {
        let at = &mut starts[key(item) as usize];
        sorted[*at as usize] = item;
        *at += 1;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_hold_each_pair_once_in_ascending_rows() {
        let pairs = [[3, 0], [1, 3], [0, 3], [2, 2], [0, NOWHERE], [1, 0]];
        let structure = Structure::new(4, &pairs);
        assert_eq!(structure.starts, [0, 0, 1, 1, 3]);
        assert_eq!(structure.rows, [0, 0, 1]);
        assert_eq!(structure.places, [1, 2, 1, NOWHERE, NOWHERE, 0]);
    }

    #[test]
    fn the_hub_of_a_star_is_eliminated_late() {
        let spokes: Vec<[u32; 2]> = (1..50).map(|k| [0, k]).collect();
        let position = Structure::new(50, &spokes).elimination_order().unwrap();
        assert!(position[0] >= 48, "{position:?}");
        let mut sorted = position;
        sorted.sort_unstable();
        assert_eq!(sorted, (0..50).collect::<Vec<u32>>());
    }
}
