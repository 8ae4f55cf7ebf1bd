//! Visits found on simulated drives: every place the robot comes to, once each time, and nothing else.

use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;
use topostar::geometry::{Point, Pose, wrap_angle};
use topostar::sensor::{LaserScan, LocalPose, MatchingParameters, ScanMatcher};
use topostar::star::{LargeScaleStar, PerceptionParameters, describe};
use topostar::visit::drift::{chi_square, covariance};
use topostar::visit::{Moment, Stage, Visit, VisitDetector, VisitParameters};
use topostar::worlds::drawing::Drawing;
use topostar::worlds::{Explorer, drive};

/// Corridors of 2 m between crossings 14 m apart, on the lines of a grid.
const SPACING: f64 = 14.0;

fn crossing(column: usize, row: usize) -> Point {
    Point::new(column as f64 * SPACING, row as f64 * SPACING)
}

fn corridors(columns: usize, rows: usize) -> Drawing {
    let at = |(column, row): (usize, usize)| (column as f64 * SPACING, row as f64 * SPACING);
    let across = (0..rows).map(|row| (at((0, row)), at((columns - 1, row))));
    let along = (0..columns).map(|column| (at((column, 0)), at((column, rows - 1))));
    // The ends of corridors are square, so that corners are filled by making them longer by their half width.
    let longer = |(from, to): ((f64, f64), (f64, f64))| {
        let (dx, dy) = ((to.0 - from.0).signum(), (to.1 - from.1).signum());
        let (dx, dy) = if from.0 == to.0 { (0.0, dy) } else { (dx, 0.0) };
        ((from.0 - dx, from.1 - dy), (to.0 + dx, to.1 + dy))
    };
    across.chain(along).map(longer).fold(Drawing::new(), |plan, (from, to)| plan.corridor(from, to, 2.0))
}

/// A walk between neighbouring crossings that does not turn back.
fn walk(columns: usize, rows: usize, choices: &[u8]) -> Vec<Point> {
    let mut way: Vec<(usize, usize)> = vec![(0, 0), (1, 0)];
    for &choice in choices {
        let (here, before) = (way[way.len() - 1], way[way.len() - 2]);
        let next: Vec<(usize, usize)> = [(1, 0), (0, 1), (-1, 0), (0, -1)]
            .into_iter()
            .filter_map(|(dx, dy)| Some((here.0.checked_add_signed(dx)?, here.1.checked_add_signed(dy)?)))
            .filter(|&(column, row)| column < columns && row < rows && (column, row) != before)
            .collect();
        way.push(next[choice as usize % next.len()]);
    }
    way.into_iter().map(|(column, row)| crossing(column, row)).collect()
}

/// The visits of a drive, on coarse cells.
pub(crate) fn detect(scans: &[LaserScan]) -> Vec<Stage> {
    let parameters = VisitParameters { resolution: 0.1, spacing: 1.0, ..VisitParameters::default() };
    let mut detector = VisitDetector::new(parameters).unwrap();
    let mut stages: Vec<Stage> = scans.iter().flat_map(|scan| detector.add(scan)).collect();
    stages.extend(detector.finish());
    stages
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn every_crossing_on_the_way_is_visited_once(
        choices in prop::collection::vec(any::<u8>(), 3..6),
        seed in any::<u64>(),
        heading_drift in -0.003..0.003,
        length_drift in -0.02..0.02,
    ) {
        let mut route = walk(3, 3, &choices);
        // It begins and ends half way between two crossings, so that it has seen all around each.
        let last = route.len() - 1;
        route[0] = nalgebra::center(&route[0], &route[1]);
        route[last] = nalgebra::center(&route[last - 1], &route[last]);
        let explorer = Explorer { range_noise: 0.02, heading_drift, length_drift, seed };
        let (scans, mut stops) = drive(&corridors(3, 3), &route, &explorer).unwrap();
        stops.pop();
        stops.remove(0);
        let stages = detect(&scans);
        let stays: Vec<[usize; 2]> =
            stages.iter().map(|Stage { visit, .. }| [visit.arrival.scan, visit.departure.scan]).collect();
        prop_assert_eq!(stays.len(), stops.len(), "{:?} {:?}", stays, stops);
        for (stay, stop) in stays.iter().zip(&stops) {
            prop_assert!(stay[0] <= *stop && *stop <= stay[1], "{:?} {:?}", stays, stops);
        }
        // The ways follow on one another: each begins at the arrival before and ends at its own.
        for (k, Stage { way, visit }) in stages.iter().enumerate() {
            prop_assert_eq!(way.last().map(|moment| moment.scan), Some(visit.arrival.scan));
            let before = k.checked_sub(1).map_or(0, |k| stages[k].visit.arrival.scan);
            prop_assert_eq!(way.first().map(|moment| moment.scan), Some(before));
        }
    }

    /// However odometry turns, over 56 m and a corner: by less than 3 % of the way, and by no more than is said.
    #[test]
    fn matched_scans_drift_less_than_odometry(
        seed in any::<u64>(),
        heading_drift in prop_oneof![-0.01..-0.004, 0.004..0.01],
    ) {
        let route = [crossing(0, 0), crossing(2, 0), crossing(2, 2)];
        let explorer = Explorer { range_noise: 0.02, heading_drift, length_drift: 0.0, seed };
        let (scans, _) = drive(&corridors(3, 3), &route, &explorer).unwrap();
        let way = matched(&scans);
        let [first, last] = [way[0], way[way.len() - 1]].map(|moment| moment.local_from_robot);
        let end = Pose { x: route[2].x, y: route[2].y, theta: FRAC_PI_2 };
        let off = |pose: &Pose| (pose.position() - end.position()).norm();
        let (matched, odometry) = (off(&last), off(&scans[scans.len() - 1].odom_from_robot));
        prop_assert!(odometry > 3.0 && matched < 0.03 * 4.0 * SPACING, "{matched} {odometry}");
        let [seen, truth] = [last, end].map(|pose| first.inverse().compose(&pose));
        let turn = wrap_angle(seen.theta - truth.theta);
        let error = Pose { x: seen.x - truth.x, y: seen.y - truth.y, theta: turn };
        let chi_square = chi_square(&error, &covariance(&way, &first));
        // 1 in 1,000 errors is beyond it.
        prop_assert!(chi_square.is_some_and(|strain| strain < 16.27), "{error:?} {chi_square:?}");
    }
}

/// Where the robot was at each scan, as they match.
fn matched(scans: &[LaserScan]) -> Vec<Moment> {
    let mut matcher = ScanMatcher::new(MatchingParameters::default());
    let moment = |(scan, LocalPose { local_from_robot, drift, .. })| Moment {
        scan,
        local_from_robot,
        drift,
        driven: 0.0,
    };
    scans.iter().map(|scan| matcher.add(scan)).enumerate().map(moment).collect()
}

#[test]
fn a_corridor_alone_is_no_place_and_its_end_is_one() {
    let plan = Drawing::new().corridor((0.0, 0.0), (40.0, 0.0), 2.0);
    let explorer = Explorer { range_noise: 0.01, heading_drift: 0.0, length_drift: 0.0, seed: 1 };
    let at = |x: f64| Point::new(x, 0.0);
    let (scans, _) = drive(&plan, &[at(12.0), at(28.0)], &explorer).unwrap();
    assert_eq!(detect(&scans), []);
    let (scans, stops) = drive(&plan, &[at(12.0), at(38.8), at(12.0)], &explorer).unwrap();
    let stages = detect(&scans);
    assert_eq!(stages.len(), 1);
    let visit = &stages[0].visit;
    assert!(visit.arrival.scan < stops[1] && stops[1] < visit.departure.scan);
}

/// Corridors to the north and south of one to the east that ends so far away.
fn crossing_with_dead_end(end: f64) -> Drawing {
    Drawing::new()
        .corridor((-20.0, 0.0), (end + 1.2, 0.0), 2.0)
        .corridor((0.0, 0.0), (0.0, 20.0), 2.0)
        .corridor((0.0, 0.0), (0.0, -20.0), 2.0)
}

/// The visits of a robot that goes past the crossing to the dead end, and back and off to the north, while the plan changes
/// behind it.
fn there_and_back(end: f64, before: &Drawing, after: &Drawing) -> Vec<Visit> {
    let explorer = Explorer { range_noise: 0.01, heading_drift: 0.0, length_drift: 0.0, seed: 1 };
    let at = |x: f64, y: f64| Point::new(x, y);
    let (there, back) = ([at(-12.0, 0.0), at(end, 0.0)], [at(end, 0.0), at(0.0, 0.0), at(0.0, 14.0)]);
    let (mut scans, _) = drive(before, &there, &explorer).unwrap();
    scans.extend(drive(after, &back, &explorer).unwrap().0);
    detect(&scans).into_iter().map(|stage| stage.visit).collect()
}

fn star(visit: &Visit) -> LargeScaleStar {
    describe(&visit.lpm, &PerceptionParameters::default()).unwrap().star.large_scale()
}

/// What was told of a place holds as long as the walls that tell where the robot is.
#[test]
fn a_place_that_is_remembered_has_the_star_that_was_told() {
    let alike = |end: f64| {
        let open = crossing_with_dead_end(end);
        let shut = open.clone().block((-2.0, -3.0), (2.0, -2.0));
        let visits = there_and_back(end, &open, &shut);
        assert_eq!(visits.len(), 3);
        let [before, now] = [&visits[0], &visits[2]];
        assert!(before.center.coords.norm() < 1.5 && now.center.coords.norm() < 1.5);
        !star(before).alignments(&star(now)).is_empty()
    };
    assert!(alike(12.0));
    assert!(!alike(24.0));
}

/// What was no place when the robot passed is one if it turns out to be while the robot remembers the walls.
#[test]
fn a_place_that_was_passed_before_it_was_known_was_visited() {
    let visits = |end: f64| {
        let open = crossing_with_dead_end(end);
        let shut = open.clone().block((-2.0, 1.0), (2.0, 20.0)).block((-2.0, -20.0), (2.0, -1.0));
        there_and_back(end, &shut, &open)
    };
    let near = visits(9.0);
    assert_eq!(near.len(), 3);
    assert_eq!((near[0].center, star(&near[0])), (near[2].center, star(&near[2])));
    assert!(near[0].departure.scan < near[1].arrival.scan && near[0].arrival.scan < near[0].departure.scan);
    assert_eq!(visits(24.0).len(), 2);
}

/// A robot that drives along on the other side of a thin wall is not at the place that is there; nor if it is so near to the wall
/// that it is within the reach of the place and in line with two of its gateways, as if it came in by one and left by the other.
#[test]
fn a_wall_parts_a_place_from_who_drives_by_behind_it() {
    for (reach, beside) in [(6.0, 1.35), (8.0, 1.35), (5.5, 1.15), (6.0, 1.15)] {
        let low = 1.1;
        let plan = Drawing::new()
            .corridor((-reach - 1.0, 0.0), (reach + 1.0, 0.0), 2.0)
            .corridor((0.0, 0.0), (0.0, -14.0), 2.0)
            .room((-reach - 1.0, low), (reach + 1.0, low + 2.0))
            .room((reach - 1.0, 0.0), (reach + 1.0, low + 2.0))
            .room((-reach - 1.0, 0.0), (-reach + 1.0, low + 2.0));
        let around = [(reach, 0.0), (reach, beside), (-reach, beside), (-reach, 0.0)];
        let ends = [vec![(0.0, -9.0), (0.0, 0.0)], around.to_vec(), vec![(0.0, 0.0), (0.0, -12.0)]];
        let route: Vec<Point> = ends.concat().into_iter().map(|(x, y)| Point::new(x, y)).collect();
        let explorer = Explorer { range_noise: 0.01, heading_drift: 0.0, length_drift: 0.0, seed: 1 };
        let (scans, _) = drive(&plan, &route, &explorer).unwrap();
        let there = detect(&scans).into_iter().filter(|stage| stage.visit.center.coords.norm() < 2.0);
        assert_eq!(there.count(), 2, "{reach} {beside}");
    }
}

#[test]
fn no_scan_or_one_is_no_trouble() {
    assert_eq!(detect(&[]), []);
    let (scans, _) = drive(
        &corridors(2, 2),
        &[crossing(0, 0), crossing(1, 0)],
        &Explorer { range_noise: 0.0, heading_drift: 0.0, length_drift: 0.0, seed: 0 },
    )
    .unwrap();
    assert!(detect(&scans[..1]).len() <= 1);
    let blind: Vec<LaserScan> =
        scans.into_iter().map(|scan| LaserScan { ranges: vec![None; 180], ..scan }).collect();
    assert_eq!(detect(&blind), []);
}
