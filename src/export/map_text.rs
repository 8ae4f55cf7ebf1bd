//! A map in words.

use crate::export::{GraphBeside, GraphDstate, GraphPath, GraphPlace, MapGraph};
use crate::trace::wire_star::{WireControl, WireDirection};
use std::fmt::Write;

/// The map as lines of text: the places on each path in order, the star of each place clockwise, and what lies left
/// and right of each path.
pub fn map_text(map: &MapGraph) -> String {
    let mut text = String::from("paths, with the places on them in order\n");
    for path in &map.paths {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "  Pa{:<3} {}", path.id + 1, stops(path));
    }
    text += "\nplaces, with their large-scale stars clockwise; a path in parentheses ends here\n";
    for place in &map.places {
        let slots: Vec<String> = place.dstates.iter().map(slot_text).collect();
        let _ = writeln!(text, "  {:<3} {}", place.id, slots.join("  "));
    }
    text += &boundaries(map);
    text
}

/// What kind of place it is: how many ways lead out, and how many paths pass through.
pub fn place_type(place: &GraphPlace) -> String {
    let exits = place.dstates.iter().filter(|dstate| dstate.navigable).count();
    let through = place.size - exits;
    let shape = match (exits, through) {
        (1, _) => "dead end".into(),
        (2, 0) => "passage".into(),
        (2, _) => "corner".into(),
        (3, 1) => "T".into(),
        (4, 0) => "crossing".into(),
        _ => format!("{exits}-way"),
    };
    let mut ends: Vec<&str> = place
        .dstates
        .iter()
        .filter(|dstate| !dstate.navigable)
        .map(|dstate| blocked(dstate.control))
        .collect();
    ends.sort_unstable();
    ends.dedup();
    if ends == ["open"] { format!("{shape}, open side") } else { shape }
}

/// The paths that have a place beside them, with these.
fn boundaries(map: &MapGraph) -> String {
    let mut text = String::new();
    for path in
        map.paths.iter().filter(|path| !path.regions.left.is_empty() || !path.regions.right.is_empty())
    {
        let regions = &path.regions;
        let (left, right) = (numbers(&regions.left), numbers(&regions.right));
        let _ = write!(text, "  Pa{:<3} left {left}; right {right}", path.id + 1);
        if !regions.abnormal.is_empty() {
            let crossed: Vec<String> =
                regions.abnormal.iter().map(|path| format!("Pa{}", path + 1)).collect();
            let _ = write!(text, "; no boundary for {}", crossed.join(" "));
        }
        text.push('\n');
    }
    match text.is_empty() {
        true => text,
        false => {
            format!("\npaths as boundaries, with the places beside them as seen along their order\n{text}")
        }
    }
}

fn numbers(places: &[GraphBeside]) -> String {
    match places {
        [] => "-".into(),
        _ => places.iter().map(|beside| beside.place.to_string()).collect::<Vec<_>>().join(" "),
    }
}

fn stops(path: &GraphPath) -> String {
    path.places.iter().map(usize::to_string).collect::<Vec<_>>().join(" - ")
}

fn slot_text(dstate: &GraphDstate) -> String {
    let sign = match dstate.direction {
        WireDirection::Plus => '+',
        WireDirection::Minus => '-',
    };
    let name = format!("Pa{}{sign}", dstate.path + 1);
    match dstate.far_end {
        Some(far) => format!("{name} to {}", far.place),
        None if dstate.navigable => format!("{name} unexplored"),
        None => format!("({name} {})", blocked(dstate.control)),
    }
}

fn blocked(control: WireControl) -> &'static str {
    match control {
        WireControl::None => "open",
        _ => "blocked",
    }
}
