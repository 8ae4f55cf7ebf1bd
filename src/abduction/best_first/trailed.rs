//! Memory that can be taken back.

/// Cells whose changes are logged, so that all changes since a mark can be undone at their own cost.
#[derive(Clone, Debug)]
pub(super) struct Trailed<T> {
    cells: Vec<T>,
    log: Vec<(u32, T)>,
}

impl<T: Copy + PartialEq> Trailed<T> {
    /// One more cell, which is there for good.
    pub(super) fn push(&mut self, value: T) {
        self.cells.push(value);
    }

    /// What is, is for good.
    pub(super) fn commit(&mut self) {
        self.log = Vec::new();
    }

    /// Bytes of the cells, and of what it takes to undo.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice()) + size_of_val(self.log.as_slice())
    }

    pub(super) fn get(&self, index: usize) -> T {
        self.cells[index]
    }

    pub(super) fn set(&mut self, index: usize, value: T) {
        let cell = &mut self.cells[index];
        if *cell != value {
            self.log.push((index as u32, *cell));
            *cell = value;
        }
    }

    /// The present state, for [`Trailed::undo`].
    pub(super) fn mark(&self) -> usize {
        self.log.len()
    }

    /// Back to the state at a mark.
    pub(super) fn undo(&mut self, mark: usize) {
        for (index, value) in self.log.drain(mark..).rev() {
            self.cells[index as usize] = value;
        }
    }
}

impl<T> Default for Trailed<T> {
    fn default() -> Self {
        Trailed { cells: Vec::new(), log: Vec::new() }
    }
}
