//! The slow reference: all assignments of observations to places, each checked from the definitions alone.
//!
//! Nothing here is clever, incremental or shared with the engine. A story takes each observation for a place and
//! a rotation; a law is a question about a whole story.

use std::collections::BTreeSet;
use topostar::abduction::Visit;
use topostar::star::LargeScaleStar;

/// For each observation its place and rotation.
pub(crate) type Story = Vec<(usize, usize)>;

/// A place and a slot of the star of its first visit.
pub(crate) type End = (usize, usize);

pub(crate) const PAPER: [&str; 4] = ["determinism", "star-match", "travel-moves", "path-order"];
pub(crate) const DEFAULT: [&str; 5] =
    ["determinism", "star-match", "travel-moves", "path-order", "planarity"];

/// All stories under which the laws hold, in lexicographic order. With `prune`, stories whose beginning breaks a
/// law are not followed; the laws are monotone, so that the answer is the same.
pub(crate) fn explanations(visits: &[Visit], laws: &[&str], prune: bool) -> Vec<Story> {
    let mut found = Vec::new();
    if !visits.is_empty() {
        follow(visits, laws, prune, &mut vec![(0, 0)], &mut found);
    }
    found
}

fn follow(visits: &[Visit], laws: &[&str], prune: bool, story: &mut Story, found: &mut Vec<Story>) {
    let whole = story.len() == visits.len();
    if (whole || prune) && !obeys_all(&visits[..story.len()], story, laws) {
        return;
    }
    if whole {
        return found.push(story.clone());
    }
    let known = place_count(story);
    let rotations = visits[story.len()].star.size();
    let old = (0..known).flat_map(|place| (0..rotations).map(move |rotation| (place, rotation)));
    for step in old.chain([(known, 0)]) {
        story.push(step);
        follow(visits, laws, prune, story, found);
        story.pop();
    }
}

fn obeys_all(visits: &[Visit], story: &Story, laws: &[&str]) -> bool {
    // Slots of a story mean something only where stars match, and far ends only where there is one.
    let first = ["star-match", "determinism"];
    first.iter().chain(laws).all(|law| obeys(visits, story, law))
}

/// Whether a story obeys a law.
pub(crate) fn obeys(visits: &[Visit], story: &Story, law: &str) -> bool {
    match law {
        "determinism" => determinism(visits, story),
        "star-match" => star_match(visits, story),
        "travel-moves" => travels(visits, story).iter().all(|(from, to)| from.0 != to.0),
        "path-order" => path_order(visits, story),
        "planarity" => planarity(visits, story),
        "boundary" => boundary(visits, story),
        law => panic!("the reference does not know the law {law}"),
    }
}

/// Every travel and every travel back: equal gateways have equal far ends, and not themselves.
fn determinism(visits: &[Visit], story: &Story) -> bool {
    let there_and_back: Vec<(End, End)> =
        travels(visits, story).into_iter().flat_map(|(a, b)| [(a, b), (b, a)]).collect();
    there_and_back.iter().all(|x| x.0 != x.1)
        && there_and_back.iter().all(|x| there_and_back.iter().all(|y| x.0 != y.0 || x.1 == y.1))
}

/// Every observation: each of its slots is the slot that far on of its place's star.
fn star_match(visits: &[Visit], story: &Story) -> bool {
    visits.iter().zip(story).all(|(visit, &(place, rotation))| {
        let (own, seen) = (star_of(visits, story, place).slots(), visit.star.slots());
        let on = |slot: usize| (slot + rotation) % seen.len();
        own.len() == seen.len()
            && (0..seen.len()).all(|slot| {
                own[on(slot)].control == seen[slot].control
                    && own[on(slot)].navigable == seen[slot].navigable
                    && own[on(slot)].opposite.0 as usize == on(seen[slot].opposite.0 as usize)
            })
    })
}

/// Walking on from any dstate, no place comes twice.
fn path_order(visits: &[Visit], story: &Story) -> bool {
    all_ends(visits, story).into_iter().all(|start| {
        let mut passed = vec![start.0];
        let mut ahead = start;
        while let Some(far) = far_end(visits, story, ahead) {
            if passed.contains(&far.0) {
                return false;
            }
            passed.push(far.0);
            ahead = opposite(visits, story, far);
        }
        true
    })
}

/// Euler: places, path segments and faces of the connected map.
fn planarity(visits: &[Visit], story: &Story) -> bool {
    let segments = segments(visits, story);
    let mut unseen: BTreeSet<End> = segments.iter().flat_map(|&(a, b)| [a, b]).collect();
    let used = unseen.clone();
    let mut faces = usize::from(used.is_empty());
    while let Some(&start) = unseen.first() {
        faces += 1;
        let mut at = start;
        while unseen.remove(&at) {
            at = far_end(visits, story, at).unwrap();
            let size = star_of(visits, story, at.0).size();
            at.1 = (at.1 + 1) % size;
            while !used.contains(&at) {
                at.1 = (at.1 + 1) % size;
            }
        }
    }
    place_count(story) + faces == segments.len() + 2
}

/// Whoever walks along a path and sees others leave it to the left and to the right never sees a place ahead on
/// two of left, right and the path itself.
fn boundary(visits: &[Visit], story: &Story) -> bool {
    beside(visits, story).iter().all(|(on, sides)| {
        let [left, right] = sides.each_ref().map(|side| side.iter().map(|it| it.0).collect::<BTreeSet<_>>());
        left.is_disjoint(&right) && left.is_disjoint(on) && right.is_disjoint(on)
    })
}

/// The fewest pairs of paths to be exempt, so that the other evidence agrees: of each path all sets of paths that
/// carry evidence about it, the small ones first.
pub(crate) fn abnormalities(visits: &[Visit], story: &Story) -> usize {
    let exempt = |(on, sides): &(BTreeSet<usize>, [Evidence; 2])| {
        let carriers: Vec<End> =
            sides.iter().flatten().map(|it| it.1).collect::<BTreeSet<_>>().into_iter().collect();
        let agrees = |exempt: u32| {
            let kept = |it: &&(usize, End)| {
                let carrier = carriers.iter().position(|carrier| *carrier == it.1).unwrap();
                exempt & (1 << carrier) == 0
            };
            let [left, right] =
                sides.each_ref().map(|side| side.iter().filter(kept).map(|it| it.0).collect::<BTreeSet<_>>());
            left.is_disjoint(&right) && left.is_disjoint(on) && right.is_disjoint(on)
        };
        (0..1u32 << carriers.len()).filter(|&set| agrees(set)).map(u32::count_ones).min().unwrap() as usize
    };
    beside(visits, story).iter().map(exempt).sum()
}

/// Places beside a path, and the least dstate of the path that leads to them.
pub(crate) type Evidence = BTreeSet<(usize, End)>;

/// For each path the places on it, and those left and right of it.
pub(crate) fn beside(visits: &[Visit], story: &Story) -> Vec<(BTreeSet<usize>, [Evidence; 2])> {
    let ends = all_ends(visits, story);
    let lines: Vec<BTreeSet<End>> = ends.iter().map(|&end| line(visits, story, end)).collect();
    let line_of = |end: End| &lines[ends.iter().position(|own| *own == end).unwrap()];
    let distinct: BTreeSet<&BTreeSet<End>> = lines.iter().collect();
    let sides_of = |path: &BTreeSet<End>| {
        let mut sides = [Evidence::new(), Evidence::new()];
        // In the direction of its least dstate.
        for ahead in one_way(visits, story, *path.first().unwrap()) {
            let (size, back) = (star_of(visits, story, ahead.0).size(), opposite(visits, story, ahead));
            let clockwise = |slot: usize| (slot + size - ahead.1) % size;
            for slot in (0..size).map(|slot| (ahead.0, slot)).filter(|slot| *slot != ahead && *slot != back) {
                let right = usize::from(clockwise(slot.1) < clockwise(back.1));
                let name = *line_of(slot).first().unwrap();
                sides[right].extend(onward(visits, story, slot).into_iter().map(|place| (place, name)));
            }
        }
        (path.iter().map(|end| end.0).collect(), sides)
    };
    distinct.into_iter().map(sides_of).collect()
}

/// All dstates of the path of one.
fn line(visits: &[Visit], story: &Story, end: End) -> BTreeSet<End> {
    let mut line = BTreeSet::from([end]);
    loop {
        let on = line.iter().flat_map(|&end| {
            [Some(opposite(visits, story, end)), far_end(visits, story, end)].into_iter().flatten()
        });
        let more: BTreeSet<End> = on.chain(line.iter().copied()).collect();
        if more == line {
            return line;
        }
        line = more;
    }
}

/// The dstates of the path of one that face the way it does.
fn one_way(visits: &[Visit], story: &Story, end: End) -> BTreeSet<End> {
    let mut way = BTreeSet::from([end]);
    loop {
        let next = |&end: &End| far_end(visits, story, end).map(|far| opposite(visits, story, far));
        let last = |&end: &End| far_end(visits, story, opposite(visits, story, end));
        let more: BTreeSet<End> =
            way.iter().flat_map(|end| [Some(*end), next(end), last(end)].into_iter().flatten()).collect();
        if more == way {
            return way;
        }
        way = more;
    }
}

/// The places that a robot meets that travels on and on, until nothing is new.
fn onward(visits: &[Visit], story: &Story, start: End) -> BTreeSet<usize> {
    let (mut passed, mut ahead) = (BTreeSet::new(), start);
    let mut places = BTreeSet::new();
    while passed.insert(ahead) {
        let Some(far) = far_end(visits, story, ahead) else { break };
        places.insert(far.0);
        ahead = opposite(visits, story, far);
    }
    places
}

/// The number of paths, travelled or not, and of places.
pub(crate) fn size(visits: &[Visit], story: &Story) -> (usize, usize) {
    // Each dstate its own label; dstates of one path take the least, until nothing changes.
    let ends = all_ends(visits, story);
    let mut labels: Vec<usize> = (0..ends.len()).collect();
    let label_of = |end: End| ends.iter().position(|own| *own == end).unwrap();
    let mut joined: Vec<(End, End)> = ends.iter().map(|&end| (end, opposite(visits, story, end))).collect();
    joined.extend(segments(visits, story));
    let joined: Vec<(usize, usize)> = joined.into_iter().map(|(a, b)| (label_of(a), label_of(b))).collect();
    loop {
        let before = labels.clone();
        for &(a, b) in &joined {
            let least = labels[a].min(labels[b]);
            (labels[a], labels[b]) = (least, least);
        }
        if labels == before {
            return (labels.into_iter().collect::<BTreeSet<_>>().len(), place_count(story));
        }
    }
}

/// The simplest of some stories, all that are equally simple; with `soft` boundaries those of the fewest
/// abnormalities first.
pub(crate) fn minimal(visits: &[Visit], stories: &[Story], soft: bool) -> Vec<Story> {
    let simplicity = |story: &Story| (soft.then(|| abnormalities(visits, story)), size(visits, story));
    let least = stories.iter().map(simplicity).min();
    stories.iter().filter(|story| Some(simplicity(story)) == least).cloned().collect()
}

/// The path segments: each travelled pair of gateways once, the lower one first.
pub(crate) fn segments(visits: &[Visit], story: &Story) -> BTreeSet<(End, End)> {
    travels(visits, story).into_iter().map(|(a, b)| (a.min(b), a.max(b))).collect()
}

/// For each observation but the first, the gateway left by and the gateway arrived at, both outward.
fn travels(visits: &[Visit], story: &Story) -> Vec<(End, End)> {
    (1..story.len())
        .map(|k| {
            let (before, now) = (&visits[k - 1], &visits[k]);
            let left = now.departure.unwrap().0 as usize;
            let passed = now.star.slots()[now.arrival.0 as usize].opposite.0 as usize;
            let from = (story[k - 1].0, (left + story[k - 1].1) % before.star.size());
            (from, (story[k].0, (passed + story[k].1) % now.star.size()))
        })
        .collect()
}

fn far_end(visits: &[Visit], story: &Story, end: End) -> Option<End> {
    let there_and_back = travels(visits, story).into_iter().flat_map(|(a, b)| [(a, b), (b, a)]);
    there_and_back.into_iter().find(|(from, _)| *from == end).map(|(_, to)| to)
}

fn star_of<'a>(visits: &'a [Visit], story: &Story, place: usize) -> &'a LargeScaleStar {
    &visits[story.iter().position(|visit| visit.0 == place).unwrap()].star
}

fn opposite(visits: &[Visit], story: &Story, end: End) -> End {
    (end.0, star_of(visits, story, end.0).slots()[end.1].opposite.0 as usize)
}

fn all_ends(visits: &[Visit], story: &Story) -> Vec<End> {
    let slots = |place| (0..star_of(visits, story, place).size()).map(move |slot| (place, slot));
    (0..place_count(story)).flat_map(slots).collect()
}

fn place_count(story: &Story) -> usize {
    story.iter().map(|visit| visit.0 + 1).max().unwrap_or(0)
}
