//! One bit a cell: what holds of whole rows is found sixty-four cells at a time.

use crate::grid::Cell;
use std::ops::Range;

/// The cells of a grid of which something holds, row by row; every row begins a word of its own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    words: Vec<u64>,
    width: usize,
    stride: usize,
}

/// The lowest bits of eight bytes, the lowest byte first, side by side.
pub(super) fn gathered(bytes: u64) -> u64 {
    (bytes & 0x0101_0101_0101_0101).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

impl Plane {
    /// The cells of one kind. Linear in the cells.
    pub(super) fn of(cells: &[Cell], width: usize, kind: Cell) -> Self {
        let stride = width.div_ceil(64);
        let mut words = Vec::with_capacity(stride * (cells.len() / width));
        for row in cells.chunks_exact(width) {
            words.extend(row.chunks(64).map(|cells| packed(cells, &|&cell| cell == kind)));
        }
        Plane { words, width, stride }
    }

    /// No cells of a grid of so many columns and rows.
    pub(super) fn empty(width: usize, height: usize) -> Self {
        let stride = width.div_ceil(64);
        Plane { words: vec![0; stride * height], width, stride }
    }

    /// Adds the cells of a stretch of a row whose values are as wanted.
    pub(super) fn insert_where<T>(&mut self, first: usize, values: &[T], wanted: impl Fn(&T) -> bool) {
        let (word, bit) =
            (first / self.width * self.stride + first % self.width / 64, first % self.width % 64);
        let (begun, rest) = values.split_at(values.len().min(64 - bit));
        self.words[word] |= packed(begun, &wanted) << bit;
        for (word, values) in self.words[word + 1..].iter_mut().zip(rest.chunks(64)) {
            *word |= packed(values, &wanted);
        }
    }

    /// Adds a stretch of a row.
    pub(super) fn insert_run(&mut self, cells: Range<usize>) {
        let row = cells.start / self.width;
        let (mut x, end) = (cells.start - row * self.width, cells.end - row * self.width);
        while x < end {
            let count = (end - x).min(64 - x % 64);
            self.words[row * self.stride + x / 64] |= u64::MAX >> (64 - count) << (x % 64);
            x += count;
        }
    }

    pub(super) fn contains(&self, cell: usize) -> bool {
        let (word, bit) = self.place(cell);
        self.words[word] & bit != 0
    }

    pub(super) fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Cells of a row.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// The cells that are not in the plane.
    pub(super) fn complement(&self) -> Self {
        let last = u64::MAX >> (self.stride * 64 - self.width);
        let flip =
            |(k, word): (usize, &u64)| !word & if (k + 1) % self.stride == 0 { last } else { u64::MAX };
        Plane { words: self.words.iter().enumerate().map(flip).collect(), ..*self }
    }

    pub(super) fn insert(&mut self, cell: usize) {
        let (word, bit) = self.place(cell);
        self.words[word] |= bit;
    }

    pub(super) fn remove(&mut self, cell: usize) {
        let (word, bit) = self.place(cell);
        self.words[word] &= !bit;
    }

    fn place(&self, cell: usize) -> (usize, u64) {
        let (x, y) = (cell % self.width, cell / self.width);
        (y * self.stride + x / 64, 1 << (x % 64))
    }

    fn rows(&self) -> std::slice::ChunksExact<'_, u64> {
        self.words.chunks_exact(self.stride)
    }

    /// The cells of this plane whose right neighbour is in the other, ascending.
    pub(super) fn left_of(&self, other: &Plane) -> Vec<usize> {
        let mut found = Vec::new();
        for (y, (row, beside)) in self.rows().zip(other.rows()).enumerate() {
            for (k, word) in row.iter().enumerate() {
                let next = beside.get(k + 1).map_or(0, |word| word << 63);
                each_bit(word & (beside[k] >> 1 | next), |x| found.push(y * self.width + k * 64 + x));
            }
        }
        found
    }

    /// The cells of this plane whose neighbour in the row above is in the other, ascending.
    pub(super) fn below(&self, other: &Plane) -> Vec<usize> {
        let mut found = Vec::new();
        for (y, (row, above)) in self.rows().zip(other.rows().skip(1)).enumerate() {
            for (k, (word, above)) in row.iter().zip(above).enumerate() {
                each_bit(word & above, |x| found.push(y * self.width + k * 64 + x));
            }
        }
        found
    }

    /// Calls with the column of each cell of a stretch of a row, ascending.
    pub(super) fn each_in_row(&self, row: usize, columns: Range<usize>, mut call: impl FnMut(usize)) {
        let words = columns.start / 64..columns.end.div_ceil(64);
        for k in words {
            let word = self.words[row * self.stride + k];
            let from = u64::MAX << columns.start.saturating_sub(k * 64);
            let to = u64::MAX >> ((k + 1) * 64).saturating_sub(columns.end);
            each_bit(word & from & to, |x| call(k * 64 + x));
        }
    }

    /// Calls with each longest stretch of cells side by side, `start..end` in row-major order, row by row.
    pub(super) fn each_run(&self, mut call: impl FnMut(usize, usize)) {
        for (y, row) in self.rows().enumerate() {
            let first = y * self.width;
            let mut begun = None;
            for (k, &word) in row.iter().enumerate() {
                let at = first + k * 64;
                // A run that came in from the word before ends at the first cell that is not in the plane.
                let mut rest = word;
                if let Some(start) = begun.take() {
                    let ones = rest.trailing_ones() as usize;
                    if ones == 64 {
                        begun = Some(start);
                        continue;
                    }
                    call(start, at + ones);
                    rest &= u64::MAX << ones;
                }
                while rest != 0 {
                    let zeros = rest.trailing_zeros();
                    let ones = (rest >> zeros).trailing_ones();
                    let start = at + zeros as usize;
                    if zeros + ones == 64 {
                        begun = Some(start);
                        break;
                    }
                    call(start, start + ones as usize);
                    rest &= u64::MAX << (zeros + ones);
                }
            }
            if let Some(start) = begun {
                call(start, first + self.width);
            }
        }
    }
}

/// A bit for each of up to sixty-four values, whether it is as wanted.
fn packed<T>(values: &[T], wanted: &impl Fn(&T) -> bool) -> u64 {
    // Eight at once, which compilers make much of.
    let (eights, rest) = values.as_chunks::<8>();
    let eight = |values: &[T; 8]| {
        gathered(u64::from_le_bytes(values.each_ref().map(|value| u8::from(wanted(value)))))
    };
    let word = (0..).step_by(8).zip(eights).map(|(bit, values)| eight(values) << bit).sum::<u64>();
    let bit = |(bit, value): (usize, &T)| u64::from(wanted(value)) << bit;
    word | (eights.len() * 8..).zip(rest).map(bit).sum::<u64>()
}

fn each_bit(mut word: u64, mut call: impl FnMut(usize)) {
    while word != 0 {
        call(word.trailing_zeros() as usize);
        word &= word - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_cells() -> impl Strategy<Value = (usize, Vec<Cell>)> {
        let cell = prop_oneof![6 => Just(Cell::Free), 3 => Just(Cell::Unknown), 1 => Just(Cell::Occupied)];
        (1usize..150, 1usize..6).prop_flat_map(move |(width, height)| {
            (Just(width), prop::collection::vec(cell.clone(), width * height))
        })
    }

    proptest! {
        #[test]
        fn planes_say_what_the_cells_say((width, cells) in any_cells()) {
            let free = Plane::of(&cells, width, Cell::Free);
            let unknown = Plane::of(&cells, width, Cell::Unknown);
            let is = |i: usize, kind: Cell| cells.get(i) == Some(&kind);
            let beside = |step: usize, ends: fn(usize, usize) -> bool| -> Vec<usize> {
                let found = |&i: &usize| is(i, Cell::Free) && !ends(i, width) && is(i + step, Cell::Unknown);
                (0..cells.len()).filter(found).collect()
            };
            prop_assert_eq!(free.left_of(&unknown), beside(1, |i, width| i % width == width - 1));
            prop_assert_eq!(free.below(&unknown), beside(width, |_, _| false));
            for (plane, inside) in [(&free, true), (&free.complement(), false)] {
                let mut found = Vec::new();
                plane.each_run(|start, end| found.push((start, end)));
                let mut wanted = Vec::new();
                for (y, row) in cells.chunks(width).enumerate() {
                    let mut start = y * width;
                    for run in row.chunk_by(|a, b| (*a == Cell::Free) == (*b == Cell::Free)) {
                        if (run[0] == Cell::Free) == inside {
                            wanted.push((start, start + run.len()));
                        }
                        start += run.len();
                    }
                }
                prop_assert_eq!(found, wanted);
            }
        }

        #[test]
        fn a_stretch_of_a_row_has_its_cells((width, cells) in any_cells(), ends in [0usize..150, 0..150]) {
            let plane = Plane::of(&cells, width, Cell::Free);
            let [start, end] = ends.map(|end| end.min(width));
            for (y, row) in cells.chunks(width).enumerate() {
                let mut found = Vec::new();
                plane.each_in_row(y, start..end, |x| found.push(x));
                let wanted: Vec<usize> = (start..end).filter(|&x| row[x] == Cell::Free).collect();
                prop_assert_eq!(found, wanted);
            }
        }

        #[test]
        fn what_is_put_in_is_in_and_what_is_taken_out_is_not((width, cells) in any_cells(), pick in 0usize..1000) {
            let at = pick % cells.len();
            let mut changed = cells.clone();
            let mut plane = Plane::of(&cells, width, Cell::Free);
            for (kind, put) in [(Cell::Free, true), (Cell::Occupied, false)] {
                changed[at] = kind;
                if put { plane.insert(at) } else { plane.remove(at) }
                prop_assert_eq!(&plane.words, &Plane::of(&changed, width, Cell::Free).words);
            }
        }
    }
}
