//! Symmetric sparse systems of small dense blocks, factorised by faer's Cholesky.
//!
//! One thread, always: the sums of a factorisation in parallel depend on how it was cut, and the same graph is to give
//! the same bytes everywhere.

use crate::patchwork::pose_graph::RelaxError;
use crate::patchwork::pose_graph::structure::Structure;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side, Spec};
use std::fmt;

/// A symmetric matrix of blocks of `B` by `B` over nodes in the order of elimination, and its factor.
pub(super) struct System<const B: usize> {
    /// The upper triangle.
    matrix: SparseColMat<u32, f64>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    memory: MemBuffer,
    /// Where in the values each block column begins, and how many blocks it has above the diagonal.
    columns: Vec<[u32; 2]>,
    /// Where in the values each block of the structure begins.
    blocks: Vec<u32>,
    /// The column of each block of the structure.
    column_of: Vec<u32>,
    /// How often it was factorised, by the one analysis that it was made with.
    factorizations: usize,
}

/// The matrix is not positive definite to working precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NotPositive;

impl<const B: usize> System<B> {
    /// The system of a structure, its symbolic analysis done, all entries zero.
    pub(super) fn new(structure: &Structure) -> Result<Self, RelaxError> {
        let nodes = structure.nodes();
        let entries = (structure.rows.len() * B * B).checked_add(nodes * B * (B + 1) / 2);
        let entries = entries.filter(|n| u32::try_from(*n).is_ok()).ok_or(RelaxError::Memory)?;
        let (mut starts, mut rows) = (Vec::with_capacity(nodes * B + 1), Vec::with_capacity(entries));
        let mut columns = Vec::with_capacity(nodes);
        let (mut blocks, mut column_of) = (Vec::new(), Vec::new());
        starts.push(0_u32);
        for node in 0..nodes {
            let above = &structure.rows[structure.starts[node] as usize..structure.starts[node + 1] as usize];
            columns.push([rows.len() as u32, above.len() as u32]);
            blocks.extend((0..above.len()).map(|k| (rows.len() + B * k) as u32));
            column_of.extend(above.iter().map(|_| node as u32));
            for column in 0..B {
                rows.extend(above.iter().flat_map(|row| (0..B as u32).map(move |r| row * B as u32 + r)));
                rows.extend((0..=column).map(|r| (node * B + r) as u32));
                starts.push(rows.len() as u32);
            }
        }
        let pattern = SymbolicSparseColMat::new_checked(nodes * B, nodes * B, starts, None, rows);
        let params = CholeskySymbolicParams {
            supernodal_params: SymbolicSupernodalParams::default(),
            ..CholeskySymbolicParams::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(pattern.as_ref(), Side::Upper, SymmetricOrdering::Identity, params)
                .map_err(|_| RelaxError::Memory)?;
        let scratch =
            symbolic
                .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
                .or(symbolic.solve_in_place_scratch::<f64>(B, Par::Seq));
        let memory = MemBuffer::try_new(scratch).map_err(|_| RelaxError::Memory)?;
        let factor = vec![0.0; symbolic.len_val()];
        let matrix = SparseColMat::new(pattern, vec![0.0; entries]);
        Ok(System { matrix, symbolic, factor, memory, columns, blocks, column_of, factorizations: 0 })
    }

    /// Puts zeros everywhere.
    pub(super) fn clear(&mut self) {
        self.matrix.val_mut().fill(0.0);
    }

    /// Adds to the block at a place of the structure: `block[r][c]` is of row `r` of the node eliminated first and column
    /// `c` of the other.
    pub(super) fn add_block(&mut self, place: u32, block: &[[f64; B]; B]) {
        let above = self.columns[self.column_of[place as usize] as usize][1] as usize;
        let first = self.blocks[place as usize] as usize;
        let values = self.matrix.val_mut();
        for c in 0..B {
            let at = first + c * B * above + c * (c + 1) / 2;
            for (r, row) in block.iter().enumerate() {
                values[at + r] += row[c];
            }
        }
    }

    /// Adds to the block of a node on the diagonal, of which the upper triangle is read.
    pub(super) fn add_diagonal(&mut self, node: u32, block: &[[f64; B]; B]) {
        for c in 0..B {
            let at = self.diagonal(node, c) - c;
            let values = self.matrix.val_mut();
            for (r, row) in block.iter().take(c + 1).enumerate() {
                values[at + r] += row[c];
            }
        }
    }

    /// The entries on the diagonal, unknown by unknown.
    pub(super) fn diagonals(&self) -> Vec<f64> {
        let unknowns = (0..self.columns.len() as u32).flat_map(|node| (0..B).map(move |c| (node, c)));
        unknowns.map(|(node, c)| self.matrix.val()[self.diagonal(node, c)]).collect()
    }

    /// Puts entries on the diagonal, unknown by unknown.
    pub(super) fn set_diagonals(&mut self, entries: impl Iterator<Item = f64>) {
        for (unknown, entry) in entries.enumerate() {
            let at = self.diagonal((unknown / B) as u32, unknown % B);
            self.matrix.val_mut()[at] = entry;
        }
    }

    fn diagonal(&self, node: u32, c: usize) -> usize {
        let [first, above] = self.columns[node as usize];
        first as usize + (c + 1) * B * above as usize + c * (c + 1) / 2 + c
    }

    /// How often the matrix was factorised by the symbolic analysis done when the system was made.
    pub(super) fn factorizations(&self) -> usize {
        self.factorizations
    }

    /// Factorises the matrix as it is now.
    pub(super) fn factorize(&mut self) -> Result<(), NotPositive> {
        self.factorizations += 1;
        let matrix = self.matrix.as_ref();
        let done = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            matrix,
            Side::Upper,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Spec::default(),
        );
        done.map(|_| ()).map_err(|_| NotPositive)
    }

    /// Solves for up to `B` right-hand sides, one after the other, by the last factor.
    pub(super) fn solve(&mut self, sides: &mut [f64]) {
        let unknowns = self.columns.len() * B;
        if unknowns == 0 {
            return;
        }
        let count = sides.len() / unknowns;
        let sides = MatMut::from_column_major_slice_mut(&mut sides[..count * unknowns], unknowns, count);
        let factor = LltRef::<u32, f64>::new(&self.symbolic, &self.factor);
        factor.solve_in_place_with_conj(Conj::No, sides, Par::Seq, MemStack::new(&mut self.memory));
    }

    /// The squares of the factor's diagonal: what is left of each entry of the diagonal when its turn comes.
    pub(super) fn pivots(&self) -> Vec<f64> {
        let square = |at: usize| self.factor[at] * self.factor[at];
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(factor) => {
                factor.col_ptr()[..factor.ncols()].iter().map(|at| square(*at as usize)).collect()
            }
            SymbolicCholeskyRaw::Supernodal(factor) => {
                let bounds = factor.supernode_begin().iter().zip(factor.supernode_end());
                let parts = bounds.zip(factor.col_ptr_for_val()).enumerate();
                parts
                    .flat_map(|(s, ((begin, end), first))| {
                        let columns = (end - begin) as usize;
                        let below = factor.nnz_per_super()[s] as usize;
                        let first = *first as usize;
                        (0..columns).map(move |j| first + j * (columns + below) + j)
                    })
                    .map(square)
                    .collect()
            }
        }
    }
}

impl<const B: usize> fmt::Debug for System<B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("System").field("nodes", &self.columns.len()).finish_non_exhaustive()
    }
}
