//! The stars of places that are seen again in recorded logs, visit by visit.

use crate::aces;
use crate::maps;
use topostar::geometry::Point;
use topostar::star::{PerceptionParameters, PlaceDescription, Rejected, describe, rejected};
use topostar::visit::{Stage, Visit, VisitDetector, VisitParameters};

/// The frame of scan matching drifts by less than places are apart: nearer middles are of one place, metres.
const SAME_PLACE: f64 = 2.5;

pub(super) fn print() {
    println!("\nplaces of recorded logs that are seen again");
    for name in ["aces", "mit-csail", "fr079"] {
        print_log(name);
    }
}

fn print_log(name: &str) {
    let mut detector = VisitDetector::new(VisitParameters::default()).unwrap();
    let mut stages: Vec<Stage> = aces::scans(name).iter().flat_map(|scan| detector.add(scan)).collect();
    stages.extend(detector.finish());
    let mut places: Vec<(Point, Vec<usize>)> = Vec::new();
    for (k, stage) in stages.iter().enumerate() {
        let center = stage.visit.center;
        match places.iter_mut().find(|(other, _)| (*other - center).norm() < SAME_PLACE) {
            Some((_, visits)) => visits.push(k),
            None => places.push((center, vec![k])),
        }
    }
    let parameters = PerceptionParameters::default();
    let read: Vec<PlaceDescription> =
        stages.iter().map(|stage| describe(&stage.visit.lpm, &parameters).unwrap()).collect();
    let alike = |visits: &[usize]| {
        let star = |k: usize| read[k].star.large_scale();
        visits.iter().all(|&k| !star(visits[0]).alignments(&star(k)).is_empty())
    };
    if std::env::var_os("PERC_ALL").is_some() {
        for (k, stage) in stages.iter().enumerate() {
            let Visit { center, arrival, departure, .. } = &stage.visit;
            println!(
                "VISIT {name} {k} {:.3} {:.3} scans {}..{} driven {:.1}..{:.1} {}",
                center.x,
                center.y,
                arrival.scan,
                departure.scan,
                arrival.driven,
                departure.driven,
                words(&read[k], &[])
            );
        }
    }
    let again: Vec<&(Point, Vec<usize>)> = places.iter().filter(|(_, visits)| visits.len() > 1).collect();
    let same = again.iter().filter(|(_, visits)| alike(visits)).count();
    println!(
        "{name}: {} visits, {} places, {} seen again, {same} alike",
        stages.len(),
        places.len(),
        again.len()
    );
    for (_, visits) in again {
        println!("  {}", if alike(visits) { "alike" } else { "UNLIKE" });
        for &k in visits {
            let visit = &stages[k].visit;
            let openings = rejected(&visit.lpm, &read[k], &parameters);
            println!(
                "    {k:2} at {:.2},{:.2} {}",
                visit.center.x,
                visit.center.y,
                words(&read[k], &openings)
            );
            maps::draw(&read[k], &visit.lpm.robot_pose, &format!("{name}-{k:02}"));
        }
    }
}

fn words(place: &PlaceDescription, rejected: &[Rejected]) -> String {
    let star = &place.star;
    let slot = |index| {
        let slot = star.slot(index).unwrap();
        let degrees = slot.bearing.unwrap_or(f64::NAN).to_degrees();
        let gateway = slot.outward.map(|id| &place.gateways[id.0 as usize - 1]);
        let sizes = gateway.map_or(String::new(), |one| {
            format!(
                " w{:.2} p{:.2} m{:.2} @{:.1},{:.1}",
                one.width, one.passage, one.margin, one.center.x, one.center.y
            )
        });
        let way = if slot.outward.is_some() { "" } else { "-" };
        let margin = slot.margin.unwrap_or(f64::NAN);
        format!("[{way}{:?} {degrees:.0} >{} ({margin:.2}){sizes}]", slot.control, star.opposite(index).0)
    };
    let slots: Vec<String> = star.indices().map(slot).collect();
    let opening = |one: &Rejected| format!("({:.2} at {:.1},{:.1})", one.passage, one.center.x, one.center.y);
    let openings: Vec<String> = rejected.iter().map(opening).collect();
    let (x, y) = (place.center.x, place.center.y);
    format!("c {x:.2},{y:.2} r{:.2} {} rejected {}", place.clearance, slots.join(" "), openings.join(" "))
}
