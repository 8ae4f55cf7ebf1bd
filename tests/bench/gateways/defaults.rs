//! Every default 20 % down and up.

use crate::aces::{self, same_star};
use crate::doors::{self, with_doors};
use crate::maps;
use crate::openings::Tally;
use crate::stability::{MAPS, places};
use topostar::lpm::Lpm;
use topostar::star::{LargeScaleStar, PerceptionParameters, describe};

/// A parameter by name, and how to get at it.
type Parameter = (&'static str, fn(&mut PerceptionParameters) -> &mut f64);

const PARAMETERS: &[Parameter] = &[
    ("cleaning.gap", |p| &mut p.cleaning.gap),
    ("cleaning.stray", |p| &mut p.cleaning.stray),
    ("cleaning.shadow", |p| &mut p.cleaning.shadow),
    ("cleaning.post", |p| &mut p.cleaning.post),
    ("skeleton.comfort_distance", |p| &mut p.skeleton.comfort_distance),
    ("skeleton.passage_width", |p| &mut p.skeleton.passage_width),
    ("skeleton.scope", |p| &mut p.skeleton.scope),
    ("skeleton.robot_width", |p| &mut p.skeleton.robot_width),
    ("gateway.constriction_depth", |p| &mut p.gateway.constriction_depth),
    ("gateway.look_ahead", |p| &mut p.gateway.look_ahead),
    ("gateway.direction_length", |p| &mut p.gateway.direction_length),
    ("gateway.place_reach", |p| &mut p.gateway.place_reach),
    ("gateway.bend", |p| &mut p.gateway.bend),
    ("gateway.cap", |p| &mut p.gateway.cap),
    ("fragment.least_score", |p| &mut p.fragment.least_score),
    ("fragment.ambiguity", |p| &mut p.fragment.ambiguity),
];

pub(super) fn print() {
    let visits = aces::load();
    let (map, doors) = doors::load();
    let windows = windows();
    let default = PerceptionParameters::default();
    let stars = aces::stars(&visits, &default);
    let elsewhere: Vec<Option<LargeScaleStar>> = windows.iter().map(|lpm| star(lpm, &default)).collect();
    println!("\nevery default 20 % down and up");
    println!(
        "  changed: of the 15 ACES stars; seen: ACES stars with the gateways and paths that a person sees;"
    );
    println!(
        "  alike: ACES visits whose star is that of the other visits to the place; doors: of gdc3, found, in"
    );
    println!("  percent; other: of {} places of other maps, changed, in percent", windows.len());
    println!("  {:28} {:>10} changed seen alike doors other", "", "value");
    let row = |name: &str, value: f64, parameters: &PerceptionParameters| {
        let found = aces::stars(&visits, parameters);
        let changed = stars.iter().zip(&found).filter(|(a, b)| !same_star(a, b)).count();
        let mut tally = Tally::default();
        tally.look(&map, &doors, &with_doors(*parameters));
        let other =
            windows.iter().zip(&elsewhere).filter(|(lpm, was)| !same_star(was, &star(lpm, parameters)));
        println!(
            "  {name:28} {value:10.3} {changed:7} {:4} {:5} {:5.1} {:5.1}",
            aces::as_seen(&visits, &found),
            aces::alike(&visits, &found),
            100.0 * tally.hits as f64 / tally.poses as f64,
            100.0 * other.count() as f64 / windows.len() as f64
        );
    };
    row("defaults", 0.0, &default);
    for (name, field) in PARAMETERS {
        for factor in [0.8, 1.2] {
            let mut parameters = default;
            *field(&mut parameters) *= factor;
            row(name, *field(&mut parameters), &parameters);
        }
    }
}

fn star(lpm: &Lpm, parameters: &PerceptionParameters) -> Option<LargeScaleStar> {
    describe(lpm, parameters).ok().map(|place| place.star.large_scale())
}

/// A window around every place of the other maps.
fn windows() -> Vec<Lpm> {
    let default = PerceptionParameters::default();
    let mut windows = Vec::new();
    for (file, resolution) in MAPS {
        let map = maps::grid(file, resolution);
        let found = places(&map, &default);
        windows.extend(found.iter().map(|place| maps::lpm(&map, &place.robot)));
    }
    windows
}
