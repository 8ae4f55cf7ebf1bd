//! Homotopic thinning in the order of distance.
//!
//! Cells are removed from the lowest distance upward as long as they are *simple*: their removal changes neither
//! the number of pieces (8-connected) nor the number of holes (4-connected) of what remains. Anchors are kept. What
//! is left is the thinnest set that joins the anchors along the ridges of the distance, in other words the
//! widest ways between them (Coeurjolly, Couprie and Zrour call it a guided homotopic skeleton).

use std::ops::Range;

/// The cells that remain of some in a grid of width x height cells, ascending. They come as stretches of rows,
/// ascending; `rank` gives the order of removal of each cell of the grid.
pub(super) fn thin(
    width: usize,
    height: usize,
    stretches: &[Range<usize>],
    rank: &[u32],
    anchors: &[usize],
) -> Vec<usize> {
    // A frame of absent cells makes every neighbourhood complete.
    let stride = width + 2;
    let padded = |i: usize| (i / width + 1) * stride + i % width + 1;
    let mut ranks = vec![0u32; stride * (height + 2)];
    let mut present = vec![false; stride * (height + 2)];
    let mut order: Vec<(u32, u32)> = Vec::with_capacity(stretches.iter().map(Range::len).sum());
    for stretch in stretches {
        let first = padded(stretch.start);
        let there = first..first + stretch.len();
        ranks[there.clone()].copy_from_slice(&rank[stretch.clone()]);
        present[there].fill(true);
        order.extend(rank[stretch.clone()].iter().zip(first as u32..).map(|(&rank, p)| (rank, p)));
    }
    let mut fixed = vec![false; present.len()];
    anchors.iter().for_each(|&i| fixed[padded(i)] = true);
    sort(&mut order);
    peel(&order, &ranks, &fixed, &mut present, stride);
    let left = |stretch: &Range<usize>| {
        let first = padded(stretch.start);
        let cells = stretch.clone().zip(&present[first..first + stretch.len()]);
        cells.filter(|(_, present)| **present).map(|(i, _)| i).collect::<Vec<_>>()
    };
    stretches.iter().flat_map(left).collect()
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

fn peel(order: &[(u32, u32)], ranks: &[u32], fixed: &[bool], present: &mut [bool], stride: usize) {
    let around = ring(stride);
    let mut again: Vec<usize> = Vec::new();
    for level in order.chunk_by(|a, b| a.0 == b.0) {
        let rank = level[0].0;
        again.clear();
        again.extend(level.iter().map(|&(_, p)| p as usize));
        // A removal can make lower neighbours simple that were not when their turn came.
        let mut next = 0;
        while next < again.len() {
            let p = again[next];
            next += 1;
            if !present[p] || fixed[p] || !SIMPLE[neighborhood(present, p, stride)] {
                continue;
            }
            present[p] = false;
            for offset in around {
                let q = p.wrapping_add_signed(offset);
                if present[q] && ranks[q] <= rank {
                    again.push(q);
                }
            }
        }
    }
}

/// Offsets of the eight neighbours, counter-clockwise from the right.
fn ring(stride: usize) -> [isize; 8] {
    let s = stride as isize;
    [1, s + 1, s, s - 1, -1, -s - 1, -s, -s + 1]
}

/// Which of the eight neighbours are present, a bit each in the order of [`ring`].
fn neighborhood(present: &[bool], p: usize, stride: usize) -> usize {
    let row = |middle: usize| [present[middle - 1], present[middle], present[middle + 1]].map(usize::from);
    let (below, [left, _, right], above) = (row(p - stride), row(p), row(p + stride));
    right
        | above[2] << 1
        | above[1] << 2
        | above[0] << 3
        | left << 4
        | below[0] << 5
        | below[1] << 6
        | below[2] << 7
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
