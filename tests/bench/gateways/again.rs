//! The stars of places that are seen again in recorded logs, and why they differ where they do.

use crate::aces;
use crate::maps;
use rayon::prelude::*;
use topostar::geometry::{Point, Pose, Vector, wrap_angle};
use topostar::sensor::LaserScan;
use topostar::star::{PerceptionParameters, PlaceDescription, Rejected, describe, rejected};
use topostar::visit::{VisitDetector, VisitParameters};

/// The local frame drifts by less than places are apart: nearer middles are of one place, metres.
const SAME_PLACE: f64 = 2.5;
/// Each log is laid on the raster so many times, turned by so much more, radians: one laying is one sample.
const LAYINGS: u32 = 6;
const TURNED: f64 = 0.7;
/// Middles further apart than this are not those of one reading, metres.
const APART: f64 = 1.0;
/// Gateways are one if they are that near, metres and radians.
const SAME_GATEWAY: [f64; 2] = [0.5, 0.9];

/// Why two stars of one place differ: the first of these that applies.
const CAUSES: [&str; 5] = [
    "an opening too narrow by itself, gone through on one of them",
    "an opening near the passage width",
    "middles more than 1 m apart",
    "a gateway where the other saw no opening",
    "labels, pairs or their order",
];

/// Stars are told apart by how sure they are of the gateways that they differ in.
const MARGINS: [f64; 3] = [0.05, 0.1, 0.2];

/// Why two stars differ, and the margin of what they differ in; of openings gone through and of labels it is not asked.
struct Difference {
    cause: usize,
    margin: f64,
}

/// What was seen on a visit.
struct Look {
    center: Point,
    robot: Pose,
    place: PlaceDescription,
    openings: Vec<Rejected>,
}

pub(super) fn print() {
    println!("\nplaces of recorded logs that are seen again, each log laid on the raster {LAYINGS} times");
    for name in ["aces", "mit-csail", "fr079"] {
        let scans = aces::scans(name);
        let turns: Vec<f64> = (0..LAYINGS).map(|k| f64::from(k) * TURNED).collect();
        let layings: Vec<Vec<Look>> = turns.par_iter().map(|&turn| looks(&scans, turn)).collect();
        let (mut causes, mut doubtful) = ([0; CAUSES.len()], [0; MARGINS.len()]);
        let (mut visits, mut alike, mut repeats) = (0, 0, 0);
        for laying in &layings {
            visits += laying.len();
            for [before, now] in pairs(laying) {
                repeats += 1;
                let Some(Difference { cause, margin }) = difference(&laying[before], &laying[now]) else {
                    alike += 1;
                    continue;
                };
                causes[cause] += 1;
                (0..MARGINS.len()).for_each(|k| doubtful[k] += usize::from(margin <= MARGINS[k]));
            }
        }
        println!(
            "{name}: {visits} visits, {repeats} of them again, {alike} of these with the star of the one before"
        );
        CAUSES.iter().zip(causes).for_each(|(cause, count)| println!("  {count:3} {cause}"));
        println!("  {doubtful:?} differ in gateways with margins of at most {MARGINS:?} alone");
        layings[0].iter().enumerate().for_each(|(k, look)| print_look(&format!("{name}-{k:02}"), look));
        for [before, now] in pairs(&layings[0]) {
            let why = difference(&layings[0][before], &layings[0][now]);
            let why = why.map_or("alike", |difference| CAUSES[difference.cause]);
            println!("    {before:2} and {now:2}: {why}");
        }
    }
}

fn looks(scans: &[LaserScan], turned: f64) -> Vec<Look> {
    let parameters = PerceptionParameters::default();
    let mut detector = VisitDetector::new(VisitParameters::default()).unwrap();
    let frame = Pose::new(0.0, 0.0, turned);
    let turn = |scan: &LaserScan| LaserScan {
        odom_from_robot: frame.compose(&scan.odom_from_robot),
        ..scan.clone()
    };
    let mut stages: Vec<_> = scans.iter().flat_map(|scan| detector.add(&turn(scan))).collect();
    stages.extend(detector.finish());
    let look = |visit: topostar::visit::Visit| {
        let place = describe(&visit.lpm, &parameters).unwrap();
        let openings = rejected(&visit.lpm, &place, &parameters);
        Look { center: visit.center, robot: visit.lpm.robot_pose, place, openings }
    };
    stages.into_iter().map(|stage| look(stage.visit)).collect()
}

/// Each visit to a place seen before, with the visit to it before.
fn pairs(looks: &[Look]) -> Vec<[usize; 2]> {
    let mut places: Vec<(Point, usize)> = Vec::new();
    let mut pairs = Vec::new();
    for (now, look) in looks.iter().enumerate() {
        match places.iter_mut().find(|(center, _)| (*center - look.center).norm() < SAME_PLACE) {
            Some((_, last)) => pairs.push([std::mem::replace(last, now), now]),
            None => places.push((look.center, now)),
        }
    }
    pairs
}

/// Why two stars differ; nothing if they do not.
fn difference(before: &Look, now: &Look) -> Option<Difference> {
    if !before.place.star.large_scale().alignments(&now.place.star.large_scale()).is_empty() {
        return None;
    }
    let passage_width = PerceptionParameters::default().skeleton.passage_width;
    let mut found: Vec<Difference> = Vec::new();
    for [one, other] in [[before, now], [now, before]] {
        // From the frame of one place to that of the other.
        let shift: Vector = one.center - other.center;
        for gateway in &one.place.gateways {
            let there = gateway.center + shift;
            let [near, turned] = SAME_GATEWAY;
            let known = other.place.gateways.iter().any(|known| {
                (known.center - there).norm() < near + known.width.max(gateway.width) / 2.0
                    && wrap_angle(known.bearing - gateway.bearing).abs() < turned
            });
            let narrow = |opening: &Rejected| (opening.center - there).norm() < near + gateway.width / 2.0;
            if known {
                continue;
            }
            let opening = other.openings.iter().find(|opening| narrow(opening));
            let margin = gateway.margin.min(opening.map_or(f64::INFINITY, |opening| opening.margin));
            found.push(match opening {
                _ if gateway.passage < passage_width => Difference { cause: 0, margin: f64::INFINITY },
                Some(_) => Difference { cause: 1, margin },
                None if shift.norm() > APART => Difference { cause: 2, margin },
                None => Difference { cause: 3, margin },
            });
        }
    }
    let margin = found.iter().map(|one| one.margin).reduce(f64::max).unwrap_or(f64::INFINITY);
    let cause = found.iter().map(|one| one.cause).min().unwrap_or(CAUSES.len() - 1);
    Some(Difference { cause, margin })
}

fn print_look(name: &str, look: &Look) {
    let star = &look.place.star;
    let slot = |index| {
        let slot = star.slot(index).unwrap();
        let degrees = slot.bearing.unwrap_or(f64::NAN).to_degrees();
        let gateway = slot.outward.map(|id| &look.place.gateways[id.0 as usize - 1]);
        let sizes = gateway.map_or(String::new(), |one| format!(" {:.2} m", one.passage));
        let way = if slot.outward.is_some() { "" } else { "-" };
        let margin = slot.margin.unwrap_or(f64::NAN);
        format!("{way}{:?} {degrees:.0}{sizes} ({margin:.2})", slot.control)
    };
    let slots: Vec<String> = star.indices().map(slot).collect();
    println!("  {name} at {:.1},{:.1}  {}", look.center.x, look.center.y, slots.join(", "));
    maps::draw(&look.place, &look.robot, name);
}
