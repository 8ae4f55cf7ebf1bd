//! Visits found on drives through buildings whose places are so near to each other that one cannot always be told from
//! the next.

use crate::visits::detect;
use proptest::prelude::*;
use topostar::geometry::Point;
use topostar::trace::EventKind;
use topostar::trace::recording::Recorder;
use topostar::visit::{Stage, Visit};
use topostar::worlds::drawing::Drawing;
use topostar::worlds::{Explorer, drive};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn visits_come_in_their_order(dense in dense()) {
        dense.check()?;
    }
}

/// Where one visit took the place of another, it came before an earlier one on some of these drives and was to the same
/// place as the one before on others, until it was asked whether it may come next.
#[test]
fn a_visit_that_takes_the_place_of_another_may_come_next() {
    for (spacing, width, corridors, steps, heading_drift, seed) in HARD {
        let [corridors, steps] = [corridors, steps].map(str::to_owned);
        let dense = Dense { spacing, width, corridors, steps, heading_drift, seed };
        dense.check().unwrap_or_else(|fault| panic!("{dense:?}: {fault}"));
    }
}

/// Four drives on which the other middle of a place took the place of the first, and three on which a stay went on.
const HARD: [(f64, f64, &str, &str, f64, u64); 7] = [
    (
        3.9201216588208223,
        1.5609949384759982,
        "++-++-|+-+++.++-+++++++..",
        "wwnenwesswnesnenwsenswWnweeEwweSwesswnen",
        0.0008404564505389368,
        15_468_701_935_054_187_209,
    ),
    (
        4.732250396043874,
        1.9983503290915494,
        "-+++||+-++-++++-++++-|+|+",
        "nsnessswnWsWEwnes",
        0.0012796806296800482,
        3_898_153_241_315_551_261,
    ),
    (
        3.5539825859818928,
        1.4911385035315858,
        "+|+-+++--.++-+-+++++|++.+",
        "wnneesweenswnws",
        0.0023557601101613966,
        4_500_558_236_746_295_923,
    ),
    (
        4.388347215903745,
        1.6292266570519078,
        "--|-++||++|+|++|++++++-++",
        "nWnswssnnneeeswnwseessS",
        0.0011541720781797786,
        16_237_111_869_026_771_584,
    ),
    (
        2.851134703682783,
        1.3929136271662483,
        "-.|++++++++|+|++++.+-+++|",
        "NnEEneEEEessSsSWwnwssneE",
        -0.0006364578071646474,
        7_898_802_412_983_299_062,
    ),
    (
        2.792271147678851,
        1.3005419465069405,
        "++++|+.++++++-|+-|-+-++.|",
        "sSeewsWenn",
        0.0020194147180632328,
        17_426_291_967_085_203_024,
    ),
    (
        3.63009974893891,
        1.522907594764333,
        "++-+++||||+++|+++-+|.+|++",
        "SsnNwsWwSseENnwNSEsewnenwssENeNENeeNnnNWnnes",
        0.002368018981727954,
        9_611_766_540_457_625_690,
    ),
];

/// Crossings on a side of the building.
const SIDE: usize = 5;

/// The crossing at which the robot begins.
const MIDDLE: [usize; 2] = [SIDE / 2; 2];

/// A drive through a building with a crossing, a corner, a dead end or a corridor going on every few metres.
#[derive(Clone, Debug)]
struct Dense {
    /// From a crossing to the next, metres.
    spacing: f64,
    /// Of the corridors, metres.
    width: f64,
    /// The corridors that begin at each crossing, by rows, the southernmost first: `-` to the east, `|` to the north, `+`
    /// both, `.` none.
    corridors: String,
    /// Where the robot goes from crossing to crossing: `e`, `n`, `w`, `s`; where it turns back half way, the capital.
    steps: String,
    /// Radians per metre.
    heading_drift: f64,
    seed: u64,
}

fn dense() -> impl Strategy<Value = Dense> {
    let corridor = prop_oneof![Just('+'), Just('+'), Just('+'), Just('-'), Just('|'), Just('.')];
    let turns_back = prop_oneof![Just(0.125), Just(0.5)];
    let choices = turns_back
        .prop_flat_map(|back| prop::collection::vec((any::<u8>(), prop::bool::weighted(back)), 25..45));
    let corridors = prop::collection::vec(corridor, SIDE * SIDE);
    (2.6..6.5, 0.8..2.0, corridors, choices, -0.003..0.003, any::<u64>()).prop_map(
        |(spacing, width, mut corridors, choices, heading_drift, seed)| {
            // There is a way out of the first crossing.
            corridors[MIDDLE[1] * SIDE + MIDDLE[0]] = '+';
            let still = Dense {
                spacing,
                width,
                corridors: corridors.into_iter().collect(),
                steps: String::new(),
                heading_drift,
                seed,
            };
            let steps = still.walk(&choices);
            Dense { steps, ..still }
        },
    )
}

impl Dense {
    /// Visits follow on one another, each elsewhere than the one before or long after it, and ways lead from one to the
    /// next and have odometry.
    fn check(&self) -> Result<(), TestCaseError> {
        let explorer = Explorer {
            range_noise: 0.01,
            heading_drift: self.heading_drift,
            length_drift: 0.0,
            seed: self.seed,
        };
        let (scans, _) = drive(&self.plan(), &self.route(), &explorer).unwrap();
        let stages = detect(&scans);
        let mut last: Option<&Visit> = None;
        for Stage { way, visit } in &stages {
            let ends = [way.first(), way.last()].map(|moment| moment.map(|moment| moment.scan));
            prop_assert_eq!(ends, [Some(last.map_or(0, |last| last.arrival.scan)), Some(visit.arrival.scan)]);
            prop_assert!(visit.arrival.scan <= visit.departure.scan);
            if let Some(last) = last {
                prop_assert!(last.arrival.scan < visit.arrival.scan);
                prop_assert!(last.departure.scan <= visit.departure.scan);
                let elsewhere = (last.center - visit.center).norm() > 2.0;
                prop_assert!(elsewhere || last.departure.driven + 50.0 < visit.arrival.driven);
            }
            last = Some(visit);
        }
        let mut recorder = Recorder::default();
        for event in stages.into_iter().flat_map(|stage| recorder.add(stage)) {
            let EventKind::Travel(travel) = event.kind else { continue };
            prop_assert!(travel.odometry.is_some() && travel.covariance.is_some());
        }
        Ok(())
    }

    fn plan(&self) -> Drawing {
        let corridor = |plan: Drawing, here: [usize; 2], axis: usize| {
            let ahead = nalgebra::Vector2::ith(axis, self.width / 2.0);
            let mut to = here;
            to[axis] += 1;
            let (from, to) = (self.at(here) - ahead, self.at(to) + ahead);
            plan.corridor((from.x, from.y), (to.x, to.y), self.width)
        };
        let all = (0..SIDE * SIDE).flat_map(|k| [0, 1].map(|axis| ([k % SIDE, k / SIDE], axis)));
        all.filter(|&(here, axis)| self.is_open(here, axis))
            .fold(Drawing::new(), |plan, (here, axis)| corridor(plan, here, axis))
    }

    fn route(&self) -> Vec<Point> {
        let mut here = MIDDLE;
        let mut route = vec![self.at(here)];
        for step in self.steps.chars() {
            let to = neighbour(here, step.to_ascii_lowercase()).unwrap();
            if step.is_uppercase() {
                route.extend([nalgebra::center(&self.at(here), &self.at(to)), self.at(here)]);
            } else {
                here = to;
                route.push(self.at(here));
            }
        }
        route
    }

    fn at(&self, [column, row]: [usize; 2]) -> Point {
        Point::new(column as f64, row as f64) * self.spacing
    }

    /// Whether there is a corridor from a crossing to the one after it along an axis.
    fn is_open(&self, here: [usize; 2], axis: usize) -> bool {
        let corridors = self.corridors.as_bytes()[here[1] * SIDE + here[0]];
        here[axis] + 1 < SIDE && [b"+-", b"+|"][axis].contains(&corridors)
    }

    /// The steps that such choices lead to: which of the ways out to take, and whether to turn back half way. Seldom does it go
    /// back to the crossing that it came from, if there is another way.
    fn walk(&self, choices: &[(u8, bool)]) -> String {
        let mut here = MIDDLE;
        let mut before = None;
        let step = |&(choice, back): &(u8, bool)| {
            let mut ways = self.ways(here);
            if ways.len() > 1 && choice % 4 > 0 {
                ways.retain(|&way| neighbour(here, way) != before);
            }
            let way = ways[choice as usize / 4 % ways.len()];
            if back {
                return way.to_ascii_uppercase();
            }
            (before, here) = (Some(here), neighbour(here, way).unwrap());
            way
        };
        choices.iter().map(step).collect()
    }

    /// The steps that lead on from a crossing.
    fn ways(&self, here: [usize; 2]) -> Vec<char> {
        let is_open = |&way: &char| {
            neighbour(here, way).is_some_and(|to| match way {
                'e' => self.is_open(here, 0),
                'n' => self.is_open(here, 1),
                'w' => self.is_open(to, 0),
                _ => self.is_open(to, 1),
            })
        };
        ['e', 'n', 'w', 's'].into_iter().filter(is_open).collect()
    }
}

/// The crossing that a step leads to, if there is one.
fn neighbour([column, row]: [usize; 2], step: char) -> Option<[usize; 2]> {
    let [column, row] = match step {
        'e' => [column + 1, row],
        'n' => [column, row + 1],
        'w' => [column.checked_sub(1)?, row],
        _ => [column, row.checked_sub(1)?],
    };
    (column < SIDE && row < SIDE).then_some([column, row])
}
