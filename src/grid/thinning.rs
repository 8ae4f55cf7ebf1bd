//! Homotopic thinning in the order of distance.
//!
//! Cells are removed from the lowest distance upward as long as they are *simple*: their removal changes neither
//! the number of pieces (8-connected) nor the number of holes (4-connected) of what remains. Anchors are kept. What
//! is left is the thinnest set that joins the anchors along the ridges of the distance, in other words the
//! widest ways between them (Coeurjolly, Couprie and Zrour call it a guided homotopic skeleton).

use crate::grid::plane::gathered;
use std::ops::Range;

/// The cells that remain of some in a grid with rows of `stride` cells, ascending. They come as stretches of rows,
/// ascending, none of which reaches the border of the grid, so that every neighbourhood is complete. `rank` gives the
/// order of removal of each cell of the grid. As long as sorting, else linear in the cells.
pub(super) fn thin(stride: usize, stretches: &[Range<usize>], rank: &[u32], anchors: &[usize]) -> Vec<usize> {
    // One more, as `neighbors` reads four at a time.
    let mut marks = vec![GONE; rank.len() + 1];
    stretches.iter().for_each(|stretch| marks[stretch.clone()].fill(THERE));
    anchors.iter().for_each(|&i| marks[i] = FIXED);
    peel(&sorted(stretches, rank), rank, &mut marks, stride);
    stretches.iter().cloned().flatten().filter(|&i| marks[i] != GONE).collect()
}

/// What has become of a cell.
const GONE: u8 = 0;
const THERE: u8 = 1;
/// Its turn has come.
const DUE: u8 = THERE | 2;
/// What tells that of eight marks.
const ALL_DUE: u64 = 0x0202_0202_0202_0202;
/// It is an anchor.
const FIXED: u8 = THERE | 4;

/// The cells of ascending stretches, sorted by rank and then by position; by counting where ranks are dense.
pub(super) fn sorted(stretches: &[Range<usize>], rank: &[u32]) -> Vec<u32> {
    let ranked = || {
        let cells = |stretch: &Range<usize>| (stretch.start as u32..).zip(&rank[stretch.clone()]);
        stretches.iter().flat_map(cells)
    };
    let count = stretches.iter().map(Range::len).sum();
    let most_of = |stretch: &Range<usize>| rank[stretch.clone()].iter().copied().fold(0, u32::max);
    let most = stretches.iter().map(most_of).fold(0, u32::max) as usize;
    if most > 4 * count {
        let mut cells: Vec<u32> = ranked().map(|(cell, _)| cell).collect();
        cells.sort_by_key(|&cell| rank[cell as usize]);
        return cells;
    }
    let mut starts = vec![0u32; most + 2];
    ranked().for_each(|(_, &rank)| starts[rank as usize + 1] += 1);
    (1..starts.len()).for_each(|rank| starts[rank] += starts[rank - 1]);
    let mut sorted = vec![0; count];
    ranked().for_each(|(cell, &rank)| {
        let slot = &mut starts[rank as usize];
        sorted[*slot as usize] = cell;
        *slot += 1;
    });
    sorted
}

fn peel(order: &[u32], ranks: &[u32], marks: &mut [u8], stride: usize) {
    let around = ring(stride);
    let mut again: Vec<u32> = Vec::new();
    for level in order.chunk_by(|&a, &b| ranks[a as usize] == ranks[b as usize]) {
        again.clear();
        again.extend(level);
        level.iter().for_each(|&p| marks[p as usize] |= DUE);
        // A removal can make lower neighbours simple that were not when their turn came.
        let mut next = 0;
        while next < again.len() {
            let p = again[next] as usize;
            next += 1;
            if marks[p] != DUE {
                continue;
            }
            let neighbors = neighbors(marks, p, stride);
            if !SIMPLE[gathered(neighbors) as usize] {
                continue;
            }
            marks[p] = GONE;
            // Mostly there is none.
            if neighbors & ALL_DUE != 0 {
                let there = around.map(|offset| p.wrapping_add_signed(offset));
                again.extend(there.into_iter().filter(|&q| marks[q] == DUE).map(|q| q as u32));
            }
        }
    }
}

/// Offsets of the eight neighbours, counter-clockwise from the right.
fn ring(stride: usize) -> [isize; 8] {
    let s = stride as isize;
    [1, s + 1, s, s - 1, -1, -s - 1, -s, -s + 1]
}

/// The marks of the eight neighbours, a byte each, row by row from the lowest on. One mark more is read than those.
fn neighbors(marks: &[u8], p: usize, stride: usize) -> u64 {
    let row = |middle: usize| {
        let four = marks[middle - 1..].first_chunk().map_or(0, |&four| u32::from_le_bytes(four));
        u64::from(four) & 0xff_ffff
    };
    let (below, here, above) = (row(p - stride), row(p), row(p + stride));
    below | (here & 0xff) << 24 | here >> 16 << 32 | above << 40
}

/// Where in [`neighbors`] those of [`ring`] are.
const RING: [usize; 8] = [4, 7, 6, 5, 3, 0, 1, 2];

/// For every neighbourhood, a bit for each of [`neighbors`], whether its centre is simple: Yokoi's connectivity number for 8-connected figures is 1.
static SIMPLE: [bool; 256] = simple_table();

const fn simple_table() -> [bool; 256] {
    let mut table = [false; 256];
    let mut around = 0;
    while around < 256 {
        let mut number = 0;
        let mut k = 0;
        while k < 8 {
            let a = 1 - ((around >> RING[k]) & 1);
            let b = 1 - ((around >> RING[k + 1]) & 1);
            let c = 1 - ((around >> RING[(k + 2) % 8]) & 1);
            number += a - a * b * c;
            k += 2;
        }
        table[around] = number == 1;
        around += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::{BTreeSet, VecDeque};

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

    /// The place of a cell of 12 x 9 within a frame of one cell.
    fn framed(i: usize) -> usize {
        (i / 12 + 1) * 14 + i % 12 + 1
    }

    /// What is left when cells are removed one by one as long as neither pieces nor holes change in number.
    fn thinned_by_definition(members: &[usize], rank: &[u32], anchors: &[usize]) -> Vec<usize> {
        let mut there = vec![false; rank.len()];
        members.iter().for_each(|&i| there[i] = true);
        let count =
            |there: &[bool]| (pieces(14, 11, true, |i| there[i]), pieces(14, 11, false, |i| !there[i]));
        let levels: BTreeSet<u32> = members.iter().map(|&i| rank[i]).collect();
        for level in levels {
            let mut turns: VecDeque<usize> = members.iter().copied().filter(|&i| rank[i] == level).collect();
            while let Some(i) = turns.pop_front() {
                if !there[i] || anchors.contains(&i) {
                    continue;
                }
                let before = count(&there);
                there[i] = false;
                if count(&there) != before {
                    there[i] = true;
                    continue;
                }
                let around = ring(14).map(|offset| i.wrapping_add_signed(offset));
                turns.extend(around.into_iter().filter(|&j| there[j] && rank[j] <= level));
            }
        }
        (0..there.len()).filter(|&i| there[i]).collect()
    }

    proptest! {
        #[test]
        fn pieces_and_holes_are_kept_as_by_the_definition(
            filled in prop::collection::vec(prop::bool::weighted(0.7), 12 * 9), seed in 0u32..1000,
            spread in prop_oneof![Just(1u32), Just(1000)],
        ) {
            let members: Vec<usize> = (0..filled.len()).filter(|&i| filled[i]).map(framed).collect();
            let anchors: Vec<usize> = members.iter().copied().filter(|i| i % 17 == seed as usize % 17).collect();
            let rank: Vec<u32> = (0..14 * 11).map(|i| (i * 7919 + seed) % 5 * spread).collect();
            let stretches: Vec<Range<usize>> = members.iter().map(|&i| i..i + 1).collect();
            let left = thin(14, &stretches, &rank, &anchors);
            prop_assert!(anchors.iter().all(|i| left.contains(i)));
            let count = |cells: &[usize]| pieces(14, 11, true, |i| cells.contains(&i));
            prop_assert_eq!(count(&members), count(&left));
            let holes = |cells: &[usize]| pieces(14, 11, false, |i| !cells.contains(&i));
            prop_assert_eq!(holes(&members), holes(&left));
            prop_assert_eq!(left, thinned_by_definition(&members, &rank, &anchors));
        }
    }

    #[test]
    fn a_full_rectangle_shrinks_to_a_line_between_anchors() {
        let rows: Vec<Range<usize>> = (1..6).map(|y| 12 * y + 1..12 * y + 11).collect();
        let rank: Vec<u32> = (0..84u32).map(|i| (i / 12).min(6 - i / 12)).collect();
        assert_eq!(thin(12, &rows, &rank, &[37, 46]), (37..47).collect::<Vec<_>>());
        assert_eq!(thin(12, &rows, &rank, &[]).len(), 1);
    }
}
