//! The profile of chi-square by which `apart` judges, against its slow reference, number by number.

use crate::clingo::{on_random, on_the_same};
use crate::engine::story;
use crate::floor_reference::obstacles;
use crate::layout_reference::{Estimate, SHARES, pairs_of_places};
use crate::measured::sightings;
use crate::measured_reference::{POLYGON, Told};
use crate::profile_reference::{Profile as Slow, Rise};
use crate::reference::Story;
use proptest::prelude::*;
use std::cell::Cell;
use std::sync::Mutex;
use topostar::abduction::{
    Abduction, Assignment, AxiomId, AxiomSet, Clash, Evidence, Limits, Profile, Proposal, Visit, judge,
};
use topostar::map::PlaceId;
use topostar::metric::{Measurements, Patience, Room};
use topostar::trace::Sighting;
use topostar::worlds::{Drift, corridor_grid, covering_walk, drifting_trace};

/// A walk through a grid, what a candidate takes its visits for, two of these, and a range of shares.
#[derive(Clone, Debug)]
struct Case {
    seen: Vec<Sighting>,
    story: Story,
    /// Which two of its visits that lie near to each other, of as many as there are.
    which: usize,
    share: usize,
    /// How much more chi-square the distance takes to first order.
    about: f64,
}

/// What a case is made of.
#[derive(Clone, Debug)]
struct Drawn {
    seed: u64,
    grid: (usize, usize, f64),
    drift: Drift,
    travels: usize,
    /// Whether candidates are those under the axioms of measurements, too.
    measured: bool,
    /// Which candidate, of as many as there are.
    story: usize,
    which: usize,
    share: usize,
    about: f64,
}

/// Of all candidates at the end of a random walk, under the axioms of symbols alone or of measurements too, one. Its
/// odometry may drift as badly as the worst, alike on all metres, or anew on each.
fn drawn() -> impl Strategy<Value = Drawn> {
    let Drift { heading_bias, heading_noise, .. } = Drift::WORST;
    let drift = prop_oneof![
        Just(Drift::WORST),
        Just(Drift::WORST.scaled(0.2)),
        Just(Drift { heading_noise: 0.0, heading_bias: 2.0 * heading_bias, ..Drift::WORST }),
        Just(Drift { heading_bias: 0.0, heading_noise: 1.5 * heading_noise, ..Drift::WORST }),
    ];
    let grid = (2usize..4, 2usize..5, 4.0..14.0);
    let pick = (any::<[u16; 2]>(), 0..SHARES.len(), 3.0..60.0);
    (any::<u64>(), grid, drift, 4usize..18, any::<bool>(), pick).prop_map(
        |(seed, grid, drift, travels, measured, (which, share, about))| {
            let [story, which] = which.map(usize::from);
            Drawn { seed, grid, drift, travels, measured, story, which, share, about }
        },
    )
}

fn cases() -> impl Strategy<Value = Case> {
    drawn().prop_map(|drawn| drawn.case())
}

impl Drawn {
    fn case(&self) -> Case {
        let Drawn { seed, grid: (rows, columns, spacing), drift, which, share, about, .. } = *self;
        let places = corridor_grid(rows, columns, spacing);
        let mut walk = covering_walk(&places, seed);
        walk.leave.truncate(self.travels);
        let mut seen = sightings(&drifting_trace(&places, &walk, drift, seed).unwrap().events);
        let motions = seen.iter_mut().filter_map(|sighting| sighting.motion.as_mut());
        motions.for_each(|motion| motion.start_given = seed % 3 != 0);
        let default = AxiomSet::of(Profile::Default);
        let axioms = if self.measured { default } else { default.without_measured() };
        let story = candidate(&seen, axioms, self.story);
        seen.truncate(story.len());
        Case { seen, story, which, share, about }
    }
}

/// How near to each other two visits lie of which it is asked, metres.
const NEAR: f64 = 5.0;

/// One of the candidates at the end of a walk, of which a search keeps no more than a hundred.
fn candidate(seen: &[Sighting], axioms: AxiomSet, which: usize) -> Story {
    let mut measured = Measurements::default();
    let mut found = Abduction::new(axioms, Limits { max_candidates: Some(100), ..Limits::default() });
    for sighting in seen {
        measured = measured.with(sighting);
        found.observe_measured(&Visit::from(sighting), measured.evidence()).unwrap();
    }
    let candidates: Vec<Story> = found.candidates().map(|candidate| story(&candidate)).collect();
    match candidates.len() {
        0 => candidate(&seen[..seen.len() - 1], axioms, which),
        many => candidates[which % many].clone(),
    }
}

/// What measurements say of two visits and a gate, or of all places, when it comes to the last observation of a story.
#[derive(Debug)]
struct Asking {
    measured: Measurements,
    visits: Option<([usize; 2], f64)>,
    distance: f64,
    patience: Patience,
    last: usize,
    /// By range of shares, of two visits and of all.
    parted: Mutex<Vec<Option<f64>>>,
    rooms: Mutex<Vec<Option<Room>>>,
}

impl Evidence for Asking {
    fn holds(&self, axiom: AxiomId, proposal: &Proposal<'_>) -> bool {
        if axiom == AxiomId::Apart && proposal.branch.visits().len() == self.last {
            match self.visits {
                Some((visits, gate)) => {
                    *self.parted.lock().unwrap() =
                        self.measured.to_part(proposal, visits, self.distance, gate);
                }
                None => {
                    let room = |range| self.measured.room(proposal, range, self.distance, self.patience);
                    *self.rooms.lock().unwrap() = (0..Measurements::RANGES).map(room).collect();
                }
            }
        }
        true
    }

    fn clash(&self, _: AxiomId, _: &Proposal<'_>) -> Clash {
        Clash::default()
    }
}

impl Case {
    /// What the engine says of two visits and a gate.
    fn parted(&self, visits: [usize; 2], gate: f64, distance: f64) -> Option<f64> {
        let asking = self.asked(Some((visits, gate)), distance, Patience::Short);
        asking.parted.into_inner().unwrap()[self.share]
    }

    /// What the engine says of all places.
    fn room(&self, distance: f64, patience: Patience) -> Option<Room> {
        self.asked(None, distance, patience).rooms.into_inner().unwrap().swap_remove(self.share)
    }

    /// What it says that it takes to have all places apart, if that is lacking.
    fn lacking(&self, distance: f64, patience: Patience) -> Option<f64> {
        match self.room(distance, patience)? {
            Room::Lacking(crowd) => Some(crowd.chi_square),
            Room::Found(_) | Room::Unknown => None,
        }
    }

    fn asked(&self, visits: Option<([usize; 2], f64)>, distance: f64, patience: Patience) -> Asking {
        let measured = self.seen.iter().fold(Measurements::default(), |measured, seen| measured.with(seen));
        let last = self.story.len() - 1;
        let (parted, rooms) = (Mutex::default(), Mutex::default());
        let asking = Asking { measured, visits, distance, patience, last, parted, rooms };
        let told: Vec<Assignment> = self.story.iter().map(assignment).collect();
        let seen: Vec<Visit> = self.seen.iter().map(Visit::from).collect();
        judge(&seen, Some(&asking), AxiomSet::built_in().with(AxiomId::Apart), &told).unwrap();
        asking
    }

    /// Compares both, where likely errors close the loops.
    fn compare(&self) -> Option<Compared> {
        let told = Told::new(&self.seen, &self.story);
        let estimate = self.estimate(&told);
        let (ends, distance) = self.question(&estimate)?;
        let slow = Slow::new(&estimate, &[(ends[0], ends[1])], Vec::new());
        let [inside, rim] = [distance * POLYGON, distance].map(|distance| slow.rise(distance));
        let below = inside.and_then(|rise| self.parted(ends, 0.999 * rise.by - REST, distance));
        let above = rim.and_then(|rise| self.parted(ends, 1.001 * rise.by + REST, distance));
        Some(Compared { inside, rim, below, above })
    }

    fn estimate<'a>(&self, told: &'a Told<'a>) -> Estimate<'a> {
        let assigned = if told.is_new() { told.latest() } else { told.latest() + 1 };
        Estimate::new(told, assigned, SHARES[self.share])
    }

    /// Two visits near to each other, and a distance that it takes a chi-square of about so much to have them apart, where
    /// likely errors close the loops.
    fn question(&self, estimate: &Estimate<'_>) -> Option<([usize; 2], f64)> {
        if !estimate.agrees() {
            return None;
        }
        let all = (1..self.story.len()).flat_map(|to| (0..to).map(move |from| [from, to]));
        let near: Vec<[usize; 2]> =
            all.filter(|&[from, to]| estimate.pose(from, to).0.xy().norm() < NEAR).collect();
        let [from, to] = *near.get(self.which % near.len().max(1))?;
        let (at, covariance) = estimate.pose(from, to);
        let longest = covariance.fixed_view::<2, 2>(0, 0).symmetric_eigenvalues().max().sqrt();
        let distance = at.xy().norm() + self.about.sqrt() * longest;
        (distance <= 2.0 * NEAR).then_some(([from, to], distance))
    }
}

/// What it takes to come to the circle within the engine's polygon and to that around it, by the reference; and what the
/// engine says of a gate just below the one and of a gate just above the other.
#[derive(Debug)]
struct Compared {
    inside: Option<Rise>,
    rim: Option<Rise>,
    below: Option<f64>,
    above: Option<f64>,
}

/// What chi-square may still change by, where either comes to rest.
const REST: f64 = 0.02;

impl Compared {
    fn agrees(&self) -> bool {
        let least = self.inside.map_or(0.0, |rise| 0.999 * rise.by - REST);
        let most = self.rim.map_or(f64::INFINITY, |rise| 1.001 * rise.by + REST);
        self.above.is_none() && self.below.is_none_or(|below| (least..=most).contains(&below))
    }
}

fn assignment(&(place, rotation): &(usize, usize)) -> Assignment {
    Assignment { place: PlaceId::new(place).unwrap(), rotation: rotation as u8 }
}

/// The engine says that it takes more than a gate wherever the reference finds so, for gates up to a thousandth less,
/// and nowhere that the reference finds errors within the gate with which the two visits are apart.
#[test]
fn the_profile_of_chi_square_is_that_of_its_reference() {
    let (asked, found, known) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let count = |cell: &Cell<u32>, more: bool| cell.set(cell.get() + u32::from(more));
    on_random(256, cases(), |case| {
        let Some(compared) = case.compare() else { return Ok(()) };
        let Compared { inside, rim, below, .. } = &compared;
        count(&asked, true);
        count(&found, inside.is_some_and(|rise| rise.rests) && rim.is_some_and(|rise| rise.rests));
        count(&known, below.is_some());
        prop_assert!(compared.agrees(), "{compared:?}");
        Ok(())
    });
    let [asked, found, known] = [asked, found, known].map(|cell| cell.get());
    assert!(asked > 64 && 10 * found > 9 * asked && 10 * known > 9 * asked, "{asked} {found} {known}");
}

/// Where loops gape as far as a place is wide and headings are off, what either end of one adds is not to be swung by the
/// other: then chi-square was 0.1 and 0.2 above the least there is.
#[test]
fn loops_that_gape_take_what_they_take() {
    let Drift { heading_bias, .. } = Drift::WORST;
    let found = [
        Drawn {
            seed: 16963624151818772578,
            grid: (3, 3, 8.959545005639324),
            drift: Drift::WORST.scaled(0.2),
            travels: 9,
            measured: false,
            story: 45817,
            which: 42133,
            share: 0,
            about: 37.68848017454962,
        },
        Drawn {
            seed: 4956358172191040882,
            grid: (3, 2, 6.1675057940892035),
            drift: Drift { heading_noise: 0.0, heading_bias: 2.0 * heading_bias, ..Drift::WORST },
            travels: 5,
            measured: false,
            story: 21715,
            which: 56404,
            share: 3,
            about: 46.318931170526334,
        },
    ];
    for drawn in found {
        let compared = drawn.case().compare().unwrap();
        assert!(compared.agrees() && compared.below.is_some(), "{drawn:?} {compared:?}");
    }
}

/// Whatever the engine says that it takes to have all places apart, the reference finds no errors that take less. It finds
/// some often enough: where places are crowded its steps may come to rest with two of them too near. How often is counted,
/// so that the walks are always the same.
#[test]
fn to_have_all_places_apart_takes_what_the_reference_finds() {
    let (crowded, known) = (Cell::new(0), Cell::new(0));
    on_the_same(192, cases(), |case| {
        let told = Told::new(&case.seen, &case.story);
        let estimate = case.estimate(&told);
        if !estimate.agrees() {
            return Ok(());
        }
        let distance = 2.0 + case.about / 12.0;
        let claims = [Patience::Short, Patience::Long].map(|patience| case.lacking(distance, patience));
        let Some(claimed) = claims.into_iter().flatten().reduce(f64::max) else { return Ok(()) };
        let rise = Slow::new(&estimate, &pairs_of_places(&told), obstacles(&told, distance)).rise(distance);
        crowded.set(crowded.get() + 1);
        known.set(known.get() + u32::from(rise.is_some()));
        prop_assert!(rise.is_none_or(|rise| claimed <= 1.001 * rise.by + REST), "{claimed} {rise:?}");
        Ok(())
    });
    let [crowded, known] = [crowded, known].map(|cell| cell.get());
    println!("{crowded} crowded, {known} of them known");
    assert!(crowded > 16 && 3 * known > crowded, "{crowded} {known}");
}

/// Where the engine says that errors are found with which all places lie apart, they do by the frames that it shows, and
/// errors that lead to these take what it says that they take, by all the reference knows of errors and of no derivatives.
#[test]
fn all_places_lie_apart_where_room_is_found() {
    let (found, moved) = (Cell::new(0), Cell::new(0));
    on_the_same(384, cases(), |case| {
        let told = Told::new(&case.seen, &case.story);
        let estimate = case.estimate(&told);
        let distance = 2.0 + case.about / 12.0;
        let pairs = pairs_of_places(&told);
        for patience in [Patience::Short, Patience::Long] {
            let Some(Room::Found(witness)) = case.room(distance, patience) else { continue };
            let at = |visit: usize| witness.poses[visit].position();
            let least =
                pairs.iter().map(|&(from, to)| (at(to) - at(from)).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(least >= distance * TWELVE - 0.01, "{least} {distance}");
            let obstacles = obstacles(&told, distance);
            let lacks = obstacles.iter().map(|one| one.lacks(&witness.poses)).fold(0.0, f64::max);
            prop_assert!(lacks < 0.02, "{lacks}");
            let bounds = 2 * (pairs.len() + obstacles.len());
            let takes = Slow::new(&estimate, &pairs, obstacles).takes(&witness.poses);
            prop_assert!((takes - witness.chi_square).abs() < REST, "{takes} {witness:?}");
            // No more sides bear than errors can be moved by.
            let gate = estimate.left(bounds.max(2).min(3 * told.latest() + 3));
            prop_assert!(takes <= witness.gate + REST && witness.gate <= gate, "{takes} {gate} {witness:?}");
            found.set(found.get() + 1);
            moved.set(moved.get() + u32::from(takes > 1.0));
        }
        Ok(())
    });
    let [found, moved] = [found, moved].map(|cell| cell.get());
    println!("{found} found, in {moved} of them by moving places");
    assert!(moved > 32, "{found} {moved}");
}

/// How near the sides of a regular polygon of 12 corners come to its middle, seen from which a corner is at one.
const TWELVE: f64 = 0.965_925_826_289_068_3;

/// What was seen before a travel that was not measured bears on no place behind it: the answer is that of a walk which only
/// begins there, but for rounding.
#[test]
fn places_before_a_travel_without_odometry_are_in_nobodys_way() {
    let (compared, crowded) = (Cell::new(0), Cell::new(0));
    on_the_same(256, cases(), |mut case| {
        let once = case.story.iter().filter(|visit| visit.0 == 0).count() == 1;
        if !once || case.story.len() < 3 {
            return Ok(());
        }
        case.seen[1].motion = None;
        let mut tail = case.clone();
        tail.seen.remove(0);
        tail.seen[0].departure = None;
        tail.story = case.story[1..].iter().map(|&(place, rotation)| (place - 1, rotation)).collect();
        let distance = 2.0 + case.about / 12.0;
        let [whole, tail] = [&case, &tail].map(|case| case.lacking(distance, Patience::Short));
        let same = match (whole, tail) {
            (Some(whole), Some(tail)) => (whole - tail).abs() < 1e-9 * whole,
            _ => whole == tail,
        };
        prop_assert!(same, "{whole:?} {tail:?}");
        compared.set(compared.get() + 1);
        crowded.set(crowded.get() + u32::from(whole.is_some()));
        Ok(())
    });
    let [compared, crowded] = [compared, crowded].map(|cell| cell.get());
    println!("{crowded} of {compared} crowded");
    assert!(crowded > 4, "{crowded} of {compared}");
}
