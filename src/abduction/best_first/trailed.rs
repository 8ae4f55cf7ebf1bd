//! Memory that can be taken back.

/// Cells whose changes are logged, so that all changes since a mark can be undone at their own cost.
#[derive(Clone, Debug)]
pub(super) struct Trailed<T> {
    cells: Vec<T>,
    log: Vec<(u32, T)>,
}

impl<T: Copy + PartialEq> Trailed<T> {
    pub(super) fn new(cells: Vec<T>) -> Self {
        Trailed { cells, log: Vec::new() }
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
