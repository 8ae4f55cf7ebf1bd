//! How simple a map can become.

use crate::classic::order::order;
use crate::classic::{Action, ClassicMap, Sight, Simplicity};
use std::collections::BTreeMap;

/// Actions still to come, by what they can take away.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ahead {
    turns: usize,
    turns_around: usize,
    travels: usize,
}

/// After each observation, what is still ahead.
pub(super) fn ahead(seen: &[Sight]) -> Vec<Ahead> {
    let mut ahead = vec![Ahead::default(); seen.len()];
    for next in (1..seen.len()).rev() {
        let Ahead { turns, turns_around, travels } = ahead[next];
        let action = seen[next].action;
        ahead[next - 1] = Ahead {
            turns: turns + usize::from(action.is_turn()),
            turns_around: turns_around + usize::from(action == Action::Around),
            travels: travels + usize::from(action == Action::Travel),
        };
    }
    ahead
}

/// No map that grows from this one by the actions ahead is simpler.
pub(super) fn least_possible(map: &ClassicMap, ahead: Ahead) -> Simplicity {
    let Simplicity { paths, places } = map.simplicity();
    // A consistent map has an order; without one, nothing is known of what it may become.
    let Ok(order) = order(map.dstates()) else { return Simplicity { paths: 0, places: 0 } };
    let single = 2 * order.stops - map.dstates().len();
    let left = paths_left(paths, single, ahead);
    Simplicity {
        paths: left.max(paths_now(map)),
        // Places in a chain on a path never become one, and a turn makes two places one at most.
        places: order.longest_chain.max(places.saturating_sub(ahead.turns)),
    }
}

/// The paths that a map keeps for ever: a place keeps its dstates, no path has more than two of them, and where a
/// robot turned left or right there are two paths.
fn paths_now(map: &ClassicMap) -> usize {
    let mut sizes = BTreeMap::new();
    map.dstates().iter().for_each(|dstate| *sizes.entry(dstate.place).or_insert(0) += 1);
    let turned = |action: Action| map.dstates().iter().any(|dstate| dstate.after[action as usize].is_some());
    let turned = Action::ALL.into_iter().any(|action| action.changes_path() && turned(action));
    sizes.values().max().map_or(0, |size: &usize| size.div_ceil(2)).max(1 + usize::from(turned))
}

/// The paths that the actions ahead cannot take away, of so many, of which so many stops have a single dstate.
///
/// A travel or a turn around makes two paths one at most. For turns around, count paths less half of the single
/// dstates: one that joins two paths pairs two single dstates and leaves that number; one to a new dstate raises it;
/// a turn left or right to a new dstate adds a path and a single dstate; joined places only pair. A travel takes one
/// at most. And there are no fewer paths than that number.
fn paths_left(paths: usize, single: usize, ahead: Ahead) -> usize {
    let by_actions = paths.saturating_sub(ahead.turns_around + ahead.travels);
    let by_single = (2 * paths).saturating_sub(single + 2 * ahead.travels).div_ceil(2);
    by_actions.max(by_single)
}
