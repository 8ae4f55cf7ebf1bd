//! The measured axioms that the reference states: the search finds the maps whose lengths and directions it allows.

use crate::engine::stories;
use crate::measured::{explain, recorded, sightings};
use crate::reference::{MEASURED, Measured, Story};
use proptest::prelude::*;
use topostar::abduction::{Abduction, AxiomId, AxiomSet, Profile, REGISTRY, Visit};
use topostar::metric::MetricParameters;
use topostar::star::SmallScaleStar;
use topostar::trace::Sighting;
use topostar::worlds::{Drift, corridor_grid, covering_walk, drifting_trace};

/// A walk through a grid with odometry of some quality, said to be better than it is; some travels are measured twice as
/// long as they are, and there are gaps in what was measured: travels without odometry, slots without bearings, starts
/// that have to be guessed. The corridors of some grids do not meet at right angles.
pub(crate) fn measured_walks(most: usize) -> impl Strategy<Value = Vec<Sighting>> {
    let drift = prop_oneof![Just(0.05), Just(0.2), Just(1.0)];
    let boast = prop_oneof![3 => Just(1.0), 1 => Just(0.1), 1 => Just(0.001)];
    let gaps = prop_oneof![2 => Just(0), 1 => any::<u64>()];
    let stretch = prop_oneof![2 => Just(0), 1 => any::<u16>()];
    let skew = prop_oneof![1 => Just(0.0), 1 => Just(0.5)];
    (any::<u64>(), 2usize..4, 4.0..12.0, drift, boast, (gaps, stretch, skew), 3..most).prop_map(
        |(seed, columns, spacing, drift, boast, (gaps, stretch, skew), travels)| {
            let places = corridor_grid(2, columns, spacing);
            let mut walk = covering_walk(&places, seed);
            walk.leave.truncate(travels);
            let trace = drifting_trace(&places, &walk, Drift::WORST.scaled(drift), seed).unwrap();
            let mut seen = sightings(&trace.events);
            for (k, (sighting, &(place, rotation))) in seen.iter_mut().zip(&trace.truth).enumerate() {
                *sighting = bent(sighting, rotation, f64::from((seed >> (place % 60)) as u8 & 3) * skew);
                if let Some(motion) = &mut sighting.motion {
                    motion.covariance = motion.covariance.map(|entry| entry * boast);
                    motion.start_given = seed % 3 != 0;
                    if stretch >> (k % 16) & 3 == 3 {
                        (motion.odometry.x, motion.odometry.y) =
                            (2.0 * motion.odometry.x, 2.0 * motion.odometry.y);
                    }
                }
                if gaps >> (k % 16) & 7 == 7 {
                    sighting.motion = None;
                }
                *sighting = without_some_bearings(sighting, gaps >> (16 + k % 16));
            }
            seen
        },
    )
}

/// The same, with the corridor at the first slot of a place bent aside by an angle.
fn bent(sighting: &Sighting, rotation: u8, by: f64) -> Sighting {
    let mut slots = sighting.star.slots().to_vec();
    let first = (slots.len() - usize::from(rotation)) % slots.len();
    slots[first].bearing = slots[first].bearing.map(|bearing| bearing + by);
    let star = SmallScaleStar::new(slots).unwrap();
    Sighting { star, ..sighting.clone() }
}

/// The same, with bearings of slots left out where three bits are set.
fn without_some_bearings(sighting: &Sighting, gaps: u64) -> Sighting {
    let mut slots = sighting.star.slots().to_vec();
    let unseen = slots.iter_mut().enumerate().filter(|(slot, _)| gaps >> (5 * slot) & 7 == 7);
    unseen.for_each(|(_, slot)| slot.bearing = None);
    let star = SmallScaleStar::new(slots).unwrap();
    Sighting { star, ..sighting.clone() }
}

/// The longest beginning with few maps under some symbolic axioms, its visits, and these maps.
pub(crate) fn few_maps(
    seen: &[Sighting],
    symbols: AxiomSet,
    most: usize,
) -> (&[Sighting], Vec<Visit>, Vec<Story>) {
    let few = (1..=seen.len()).take_while(|&length| explain(&seen[..length], symbols).len() <= most);
    let seen = &seen[..few.last().unwrap_or(1)];
    (seen, seen.iter().map(Visit::from).collect(), stories(&explain(seen, symbols)))
}

/// Profile default of the symbolic axioms, and one of measurements.
pub(crate) fn symbols_and(axiom: AxiomId) -> AxiomSet {
    AxiomSet::of(Profile::Default).without_measured().with(axiom)
}

/// Whether a story and all its beginnings obey some laws of measurements.
pub(crate) fn obeys(measured: &Measured, visits: &[Visit], story: &Story, laws: &[&str]) -> bool {
    let beginnings = (1..=story.len()).map(|length| story[..length].to_vec());
    beginnings.into_iter().all(|story| laws.iter().all(|law| measured.obeys(visits, &story, law)))
}

fn refuted_by_the_reference(seen: &[Sighting], most: usize) -> Result<[usize; 2], TestCaseError> {
    let symbols = AxiomSet::of(Profile::Default).without_measured();
    let (seen, visits, all) = few_maps(seen, symbols, most);
    let measured = Measured::new(seen, MetricParameters::default());
    let agree = |found: &Abduction, laws: &[&str]| -> Result<usize, TestCaseError> {
        let expected: Vec<Story> =
            all.iter().filter(|story| obeys(&measured, &visits, story, laws)).cloned().collect();
        prop_assert_eq!(stories(found), &expected[..], "{:?}", laws);
        Ok(all.len() - expected.len())
    };
    let [distance, angle] = [AxiomId::Distance, AxiomId::Angle].map(|id| explain(seen, symbols_and(id)));
    let both = symbols_and(AxiomId::Distance).with(AxiomId::Angle);
    agree(&explain(seen, both), &MEASURED)?;
    Ok([agree(&distance, &MEASURED[..1])?, agree(&angle, &MEASURED[1..])?])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_search_keeps_what_the_reference_allows(seen in measured_walks(11)) {
        refuted_by_the_reference(&seen, 120)?;
    }
}

#[test]
fn both_refute_on_recorded_traces() {
    let [distance, _] = refuted_by_the_reference(&recorded("ring-10-30"), 2000).unwrap();
    let [_, angle] = refuted_by_the_reference(&recorded("rhombus"), 2000).unwrap();
    assert!(distance > 0 && angle > 0, "{distance} {angle}");
}

#[test]
fn the_reference_states_what_it_says_it_does() {
    let named: Vec<&str> =
        REGISTRY.iter().filter(|axiom| axiom.is_measured()).map(|axiom| axiom.name).collect();
    let known: Vec<&str> = MEASURED.into_iter().chain(crate::reference::UNKNOWN).collect();
    assert_eq!(named, known);
}
