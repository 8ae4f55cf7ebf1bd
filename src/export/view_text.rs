//! A map of views in words.

use crate::classic::{Action, ClassicMap, ClassicPath, DstateId};
use std::fmt::Write;

/// The map as lines of text: the places on each travelled path in order, and the dstates of each place with the path
/// they face along, where their actions lead, and their view. `views` are the names of the views, by number.
pub fn view_text(map: &ClassicMap, views: &[&str]) -> String {
    let paths = map.paths();
    let mut text = String::from("paths, with the places on them in order; ? where travels do not tell it\n");
    for (number, path) in paths.iter().enumerate() {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "  Pa{:<3} {}", number + 1, stops(path));
    }
    text += "\nplaces, with the dstates that were seen there\n";
    for (number, place) in map.places().iter().enumerate() {
        for (line, &id) in place.dstates.iter().enumerate() {
            let head = if line == 0 { number.to_string() } else { String::new() };
            let along = paths.partition_point(|path| path.name <= map.dstate(id).path);
            let sign = if map.dstate(id).reversed { '-' } else { '+' };
            let view = views.get(usize::from(map.dstate(id).view.0)).copied().unwrap_or_default();
            let facing = format!("Pa{along}{sign}");
            let _ = writeln!(text, "  {head:<3} {:<5} {facing:<6} {:<38} {view}", name(id), actions(map, id));
        }
    }
    text
}

fn stops(path: &ClassicPath) -> String {
    let mut text = String::new();
    for (position, place) in path.places.iter().enumerate() {
        let before = position.checked_sub(1).map(|before| path.places[before]);
        let joint = match before {
            None => "",
            Some(before) if path.segments.contains(&[before, *place]) => " - ",
            Some(_) => " ? ",
        };
        text += joint;
        text += &place.to_string();
    }
    text
}

fn actions(map: &ClassicMap, id: DstateId) -> String {
    let known = Action::ALL.into_iter().filter_map(|action| Some((action, map.after(id, action)?)));
    let word = |action| match action {
        Action::Left => "left",
        Action::Right => "right",
        Action::Around => "around",
        Action::Travel => "travel",
    };
    known.map(|(action, to)| format!("{} {}", word(action), name(to))).collect::<Vec<_>>().join(", ")
}

fn name(id: DstateId) -> String {
    format!("ds{}", id.index())
}
