//! World files to worlds: everything is checked, and what is wrong is named by file and field.

use crate::geometry::{Point, clockwise_from, direction};
use crate::star::{ControlLaw, SlotIndex};
use crate::worlds::drawing::Drawing;
use crate::worlds::format::{
    WireControl, WireExpectation, WirePlace, WireSlot, WireTruth, WireWalk, WireWorld,
};
use crate::worlds::shapes::read_drawing;
use crate::worlds::world::{Exit, Expectation, Minimal, Place, PlaceSlot, SlotRef, Truth, Walk, World};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use thiserror::Error;

/// Why a world file was refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{file}: {field}: {message}")]
pub struct WorldError {
    /// Name of the file.
    pub file: String,
    /// The field at fault, such as `place[2].slots[0].out`; `.` for the whole file.
    pub field: String,
    /// What was found and what was expected.
    pub message: String,
}

/// The world written in a file; the name is that of the file without its ending.
pub fn load(name: &str, text: &str) -> Result<World, WorldError> {
    read(name, text).map_err(|Fault { field, message }| WorldError {
        file: format!("{name}.toml"),
        field,
        message,
    })
}

struct Fault {
    field: String,
    message: String,
}

fn fault<T>(field: impl Into<String>, message: impl Into<String>) -> Result<T, Fault> {
    Err(Fault { field: field.into(), message: message.into() })
}

fn read(name: &str, text: &str) -> Result<World, Fault> {
    let wire = parse(text)?;
    for (field, value) in [("title", &wire.title), ("story", &wire.story)] {
        if value.trim().is_empty() {
            return fault(field, "is empty, expected a few words");
        }
    }
    check_names(&wire.place)?;
    let places = wire
        .place
        .iter()
        .enumerate()
        .map(|(index, place)| read_place(&wire.place, index, place))
        .collect::<Result<Vec<_>, _>>()?;
    check_far_ends(&places)?;
    let drawing = read_drawing(&wire.drawing).map_err(|(field, message)| Fault { field, message })?;
    check_open(&drawing, &places)?;
    let walk = read_walk(&places, &wire.walk)?;
    let visits = walk.leave.len() + 1;
    Ok(World {
        name: name.into(),
        title: wire.title.trim().into(),
        story: wire.story.trim().into(),
        drawing,
        places,
        walk,
        paper: read_expectation("expect.paper", visits, wire.expect.paper)?,
        default: read_expectation("expect.default", visits, wire.expect.default)?,
    })
}

fn parse(text: &str) -> Result<WireWorld, Fault> {
    let whole = |e: toml::de::Error| Fault { field: ".".into(), message: e.to_string().trim_end().into() };
    let toml = toml::Deserializer::parse(text).map_err(whole)?;
    serde_path_to_error::deserialize(toml)
        .map_err(|e| Fault { field: e.path().to_string(), message: e.inner().message().into() })
}

fn check_names(places: &[WirePlace]) -> Result<(), Fault> {
    if places.is_empty() {
        return fault("place", "is empty, expected at least one place");
    }
    let mut names = BTreeSet::new();
    for (index, place) in places.iter().enumerate() {
        check_name(&mut names, &place.name, format!("place[{index}].name"))?;
        let mut slots = BTreeSet::new();
        for (slot, wire) in place.slots.iter().enumerate() {
            check_name(&mut slots, &wire.name, format!("place[{index}].slots[{slot}].name"))?;
        }
    }
    Ok(())
}

fn check_name<'a>(known: &mut BTreeSet<&'a str>, name: &'a str, field: String) -> Result<(), Fault> {
    if name.is_empty() || name.contains('.') {
        return fault(field, format!("is \"{name}\", expected a name without a dot"));
    }
    if !known.insert(name) {
        return fault(field, format!("is \"{name}\" a second time, expected names that differ"));
    }
    Ok(())
}

fn read_place(places: &[WirePlace], index: usize, wire: &WirePlace) -> Result<Place, Fault> {
    let field = format!("place[{index}]");
    if !wire.at.iter().all(|v| v.is_finite()) {
        return fault(format!("{field}.at"), "is not finite");
    }
    let slots = wire
        .slots
        .iter()
        .enumerate()
        .map(|(slot, _)| read_slot(places, wire, slot, &format!("{field}.slots[{slot}]")))
        .collect::<Result<Vec<_>, _>>()?;
    let place = Place { name: wire.name.clone(), at: Point::new(wire.at[0], wire.at[1]), slots };
    if let Err(error) = place.star(SlotIndex(0)) {
        return fault(format!("{field}.slots"), error.to_string());
    }
    check_clockwise(&place, &field)?;
    Ok(place)
}

fn read_slot(places: &[WirePlace], place: &WirePlace, slot: usize, field: &str) -> Result<PlaceSlot, Fault> {
    let wire = &place.slots[slot];
    if !wire.bearing.is_finite() {
        return fault(format!("{field}.bearing"), "is not finite, expected degrees");
    }
    if !(wire.reach.is_finite() && wire.reach > 0.0) {
        return fault(format!("{field}.reach"), format!("is {}, expected metres above 0", wire.reach));
    }
    let exit = read_exit(places, wire, field)?;
    let control = control_law(wire.control);
    let ends = matches!(control, ControlLaw::DeadEnd | ControlLaw::None);
    if ends && exit != Exit::Closed {
        return fault(format!("{field}.control"), "says that the way ends here, but `out` leads on");
    }
    if !ends && exit == Exit::Closed {
        return fault(
            format!("{field}.control"),
            "is a way to travel, but there is no `out`; expected dead_end or none",
        );
    }
    Ok(PlaceSlot {
        name: wire.name.clone(),
        opposite: opposite(&place.slots, slot, field)?,
        exit,
        control,
        bearing: wire.bearing.to_radians(),
        reach: wire.reach,
    })
}

fn read_exit(places: &[WirePlace], wire: &WireSlot, field: &str) -> Result<Exit, Fault> {
    match wire.out.as_deref() {
        None => Ok(Exit::Closed),
        Some("open") => Ok(Exit::Open),
        Some(far) => {
            let found = far.split_once('.').and_then(|(place, slot)| {
                let at = places.iter().position(|p| p.name == place)?;
                let slot = places[at].slots.iter().position(|s| s.name == slot)?;
                Some(SlotRef { place: at, slot: SlotIndex(u8::try_from(slot).ok()?) })
            });
            let message =
                || format!("is \"{far}\", expected \"open\" or the PLACE.slot of a place of this file");
            found.map(Exit::To).ok_or_else(|| Fault { field: format!("{field}.out"), message: message() })
        }
    }
}

fn opposite(slots: &[WireSlot], slot: usize, field: &str) -> Result<SlotIndex, Fault> {
    let fragment = slots[slot].fragment;
    let mut others = (0..slots.len()).filter(|&s| s != slot && slots[s].fragment == fragment);
    match (others.next().map(u8::try_from), others.next()) {
        (Some(Ok(other)), None) => Ok(SlotIndex(other)),
        _ => fault(
            format!("{field}.fragment"),
            format!("is {fragment}, expected every fragment on exactly two slots of the place"),
        ),
    }
}

fn check_clockwise(place: &Place, field: &str) -> Result<(), Fault> {
    let next = place.slots.iter().cycle().skip(1);
    let mut turned = 0.0;
    for (slot, (a, b)) in place.slots.iter().zip(next).enumerate() {
        turned += clockwise_from(a.bearing, b.bearing);
        let last = slot + 1 == place.slots.len();
        if turned > TAU + 1e-6 || (!last && turned > TAU - 1e-6) || a.bearing == b.bearing {
            return fault(
                format!("{field}.slots[{}].bearing", (slot + 1) % place.slots.len()),
                "comes out of order, expected slots listed clockwise (bearings fall)",
            );
        }
    }
    Ok(())
}

fn check_far_ends(places: &[Place]) -> Result<(), Fault> {
    for (p, place) in places.iter().enumerate() {
        for (s, slot) in place.slots.iter().enumerate() {
            let Exit::To(far) = slot.exit else { continue };
            let far_slot = &places[far.place].slots[far.slot.0 as usize];
            let here = SlotRef { place: p, slot: SlotIndex(s as u8) };
            if far_slot.exit != Exit::To(here) || far == here {
                let (far_place, near) = (&places[far.place].name, format!("{}.{}", place.name, slot.name));
                return fault(
                    format!("place[{p}].slots[{s}].out"),
                    format!(
                        "is \"{far_place}.{}\", whose own `out` is not \"{near}\"; expected far ends that agree",
                        far_slot.name
                    ),
                );
            }
        }
    }
    Ok(())
}

/// Every place and all its gateways must be where the robot can be.
fn check_open(drawing: &Drawing, places: &[Place]) -> Result<(), Fault> {
    for (p, place) in places.iter().enumerate() {
        if !drawing.contains(&place.at) {
            return fault(format!("place[{p}].at"), "is not in the open, expected a point of an open shape");
        }
        for (s, slot) in place.slots.iter().enumerate() {
            let gateway = place.at + direction(slot.bearing) * slot.reach;
            if slot.exit != Exit::Closed && !drawing.contains(&gateway) {
                let field = format!("place[{p}].slots[{s}].bearing");
                return fault(
                    field,
                    "points at a wall, expected the gateway `reach` metres away in the open",
                );
            }
        }
    }
    Ok(())
}

fn read_walk(places: &[Place], wire: &WireWalk) -> Result<Walk, Fault> {
    let start = wire.start.split_once('.').and_then(|(place, slot)| {
        let at = places.iter().position(|p| p.name == place)?;
        Some(SlotRef { place: at, slot: slot_named(&places[at], slot)? })
    });
    let Some(start) = start else {
        return fault("walk.start", format!("is \"{}\", expected the PLACE.slot faced first", wire.start));
    };
    let mut here = start.place;
    let mut leave = Vec::with_capacity(wire.leave.len());
    for (step, name) in wire.leave.iter().enumerate() {
        let field = format!("walk.leave[{step}]");
        let place = &places[here];
        let Some(slot) = slot_named(place, name) else {
            return fault(field, format!("is \"{name}\", expected a slot of {}", place.name));
        };
        let Exit::To(far) = place.slots[slot.0 as usize].exit else {
            return fault(field, format!("is \"{name}\", which leads from {} to no place", place.name));
        };
        leave.push(slot);
        here = far.place;
    }
    Ok(Walk { start, leave })
}

fn slot_named(place: &Place, name: &str) -> Option<SlotIndex> {
    let slot = place.slots.iter().position(|s| s.name == name)?;
    u8::try_from(slot).ok().map(SlotIndex)
}

fn read_expectation(field: &str, visits: usize, wire: WireExpectation) -> Result<Expectation, Fault> {
    if wire.candidates.len() != visits {
        let message =
            format!("has {} counts, expected one for each of {visits} visits", wire.candidates.len());
        return fault(format!("{field}.candidates"), message);
    }
    let truth = match wire.truth {
        WireTruth::Minimal => Truth::Minimal,
        WireTruth::Candidate => Truth::Candidate,
        WireTruth::Refuted { observation, .. } if observation >= visits => {
            let message = format!("is {observation}, expected an observation before {visits}");
            return fault(format!("{field}.truth.refuted.observation"), message);
        }
        WireTruth::Refuted { axiom, observation } => Truth::Refuted { axiom, observation },
    };
    let minimal = Minimal { paths: wire.minimal.paths, places: wire.minimal.places, ties: wire.minimal.ties };
    Ok(Expectation { candidates: wire.candidates, created: wire.created, minimal, truth })
}

fn control_law(wire: WireControl) -> ControlLaw {
    match wire {
        WireControl::Midline => ControlLaw::Midline,
        WireControl::LeftWall => ControlLaw::LeftWall,
        WireControl::RightWall => ControlLaw::RightWall,
        WireControl::DeadEnd => ControlLaw::DeadEnd,
        WireControl::None => ControlLaw::None,
    }
}
