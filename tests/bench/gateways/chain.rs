//! The whole way from the raw log to the map, every default 20 % down and up.

use crate::aces;
use rayon::prelude::*;
use topostar::abduction::{Abduction, AxiomSet, Limits, Profile, Visit};
use topostar::export::{Mark, Truth};
use topostar::lpm::Lpm;
use topostar::metric::{Measurements, MetricParameters};
use topostar::sensor::{LaserScan, LocalPose, ScanMatcher};
use topostar::trace::Experience;
use topostar::trace::perceive::perceive;
use topostar::trace::recording::Recorder;
use topostar::visit::truth::Timetable;
use topostar::visit::{Stage, VisitDetector, VisitParameters};

/// All that the chain takes from robot and building.
#[derive(Clone, Copy, Default)]
struct Parameters {
    visit: VisitParameters,
    metric: MetricParameters,
}

/// A parameter by name, and how to get at it.
type Parameter = (&'static str, fn(&mut Parameters) -> &mut f64);

const PARAMETERS: &[Parameter] = &[
    ("matching.window", |p| &mut p.visit.matching.window),
    ("matching.memory", |p| &mut p.visit.matching.memory),
    ("matching.max_range", |p| &mut p.visit.matching.max_range),
    ("matching.reach", |p| &mut p.visit.matching.reach),
    ("matching.range_noise", |p| &mut p.visit.matching.range_noise),
    ("matching.slip", |p| &mut p.visit.matching.slip),
    ("matching.heading_slip", |p| &mut p.visit.matching.heading_slip),
    ("matching.step", |p| &mut p.visit.matching.step),
    ("matching.turn", |p| &mut p.visit.matching.turn),
    ("evidence.passed", |p| &mut p.visit.evidence.passed),
    ("evidence.hit", |p| &mut p.visit.evidence.hit),
    ("evidence.decided", |p| &mut p.visit.evidence.decided),
    ("evidence.limit", |p| &mut p.visit.evidence.limit),
    ("evidence.max_range", |p| &mut p.visit.evidence.max_range),
    ("cleaning.gap", |p| &mut p.visit.perception.cleaning.gap),
    ("cleaning.stray", |p| &mut p.visit.perception.cleaning.stray),
    ("cleaning.shadow", |p| &mut p.visit.perception.cleaning.shadow),
    ("cleaning.post", |p| &mut p.visit.perception.cleaning.post),
    ("skeleton.comfort_distance", |p| &mut p.visit.perception.skeleton.comfort_distance),
    ("skeleton.passage_width", |p| &mut p.visit.perception.skeleton.passage_width),
    ("skeleton.scope", |p| &mut p.visit.perception.skeleton.scope),
    ("skeleton.robot_width", |p| &mut p.visit.perception.skeleton.robot_width),
    ("gateway.constriction_depth", |p| &mut p.visit.perception.gateway.constriction_depth),
    ("gateway.look_ahead", |p| &mut p.visit.perception.gateway.look_ahead),
    ("gateway.direction_length", |p| &mut p.visit.perception.gateway.direction_length),
    ("gateway.place_reach", |p| &mut p.visit.perception.gateway.place_reach),
    ("gateway.bend", |p| &mut p.visit.perception.gateway.bend),
    ("gateway.cap", |p| &mut p.visit.perception.gateway.cap),
    ("fragment.least_score", |p| &mut p.visit.perception.fragment.least_score),
    ("fragment.ambiguity", |p| &mut p.visit.perception.fragment.ambiguity),
    ("visit.resolution", |p| &mut p.visit.resolution),
    ("visit.side", |p| &mut p.visit.side),
    ("visit.spacing", |p| &mut p.visit.spacing),
    ("visit.lag", |p| &mut p.visit.lag),
    ("visit.agreement", |p| &mut p.visit.agreement),
    ("visit.presence", |p| &mut p.visit.presence),
    ("visit.hysteresis", |p| &mut p.visit.hysteresis),
    ("metric.sigmas", |p| &mut p.metric.sigmas),
    ("metric.position_gate", |p| &mut p.metric.position_gate),
    ("metric.pose_gate", |p| &mut p.metric.pose_gate),
    ("metric.bearing_sigma", |p| &mut p.metric.bearing_sigma),
    ("metric.extent_sigma", |p| &mut p.metric.extent_sigma),
    ("metric.separation", |p| &mut p.metric.separation),
    ("metric.lever", |p| &mut p.metric.lever),
];

/// Beyond so many candidates a wrong map is as wrong as it can be.
const MOST: usize = 20_000;

pub(super) fn print() {
    let (scans, marks) = (aces::scans("aces"), aces::marks());
    let matched = matched(&scans, &VisitParameters::default());
    println!("\nthe ACES log to its map, every default 20 % down and up");
    println!(
        "  unequal: places seen again whose stars differ; left: candidates; map: whether the preferred one"
    );
    println!("  is the true one, and the only one");
    println!("  {:28} {:>8}  found missed invented unequal   left  map", "", "value");
    let default = ("defaults", 1.0, Parameters::default(), 0.0);
    let varied = PARAMETERS.iter().flat_map(|(name, field)| {
        [0.8, 1.2].map(|factor| {
            let mut parameters = Parameters::default();
            let value = field(&mut parameters);
            *value *= factor;
            let value = *value;
            (*name, factor, parameters, value)
        })
    });
    let rows: Vec<_> = [default].into_iter().chain(varied).collect();
    // Rows are printed as they are known, in their order.
    for rows in rows.chunks(8) {
        let lines: Vec<String> = rows
            .par_iter()
            .map(|(name, factor, parameters, value)| {
                let same = name.split('.').next() != Some("matching");
                let outcome = outcome(&scans, same.then_some(&matched), &marks, parameters);
                format!("  {name:22} x {factor:3.1} {value:8.3}  {outcome}")
            })
            .collect();
        lines.iter().for_each(|line| println!("{line}"));
    }
}

fn matched(scans: &[LaserScan], parameters: &VisitParameters) -> Vec<LocalPose> {
    let mut matcher = ScanMatcher::new(parameters.matching);
    scans.iter().map(|scan| matcher.add(scan)).collect()
}

/// What comes of the log in a line.
fn outcome(
    scans: &[LaserScan],
    poses: Option<&Vec<LocalPose>>,
    marks: &[Mark],
    Parameters { visit, metric }: &Parameters,
) -> String {
    let own = poses.is_none().then(|| matched(scans, visit));
    let poses = poses.or(own.as_ref()).unwrap();
    let mut detector = VisitDetector::new(*visit).unwrap();
    let placed = scans.iter().zip(poses);
    let mut stages: Vec<Stage> = placed.flat_map(|(scan, pose)| detector.add_placed(scan, pose)).collect();
    stages.extend(detector.finish());
    let mut timetable = Timetable::default();
    stages.iter().for_each(|stage| timetable.add(stage));
    let at = timetable.visits_at(&marks.iter().map(|mark| mark.scan).collect::<Vec<_>>());
    match abduction(stages, visit, metric) {
        Ok(abduction) => {
            let report = abduction.report();
            let minimal = report.minimal.first().map(|candidate| candidate.places());
            let truth = Truth::of(marks.to_vec(), &at, abduction.visits(), minimal.as_deref());
            let unequal = truth.stars.iter().filter(|stars| !stars.equal).count();
            let alone = if report.minimal.len() == 1 && report.proven { "" } else { ", not alone" };
            let map = if truth.map_is_true == Some(true) { "true" } else { "wrong" };
            let (found, missed, invented) = (truth.found, truth.missed.len(), truth.invented.len());
            let left = abduction.len();
            format!("{found:5} {missed:6} {invented:8} {unequal:7} {left:6}  {map}{alone}")
        }
        Err(why) => format!("{:5} {why}", at.iter().flatten().count()),
    }
}

fn abduction(
    stages: Vec<Stage>,
    visit: &VisitParameters,
    metric: &MetricParameters,
) -> Result<Abduction, String> {
    let mut recorder = Recorder::default();
    let (mut experience, mut measured) = (Experience::new(), Measurements::new(*metric));
    let limits = Limits { max_candidates: Some(MOST), ..Limits::default() };
    let mut abduction = Abduction::new(AxiomSet::of(Profile::Default), limits);
    let perceive = |lpm: &Lpm, first| perceive(lpm, first, &visit.perception);
    for event in stages.into_iter().flat_map(|stage| recorder.add(stage)) {
        let Some(sighting) = experience.accept(&event, &perceive).map_err(|error| error.to_string())? else {
            continue;
        };
        measured = measured.with(&sighting);
        abduction
            .observe_measured(&Visit::from(&sighting), measured.evidence())
            .map_err(|error| error.to_string())?;
    }
    Ok(abduction)
}
