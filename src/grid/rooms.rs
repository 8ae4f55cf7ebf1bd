//! Rooms: spaces at the end of a way that are wider than the way into them.

use crate::grid::GridInfo;
use crate::grid::thinning::sorted;
use std::ops::Range;

/// A space at or above some clearance, by its first cell in the order of flooding.
struct Space {
    /// Its widest cell.
    peak: u32,
    /// Whether it reaches the rim of the window.
    leaves: bool,
    /// Whether it was joined from spaces that are each wider than the way between them.
    parted: bool,
}

/// The widest cells of all rooms among the members, which are stretches of rows, ascending. `squared` are squared distances in cells.
///
/// Clearance is flooded from above. Where two spaces meet, the cell at which they do is the widest way between them; if
/// each has somewhere `ratio` times that clearance, they are different spaces, and one that does not reach the rim is a
/// room. (In the terms of morphology: peaks by their dynamics.) As long as sorting, else linear in the members.
pub(super) fn rooms(
    info: &GridInfo,
    members: &[Range<usize>],
    squared: &[u32],
    on_rim: impl Fn(usize) -> bool,
    ratio: f64,
) -> Vec<usize> {
    let order = sorted(members, squared);
    let mut flood = Flood { parents: Vec::new(), spaces: Vec::new(), rooms: Vec::new() };
    // 0 is no space yet.
    let mut space_of = vec![0u32; squared.len()];
    for &cell in order.iter().rev() {
        let i = cell as usize;
        let mut own: Option<u32> = None;
        for next in info.neighbors(info.index(i), true) {
            let j = info.offset(next);
            if space_of[j] == 0 {
                continue;
            }
            let other = flood.root(space_of[j] - 1);
            own = Some(match own {
                Some(own) if own != other => flood.meet(own, other, f64::from(squared[i]), squared, ratio),
                _ => other,
            });
        }
        let own = own.unwrap_or_else(|| flood.begin(cell));
        flood.spaces[own as usize].leaves |= on_rim(i);
        space_of[i] = own + 1;
    }
    flood.rooms.sort_unstable();
    flood.rooms
}

struct Flood {
    parents: Vec<u32>,
    spaces: Vec<Space>,
    rooms: Vec<usize>,
}

impl Flood {
    fn begin(&mut self, peak: u32) -> u32 {
        self.spaces.push(Space { peak, leaves: false, parted: false });
        self.parents.push(self.spaces.len() as u32 - 1);
        self.spaces.len() as u32 - 1
    }

    fn root(&mut self, mut space: u32) -> u32 {
        while self.parents[space as usize] != space {
            let above = self.parents[space as usize];
            self.parents[space as usize] = self.parents[above as usize];
            space = above;
        }
        space
    }

    /// Joins two spaces that meet at a level and notes which of them are rooms; the space that they make.
    fn meet(&mut self, a: u32, b: u32, level: f64, squared: &[u32], ratio: f64) -> u32 {
        let height =
            |flood: &Flood, space: u32| f64::from(squared[flood.spaces[space as usize].peak as usize]);
        let parted = [a, b].iter().all(|&space| height(self, space) >= ratio * ratio * level);
        if parted {
            for space in [a, b].map(|space| &self.spaces[space as usize]) {
                if !space.leaves && !space.parted {
                    self.rooms.push(space.peak as usize);
                }
            }
        }
        let [high, low] = if height(self, a) >= height(self, b) { [a, b] } else { [b, a] };
        self.parents[low as usize] = high;
        let (leaves, lower) = (self.spaces[low as usize].leaves, self.spaces[low as usize].parted);
        let space = &mut self.spaces[high as usize];
        space.leaves |= leaves;
        space.parted |= parted || lower;
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    /// Widest cells of rooms in a row of cells with the given clearances, of which the first is on the rim.
    fn found(clearance: &[u32]) -> Vec<usize> {
        let info = GridInfo { resolution: 1.0, width: clearance.len(), height: 1, origin: Pose::IDENTITY };
        let squared: Vec<u32> = clearance.iter().map(|&c| c * c).collect();
        let members: Vec<Range<usize>> =
            (0..clearance.len()).filter(|&i| clearance[i] > 0).map(|i| i..i + 1).collect();
        rooms(&info, &members, &squared, |i| i == 0, 1.5)
    }

    #[test]
    fn a_wide_end_is_a_room_and_a_narrow_one_is_not() {
        assert_eq!(found(&[10, 12, 11, 5, 6, 8, 7]), [5]);
        assert_eq!(found(&[10, 12, 11, 5, 6, 7, 6]), [0usize; 0]);
        assert_eq!(found(&[10, 10, 10, 10, 9, 10, 9]), [0usize; 0]);
    }

    #[test]
    fn a_suite_is_as_many_rooms_as_it_has_and_a_single_space_none() {
        assert_eq!(found(&[10, 12, 5, 20, 6, 10, 6]), [3, 5]);
        assert_eq!(found(&[0, 5, 8, 20, 8, 5, 0]), [0usize; 0]);
    }
}
