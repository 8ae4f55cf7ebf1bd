//! What an event more costs a candidate map: its frames relaxed anew, as commands and service do, beside a graph that grows
//! and relaxes what the event touches.

use crate::clock::{mean, processor};
use std::hint::black_box;
use std::sync::Arc;
use topostar::abduction::Assignment;
use topostar::geometry::Pose;
use topostar::map::PlaceId;
use topostar::patchwork::local_frames::{LocalFrames, graph};
use topostar::patchwork::survey::Survey;
use topostar::patchwork::{IncrementalGraph, PoseGraph, RelaxOptions};
use topostar::worlds::{Drift, corridor_grid, covering_walk, drifting_trace};

/// Sides of square grids of corridors, each walked until every corridor is known.
const SIDES: [usize; 4] = [4, 8, 16, 32];
const SEED: u64 = 7;
/// Metres from place to place.
const SPACING: f64 = 10.0;
const SECONDS: f64 = 1.0;

/// Prints a row a grid, milliseconds on the processor.
pub(crate) fn print() {
    println!(
        "\ntrue maps of walks over corridor grids with the worst odometry: frames relaxed anew after the last event; fed event by \
         event, milliseconds for each: median, 99 %, worst; how much more strain the latter ends with"
    );
    for side in SIDES {
        let places = corridor_grid(side, side, SPACING);
        let trace = drifting_trace(&places, &covering_walk(&places, SEED), Drift::WORST, SEED).unwrap();
        let events: Vec<_> = trace.events.into_iter().map(Arc::new).collect();
        let survey = Survey::of(&events).unwrap();
        let place =
            |&(place, rotation): &(usize, u8)| Assignment { place: PlaceId::new(place).unwrap(), rotation };
        let candidate: Vec<Assignment> = trace.truth.iter().map(place).collect();
        let (travels, closures) =
            (survey.travels(), survey.agreements().closures(&candidate, &|| false).unwrap());
        let relax = || LocalFrames::relax(&travels, closures.clone(), &|| false).unwrap();
        let anew = mean(processor, SECONDS, &|| drop(black_box(relax())));
        let (times, strain) = grown(&graph(&travels, &closures).unwrap());
        let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize] * 1e3;
        println!(
            "{side:>2} x {side:<2} {:>5} observations, {:>5} closures: {:>7.2} anew; {:>7.3} {:>7.3} {:>7.3}, {:.1e}",
            travels.len(),
            closures.len(),
            anew * 1e3,
            at(0.5),
            at(0.99),
            at(1.0),
            strain / relax().strain.chi_square - 1.0
        );
    }
}

/// A graph fed pose by pose: how long each took, in ascending order, and the strain at the end.
pub(crate) fn grown(graph: &PoseGraph) -> (Vec<f64>, f64) {
    let mut growing = IncrementalGraph::new(RelaxOptions::default());
    let mut times = vec![];
    for (id, edges) in graph.in_order() {
        let begun = processor();
        growing.add_pose(id, None).unwrap();
        edges.iter().for_each(|edge| growing.add_edge(*edge).unwrap());
        growing.relax().unwrap();
        times.push(processor() - begun);
    }
    times.sort_by(f64::total_cmp);
    let poses: Vec<Pose> = growing.poses().iter().map(|pose| pose.unwrap()).collect();
    let strain = growing.graph().strains(&poses).unwrap().iter().map(|strain| strain.chi_square).sum();
    (times, strain)
}
