//! The law `boundary`, and how often it has to be broken.

use crate::abduction::Visit;
use crate::reference::told::{End, Story, Told};
use std::collections::BTreeSet;

/// Places beside a path, and the least dstate of the path that leads to them.
pub type Evidence = BTreeSet<(usize, End)>;

/// A path: the places on it, and the evidence left and right of it.
type Sides = (BTreeSet<usize>, [Evidence; 2]);

/// Whoever walks along a path and sees others leave it to the left and to the right never sees a place ahead on
/// two of left, right and the path itself.
pub(super) fn boundary(told: &Told<'_>) -> bool {
    sides(told).iter().all(|path| agrees(path, &[]))
}

/// The fewest pairs of paths to be exempt, so that the other evidence agrees: of each path all sets of paths that
/// carry evidence about it, the small ones first. Exponential in the number found.
pub fn abnormalities(visits: &[Visit], story: &Story) -> usize {
    let fewest = |path: &Sides| {
        let carriers: BTreeSet<End> = path.1.iter().flatten().map(|it| it.1).collect();
        let carriers: Vec<End> = carriers.into_iter().collect();
        (0..carriers.len())
            .find(|&most| some_agree(path, &carriers, most, &mut Vec::new()))
            .unwrap_or(carriers.len())
    };
    sides(&Told::new(visits, story)).iter().map(fewest).sum()
}

/// For each path the places on it, and those left and right of it, as one sees who walks in the direction of its
/// least dstate.
pub fn beside(visits: &[Visit], story: &Story) -> Vec<(BTreeSet<usize>, [Evidence; 2])> {
    sides(&Told::new(visits, story))
}

/// Whether what is said of a path agrees once some paths are not asked.
fn agrees((on, sides): &Sides, exempt: &[End]) -> bool {
    let believed = |side: &Evidence| -> BTreeSet<usize> {
        side.iter().filter(|it| !exempt.contains(&it.1)).map(|it| it.0).collect()
    };
    let [left, right] = sides.each_ref().map(believed);
    left.is_disjoint(&right) && left.is_disjoint(on) && right.is_disjoint(on)
}

/// Whether it agrees once the exempt and `most` more of some carriers are not asked.
fn some_agree(path: &Sides, carriers: &[End], most: usize, exempt: &mut Vec<End>) -> bool {
    if most == 0 {
        return agrees(path, exempt);
    }
    (0..carriers.len()).any(|first| {
        exempt.push(carriers[first]);
        let found = some_agree(path, &carriers[first + 1..], most - 1, exempt);
        exempt.pop();
        found
    })
}

fn sides(told: &Told<'_>) -> Vec<Sides> {
    let paths: BTreeSet<BTreeSet<End>> = told.ends().into_iter().map(|end| line(told, end)).collect();
    paths.iter().map(|path| (path.iter().map(|end| end.0).collect(), sides_of(told, path))).collect()
}

fn sides_of(told: &Told<'_>, path: &BTreeSet<End>) -> [Evidence; 2] {
    let mut sides = [Evidence::new(), Evidence::new()];
    for ahead in path.first().map(|&least| one_way(told, least)).unwrap_or_default() {
        let (size, back) = (told.stars[ahead.0].size(), told.opposite(ahead));
        let clockwise = |slot: usize| (slot + size - ahead.1) % size;
        for slot in (0..size).map(|slot| (ahead.0, slot)).filter(|slot| *slot != ahead && *slot != back) {
            let right = usize::from(clockwise(slot.1) < clockwise(back.1));
            let least = line(told, slot).first().copied();
            let carried = onward(told, slot).into_iter();
            sides[right].extend(carried.filter_map(|place| least.map(|least| (place, least))));
        }
    }
    sides
}

/// All dstates of the path of one.
fn line(told: &Told<'_>, end: End) -> BTreeSet<End> {
    until_nothing_is_new(end, |end| vec![Some(told.opposite(end)), told.far_end(end)])
}

/// The dstates of the path of one that face the way it does.
fn one_way(told: &Told<'_>, end: End) -> BTreeSet<End> {
    until_nothing_is_new(end, |end| {
        let next = told.far_end(end).map(|far| told.opposite(far));
        vec![next, told.far_end(told.opposite(end))]
    })
}

fn until_nothing_is_new(start: End, on: impl Fn(End) -> Vec<Option<End>>) -> BTreeSet<End> {
    let mut known = BTreeSet::from([start]);
    loop {
        let more: BTreeSet<End> = known.iter().flat_map(|&end| on(end)).flatten().collect();
        if more.is_subset(&known) {
            return known;
        }
        known.extend(more);
    }
}

/// The places that a robot meets that travels on and on, until nothing is new.
fn onward(told: &Told<'_>, start: End) -> BTreeSet<usize> {
    let (mut passed, mut places, mut ahead) = (BTreeSet::new(), BTreeSet::new(), start);
    while passed.insert(ahead) {
        let Some(far) = told.far_end(ahead) else { break };
        places.insert(far.0);
        ahead = told.opposite(far);
    }
    places
}
