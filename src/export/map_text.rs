//! A candidate's map in words.

use crate::abduction::Candidate;
use crate::map::{BoundSlot, Paths, TopoPath, TopologicalMap};
use crate::star::{ControlLaw, Direction};
use std::fmt::Write;

/// The map as lines of text: its counts, the places on each path in order, and the star of each place clockwise.
pub fn map_text(candidate: &Candidate) -> String {
    let map = candidate.map.as_ref();
    let paths = Paths::of(map);
    let mut text = String::new();
    let visits: Vec<String> = candidate.places().iter().map(usize::to_string).collect();
    let counts = [
        (map.place_count(), "places"),
        (map.path_count(), "paths"),
        (map.segment_count(), "path segments"),
        (map.dstate_count(), "dstates"),
    ];
    let counts: Vec<String> = counts.iter().map(|(count, what)| format!("{count} {what}")).collect();
    // Writing into a String cannot fail.
    let _ = writeln!(text, "{}", counts.join(", "));
    let _ = writeln!(text, "visits  {}", visits.join(" "));
    let _ = writeln!(text, "\npaths, with the places on them in order");
    for path in paths.iter() {
        let _ = writeln!(text, "  Pa{:<3} {}", path.id.0 + 1, stops(path));
    }
    let _ =
        writeln!(text, "\nplaces, with their large-scale stars clockwise; a path in parentheses ends here");
    for place in map.places() {
        let slots: Vec<String> =
            paths.bound_star(map, place).iter().map(|slot| slot_text(map, slot)).collect();
        let _ = writeln!(text, "  {:<3} {}", place.index(), slots.join("  "));
    }
    text
}

fn stops(path: &TopoPath) -> String {
    let places: Vec<String> = path.stops.iter().map(|stop| stop.back.place.index().to_string()).collect();
    places.join(" - ")
}

fn slot_text(map: &TopologicalMap, slot: &BoundSlot) -> String {
    let sign = match slot.along.direction {
        Direction::Plus => '+',
        Direction::Minus => '-',
    };
    let name = format!("Pa{}{sign}", slot.along.path.0 + 1);
    if slot.terminates {
        let control = map.star(slot.dstate.place).slots()[usize::from(slot.dstate.slot.0)].control;
        return format!("({name} {})", if control == ControlLaw::DeadEnd { "blocked" } else { "open" });
    }
    match map.far_end(slot.dstate) {
        Some(far) => format!("{name} to {}", far.place.index()),
        None => format!("{name} unexplored"),
    }
}
