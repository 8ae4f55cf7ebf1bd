//! The order of the places on paths.

use crate::classic::{Action, AxiomId, Dstate};

/// What the order on paths shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    /// The number of stops: of pairs of a path and a place on it.
    pub(super) stops: usize,
    /// The number of places of the longest chain that is strictly ordered on one path. Each of them differs from all
    /// others, in this map and in all that grow from it.
    pub(super) longest_chain: usize,
}

/// Whether a place has one dstate for each direction of its paths, and the order on every path is strict.
pub(super) fn check_stops(dstates: &[Dstate]) -> Result<(), AxiomId> {
    order(dstates).map(|_| ())
}

/// The order on paths, or the axiom that does not hold.
pub(super) fn order(dstates: &[Dstate]) -> Result<Order, AxiomId> {
    let (stops, count) = stops(dstates)?;
    let mut rank = vec![0; count];
    let mut travels: Vec<(usize, usize)> = Vec::with_capacity(dstates.len());
    for (dstate, &stop) in dstates.iter().zip(&stops) {
        if let Some(to) = dstate.after[Action::Travel as usize] {
            let far = stops[to.index()];
            travels.push(if dstate.reversed { (far, stop) } else { (stop, far) });
        }
    }
    loop {
        let mut longest = 0;
        let mut settled = true;
        for &(before, behind) in &travels {
            if rank[behind] <= rank[before] {
                rank[behind] = rank[before] + 1;
                settled = false;
            }
            longest = rank[behind].max(longest);
        }
        // A chain has no more places than there are stops, unless it is closed.
        if longest >= count {
            return Err(AxiomId::PathOrder);
        }
        if settled {
            return Ok(Order { stops: count, longest_chain: longest + 1 });
        }
    }
}

/// For each dstate the stop it faces from, a place on a path, and the number of stops. Both dstates of a stop face
/// from it, one each way.
fn stops(dstates: &[Dstate]) -> Result<(Vec<usize>, usize), AxiomId> {
    let stop = |index: usize| (dstates[index].path, dstates[index].place);
    let mut sorted: Vec<usize> = (0..dstates.len()).collect();
    sorted.sort_unstable_by_key(|&index| (stop(index), dstates[index].reversed));
    let (mut stops, mut count) = (vec![0; dstates.len()], 0);
    for (position, &index) in sorted.iter().enumerate() {
        let before = position.checked_sub(1).map(|before| sorted[before]);
        match before.filter(|&before| stop(before) == stop(index)) {
            Some(before) if dstates[before].reversed == dstates[index].reversed => {
                return Err(AxiomId::OneDstate);
            }
            Some(_) => {}
            None => count += 1,
        }
        stops[index] = count - 1;
    }
    Ok((stops, count))
}
