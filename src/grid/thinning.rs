//! Homotopic thinning in the order of distance.
//!
//! Cells are removed from the lowest distance upward as long as they are *simple*: their removal changes neither
//! the number of pieces (8-connected) nor the number of holes (4-connected) of what remains. Anchors are kept. What
//! is left is the thinnest set that joins the anchors along the ridges of the distance, in other words the
//! widest ways between them (Coeurjolly, Couprie and Zrour call it a guided homotopic skeleton).

use std::ops::Range;

/// The cells that remain of some in a grid of width x height cells, ascending. They come as stretches of rows,
/// ascending; `rank` gives the order of removal of each cell of the grid. As long as sorting, else linear in the cells.
pub(super) fn thin(
    width: usize,
    height: usize,
    stretches: &[Range<usize>],
    rank: &[u32],
    anchors: &[usize],
) -> Vec<usize> {
    let mut figure = Figure::new(width, height, stretches, rank);
    anchors.iter().for_each(|&i| figure.fix(i));
    figure.peel(&order_of_removal(stretches, rank));
    let left = stretches.iter().cloned().flatten().filter(|&i| figure.ranks[figure.padded(i)] != GONE);
    left.collect()
}

/// Cells and their ranks, sorted.
fn order_of_removal(stretches: &[Range<usize>], rank: &[u32]) -> Vec<(u32, u32)> {
    let mut order = Vec::with_capacity(stretches.iter().map(Range::len).sum());
    for stretch in stretches {
        order.extend(rank[stretch.clone()].iter().zip(stretch.start as u32..).map(|(&rank, i)| (rank, i)));
    }
    sort(&mut order);
    order
}

/// Sorts by rank and then by position; by counting where ranks are dense. Members come by ascending position.
pub(super) fn sort(order: &mut Vec<(u32, u32)>) {
    let most = order.iter().map(|&(rank, _)| rank as usize).max().unwrap_or(0);
    if most > 4 * order.len() {
        order.sort_unstable();
        return;
    }
    let mut starts = vec![0u32; most + 2];
    order.iter().for_each(|&(rank, _)| starts[rank as usize + 1] += 1);
    (1..starts.len()).for_each(|rank| starts[rank] += starts[rank - 1]);
    let mut sorted = vec![(0, 0); order.len()];
    for &entry in order.iter() {
        let slot = &mut starts[entry.0 as usize];
        sorted[*slot as usize] = entry;
        *slot += 1;
    }
    *order = sorted;
}

/// The rank of what is not, or no longer, in the figure.
const GONE: u32 = u32::MAX;
/// That of an anchor: no turn comes so late.
const FIXED: u32 = u32::MAX - 1;

/// What is left of the cells, within a frame of absent cells that makes every neighbourhood complete.
struct Figure {
    width: usize,
    ranks: Vec<u32>,
    /// Which of the eight neighbours of a cell are there, a bit each, counter-clockwise from the right.
    rings: Vec<u8>,
    /// Offsets of the eight neighbours in the same order.
    around: [isize; 8],
}

impl Figure {
    fn new(width: usize, height: usize, stretches: &[Range<usize>], rank: &[u32]) -> Self {
        let (stride, size) = (width + 2, (width + 2) * (height + 2));
        let s = stride as isize;
        let around = [1, s + 1, s, s - 1, -1, -s - 1, -s, -s + 1];
        let mut figure = Figure { width, ranks: vec![GONE; size], rings: vec![0; size], around };
        let mut there = vec![0u8; size];
        let padded = |stretch: &Range<usize>| {
            let first = (stretch.start / width + 1) * stride + stretch.start % width + 1;
            first..first + stretch.len()
        };
        for stretch in stretches {
            there[padded(stretch)].fill(1);
            let ranks = figure.ranks[padded(stretch)].iter_mut();
            ranks.zip(&rank[stretch.clone()]).for_each(|(kept, &rank)| *kept = rank.min(FIXED - 1));
        }
        for stretch in stretches {
            let cells = padded(stretch);
            for (bit, offset) in around.into_iter().enumerate() {
                let beside = cells.start.wrapping_add_signed(offset)..cells.end.wrapping_add_signed(offset);
                let rings = figure.rings[cells.clone()].iter_mut();
                rings.zip(&there[beside]).for_each(|(ring, there)| *ring |= there << bit);
            }
        }
        figure
    }

    fn padded(&self, i: usize) -> usize {
        (i / self.width + 1) * (self.width + 2) + i % self.width + 1
    }

    fn fix(&mut self, i: usize) {
        let p = self.padded(i);
        self.ranks[p] = FIXED;
    }

    fn peel(&mut self, order: &[(u32, u32)]) {
        let mut again = Vec::new();
        for level in order.chunk_by(|a, b| a.0 == b.0) {
            let rank = level[0].0.min(FIXED - 1);
            level.iter().for_each(|&(_, i)| self.take(self.padded(i as usize), rank, &mut again));
            // A removal can make lower neighbours simple that were not when their turn came.
            let mut next = 0;
            while next < again.len() {
                self.take(again[next] as usize, rank, &mut again);
                next += 1;
            }
            again.clear();
        }
    }

    /// Removes a cell that is simple; its neighbours of no higher rank are to be looked at again.
    fn take(&mut self, p: usize, rank: u32, again: &mut Vec<u32>) {
        let ring = self.rings[p];
        if self.ranks[p] >= FIXED || !SIMPLE[usize::from(ring)] {
            return;
        }
        self.ranks[p] = GONE;
        let mut beside = ring;
        while beside != 0 {
            let bit = beside.trailing_zeros();
            beside &= beside - 1;
            let q = p.wrapping_add_signed(self.around[bit as usize]);
            self.rings[q] ^= 1 << ((bit + 4) % 8);
            if self.ranks[q] <= rank {
                again.push(q as u32);
            }
        }
    }
}

/// For every neighbourhood, whether its centre is simple: Yokoi's connectivity number for 8-connected figures is 1.
static SIMPLE: [bool; 256] = simple_table();

const fn simple_table() -> [bool; 256] {
    let mut table = [false; 256];
    let mut ring = 0;
    while ring < 256 {
        let mut number = 0;
        let mut k = 0;
        while k < 8 {
            let a = 1 - ((ring >> k) & 1);
            let b = 1 - ((ring >> (k + 1)) & 1);
            let c = 1 - ((ring >> ((k + 2) % 8)) & 1);
            number += a - a * b * c;
            k += 2;
        }
        table[ring] = number == 1;
        ring += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Pieces of the cells for which `inside` holds.
    fn pieces(width: usize, height: usize, diagonal: bool, inside: impl Fn(usize) -> bool) -> usize {
        let mut seen = vec![false; width * height];
        let mut count = 0;
        for start in (0..width * height).filter(|&i| inside(i)) {
            if std::mem::replace(&mut seen[start], true) {
                continue;
            }
            count += 1;
            let mut stack = vec![start];
            while let Some(i) = stack.pop() {
                for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1isize)] {
                    let (x, y) = ((i % width) as isize + dx, (i / width) as isize + dy);
                    let outside = x < 0 || y < 0 || x >= width as isize || y >= height as isize;
                    if outside || (!diagonal && dx != 0 && dy != 0) {
                        continue;
                    }
                    let j = y as usize * width + x as usize;
                    if inside(j) && !std::mem::replace(&mut seen[j], true) {
                        stack.push(j);
                    }
                }
            }
        }
        count
    }

    fn padded_holes(width: usize, height: usize, cells: &[usize]) -> usize {
        let (w, h) = (width + 2, height + 2);
        let inner = |p: usize| (1..=width).contains(&(p % w)) && (1..=height).contains(&(p / w));
        pieces(w, h, false, |p| !inner(p) || !cells.contains(&((p / w - 1) * width + p % w - 1)))
    }

    proptest! {
        #[test]
        fn pieces_and_holes_are_kept(filled in prop::collection::vec(prop::bool::weighted(0.7), 12 * 9), seed in 0u32..1000) {
            let members: Vec<usize> = (0..filled.len()).filter(|&i| filled[i]).collect();
            let anchors: Vec<usize> = members.iter().copied().filter(|i| i % 17 == seed as usize % 17).collect();
            let rank: Vec<u32> = (0..filled.len() as u32).map(|i| (i * 7919 + seed) % 5).collect();
            let stretches: Vec<Range<usize>> = members.iter().map(|&i| i..i + 1).collect();
            let left = thin(12, 9, &stretches, &rank, &anchors);
            prop_assert!(anchors.iter().all(|i| left.contains(i)));
            let count = |cells: &[usize]| pieces(12, 9, true, |i| cells.contains(&i));
            prop_assert_eq!(count(&members), count(&left));
            prop_assert_eq!(padded_holes(12, 9, &members), padded_holes(12, 9, &left));
        }
    }

    #[test]
    fn a_full_rectangle_shrinks_to_a_line_between_anchors() {
        let rows: Vec<Range<usize>> = (0..5).map(|y| 10 * y..10 * y + 10).collect();
        let rank: Vec<u32> = (0..50).map(|i| (i / 10).min(4 - i / 10)).collect();
        assert_eq!(thin(10, 5, &rows, &rank, &[20, 29]), (20..30).collect::<Vec<_>>());
        assert_eq!(thin(10, 5, &rows, &rank, &[]).len(), 1);
    }
}
