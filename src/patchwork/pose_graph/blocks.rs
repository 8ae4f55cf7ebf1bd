//! Which poses an edge can move against each other: those on loops through it.
//!
//! A pose graph falls into blocks, its biconnected components, which hang together at single poses. Moving a block as a
//! whole about such a pose strains nothing, so that the least strain of a block is its own affair: a new edge changes the
//! shape of the block it lies in, and what hangs on that block follows, rigidly (Hopcroft and Tarjan 1973).

use std::collections::VecDeque;

/// A graph as lists of neighbours: the other end and the number of each edge.
#[derive(Clone, Debug, Default)]
pub(super) struct Neighbours(Vec<Vec<[u32; 2]>>);

impl Neighbours {
    /// Adds a pose without edges.
    pub(super) fn add_pose(&mut self) {
        self.0.push(vec![]);
    }

    /// Adds the edge of the next number.
    pub(super) fn add_edge(&mut self, [a, b]: [u32; 2], number: u32) {
        self.0[a as usize].push([b, number]);
        self.0[b as usize].push([a, number]);
    }

    /// The block of each edge of one part, by a number; edges of other parts have none. Linear in the part.
    pub(super) fn blocks(&self, first: u32, edges: usize) -> Vec<Option<u32>> {
        let mut search = Search {
            order: vec![0; self.0.len()],
            low: vec![0; self.0.len()],
            open: vec![],
            blocks: vec![None; edges],
            taken: vec![false; edges],
            count: 0,
        };
        search.run(self, first);
        search.blocks
    }

    /// For each pose the pose of `within` through which the way from there leads to it, over edges that are not `inside`;
    /// itself for those of `within` that are reached, none for what is not connected.
    pub(super) fn carriers(&self, within: &[u32], inside: impl Fn(u32) -> bool) -> Vec<Option<u32>> {
        let mut carriers = vec![None; self.0.len()];
        let mut queue: VecDeque<u32> = within.iter().copied().collect();
        within.iter().for_each(|pose| carriers[*pose as usize] = Some(*pose));
        while let Some(at) = queue.pop_front() {
            for &[other, edge] in &self.0[at as usize] {
                if !inside(edge) && carriers[other as usize].is_none() {
                    carriers[other as usize] = carriers[at as usize];
                    queue.push_back(other);
                }
            }
        }
        carriers
    }
}

struct Search {
    /// When each pose was met, from 1.
    order: Vec<u32>,
    /// The earliest pose that can be reached without going back.
    low: Vec<u32>,
    /// Edges met whose block is not closed.
    open: Vec<u32>,
    blocks: Vec<Option<u32>>,
    taken: Vec<bool>,
    count: u32,
}

impl Search {
    /// Depth first without recursion: chains of poses are as long as runs of robots.
    fn run(&mut self, graph: &Neighbours, first: u32) {
        let mut met = 1;
        self.order[first as usize] = met;
        self.low[first as usize] = met;
        // Each pose on the way with its next neighbour, and how many edges were open before it.
        let mut way = vec![(first, 0_usize, 0_usize)];
        while let Some((pose, next, _)) = way.last_mut() {
            let at = *pose;
            let Some(&[other, edge]) = graph.0[at as usize].get(*next) else {
                let (_, _, open) = way.pop().unwrap_or_default();
                if let Some((before, ..)) = way.last() {
                    self.leave(at, *before, open);
                }
                continue;
            };
            *next += 1;
            if std::mem::replace(&mut self.taken[edge as usize], true) {
                continue;
            }
            let open = self.open.len();
            self.open.push(edge);
            if self.order[other as usize] == 0 {
                met += 1;
                self.order[other as usize] = met;
                self.low[other as usize] = met;
                way.push((other, 0, open));
            } else {
                self.low[at as usize] = self.low[at as usize].min(self.order[other as usize]);
            }
        }
    }

    fn leave(&mut self, at: u32, before: u32, open: usize) {
        let low = self.low[at as usize];
        if low < self.order[before as usize] {
            self.low[before as usize] = self.low[before as usize].min(low);
            return;
        }
        for edge in self.open.drain(open..) {
            self.blocks[edge as usize] = Some(self.count);
        }
        self.count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn neighbours(poses: u32, pairs: &[[u32; 2]]) -> Neighbours {
        let mut graph = Neighbours::default();
        (0..poses).for_each(|_| graph.add_pose());
        pairs.iter().zip(0..).for_each(|(pair, number)| graph.add_edge(*pair, number));
        graph
    }

    /// Whether two poses are connected without some pose.
    fn connected(pairs: &[[u32; 2]], from: u32, to: u32, without: Option<u32>, but: usize) -> bool {
        let mut reached = vec![from];
        let mut k = 0;
        while k < reached.len() {
            let at = reached[k];
            for (number, pair) in pairs.iter().enumerate() {
                let other = if pair[0] == at {
                    pair[1]
                } else if pair[1] == at {
                    pair[0]
                } else {
                    continue;
                };
                if number != but && Some(other) != without && !reached.contains(&other) {
                    reached.push(other);
                }
            }
            k += 1;
        }
        reached.contains(&to)
    }

    proptest! {
        #[test]
        fn two_edges_are_in_one_block_where_no_pose_parts_them(
            pairs in prop::collection::vec((0..7_u32, 1..7_u32), 1..12)
        ) {
            let pairs: Vec<[u32; 2]> = pairs.into_iter().map(|(a, ahead)| [a, (a + ahead) % 7]).collect();
            let graph = neighbours(7, &pairs);
            let blocks = graph.blocks(pairs[0][0], pairs.len());
            for (k, [a, b]) in pairs.iter().enumerate() {
                prop_assert_eq!(blocks[k].is_some(), connected(&pairs, pairs[0][0], *a, None, usize::MAX));
                // Alone in its block: a bridge.
                let alone = (0..pairs.len()).filter(|other| blocks[*other] == blocks[k]).count() == 1;
                if blocks[k].is_some() {
                    prop_assert_eq!(alone, !connected(&pairs, *a, *b, None, k));
                }
            }
            // Two edges at one pose are in one block where their other ends are connected without it.
            for (k, p) in pairs.iter().enumerate() {
                for (l, q) in pairs.iter().enumerate().skip(k + 1) {
                    for (at, from) in [(p[0], p[1]), (p[1], p[0])] {
                        let Some(to) = (if q[0] == at { Some(q[1]) } else if q[1] == at { Some(q[0]) } else { None })
                        else { continue };
                        if blocks[k].is_some() {
                            let loops = connected(&pairs, from, to, Some(at), usize::MAX);
                            prop_assert_eq!(blocks[k] == blocks[l], loops, "{:?} {} {}", pairs, k, l);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn what_hangs_on_a_block_is_carried_by_the_pose_it_hangs_on() {
        // A triangle 0 1 2, a tail 2 3 4, and 5 apart.
        let graph = neighbours(6, &[[0, 1], [1, 2], [2, 0], [2, 3], [3, 4]]);
        let carriers = graph.carriers(&[0, 1, 2], |edge| edge < 3);
        assert_eq!(carriers, [Some(0), Some(1), Some(2), Some(2), Some(2), None]);
    }
}
