//! One sheet with every visit of a trace in order.

use crate::export::extraction_svg::{panel, panel_size};
use crate::export::sheet::{DOUBTFUL, FAINT, INK, sheet};
use crate::geometry::Pose;
use crate::star::{PlaceDescription, Rejected, Slot, SlotIndex};
use svg::node::element::{Group, Text};

/// Panels side by side.
const COLUMNS: usize = 3;
/// How large a panel is drawn.
const SCALE: f64 = 0.55;
/// Room for the label above a panel, user units of the sheet.
const LABEL: f64 = 44.0;
const GAP: f64 = 16.0;

/// A visit on a sheet.
#[derive(Clone, Debug)]
pub struct Visited<'a> {
    /// Which observation of the trace, counted from 0.
    pub observation: usize,
    /// The robot's pose on arrival, in the frame of the place.
    pub robot: Pose,
    /// The openings that are no gateways.
    pub rejected: &'a [Rejected],
    /// The place as it was read, or why it could not be.
    pub place: Result<&'a PlaceDescription, String>,
}

/// An SVG document with a panel for each visit, in the order given: number, arrival, least margin, and the picture.
pub fn visits_svg(visits: &[Visited]) -> String {
    let size = |visit: &Visited| visit.place.as_ref().map_or((1.0, 1.0), |place| panel_size(place));
    let widest = visits.iter().map(|visit| size(visit).0).fold(1.0, f64::max) * SCALE + GAP;
    let mut top = GAP;
    let mut group = Group::new();
    for row in visits.chunks(COLUMNS) {
        for (column, visit) in row.iter().enumerate() {
            group = group.add(tile(visit, GAP + column as f64 * widest, top));
        }
        top += row.iter().map(|visit| size(visit).1).fold(1.0, f64::max) * SCALE + LABEL + GAP;
    }
    let columns = visits.len().clamp(1, COLUMNS) as f64;
    sheet(columns * widest + GAP, top).add(group).to_string()
}

fn tile(visit: &Visited, left: f64, top: f64) -> Group {
    let title = Text::new(format!("Visit {}", visit.observation)).set("font-size", 20).set("fill", INK);
    let title = title.set("x", left).set("y", top + 20.0).set("font-weight", "bold");
    let said = |text: String, below: f64, color: &str| {
        Text::new(text).set("font-size", 14).set("fill", color).set("x", left + below).set("y", top + 20.0)
    };
    let group = Group::new().add(title);
    match &visit.place {
        Ok(place) => {
            let (slot, margin) = least(place);
            let color = if margin < 0.1 { DOUBTFUL } else { FAINT };
            let unsure = format!("least margin {:.0} %, slot {}", 100.0 * margin, slot.0);
            let at = format!("translate({left} {}) scale({SCALE})", top + LABEL - 8.0);
            group
                .add(said(arrival(place), 100.0, FAINT))
                .add(said(unsure, 350.0, color))
                .add(panel(place, &visit.robot, visit.rejected).set("transform", at))
        }
        Err(why) => group.add(said(why.clone(), 100.0, DOUBTFUL)),
    }
}

/// On which slot the robot came in, and heading where.
fn arrival(place: &PlaceDescription) -> String {
    let heading = |slot: SlotIndex| {
        let bearing = place.star.slot(slot).and_then(|slot: &Slot| slot.bearing);
        bearing.map_or_else(String::new, |bearing| format!(", heading {:.0}\u{b0}", bearing.to_degrees()))
    };
    match place.arrival {
        Some(slot) => format!("came in on slot {}{}", slot.0, heading(slot)),
        None => format!("came in by no gateway, faces slot {}", place.facing.0),
    }
}

/// The slot that was nearest to being read otherwise, and how near.
pub(super) fn least(place: &PlaceDescription) -> (SlotIndex, f64) {
    let margins = place.star.slots().iter().enumerate().filter_map(|(i, slot)| Some((i, slot.margin?)));
    let least = margins.min_by(|a, b| a.1.total_cmp(&b.1));
    least.map_or((SlotIndex(0), f64::INFINITY), |(i, margin)| (SlotIndex(i as u8), margin))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::lpm::Lpm;
    use crate::star::{PerceptionParameters, describe};
    use crate::worlds::drawing::{Drawing, window};

    #[test]
    fn every_visit_has_its_panel_and_a_place_not_understood_its_reason() {
        let tee =
            Drawing::new().corridor((-9.0, 0.0), (9.0, 0.0), 2.0).corridor((0.0, 0.0), (0.0, -9.0), 2.0);
        let grid = tee.render(&window(12.0, 0.1, Point::origin(), 0.0), &Point::origin()).unwrap();
        let robot = Pose::new(0.0, -0.8, 1.6);
        let place = describe(&Lpm::new(grid, robot), &PerceptionParameters::default()).unwrap();
        let visits: Vec<Visited> = (0..5)
            .map(|observation| {
                let place = if observation == 3 { Err("no way out".to_owned()) } else { Ok(&place) };
                Visited { observation, robot, rejected: &[], place }
            })
            .collect();
        let picture = visits_svg(&visits);
        for visit in 0..5 {
            assert!(picture.contains(&format!("Visit {visit}")), "{visit}");
        }
        assert_eq!(picture.matches("Small-scale star").count(), 4);
        assert_eq!(picture.matches("came in on slot 0, heading").count(), 4);
        assert_eq!(picture.matches("least margin").count(), 4);
        assert_eq!(picture.matches("no way out").count(), 1);
        assert!(visits_svg(&[]).contains("<svg"));
    }
}
