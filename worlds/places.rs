//! The places of a world file: names, slots, far ends, and whether they fit the drawing.

use crate::geometry::{Point, clockwise_from, direction};
use crate::star::{ControlLaw, SlotIndex};
use crate::worlds::drawing::Drawing;
use crate::worlds::fault::{Fault, fault};
use crate::worlds::format::{WireControl, WirePlace, WireSlot};
use crate::worlds::world::{Exit, Place, PlaceSlot, SlotRef};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// The places of a file, in its order.
pub(super) fn read_places(wire: &[WirePlace], drawing: &Drawing) -> Result<Vec<Place>, Fault> {
    check_names(wire)?;
    let places = (0..wire.len()).map(|index| read_place(wire, index)).collect::<Result<Vec<_>, _>>()?;
    check_far_ends(&places)?;
    check_open(drawing, &places)?;
    Ok(places)
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

fn read_place(places: &[WirePlace], index: usize) -> Result<Place, Fault> {
    let wire = &places[index];
    let field = format!("place[{index}]");
    if !wire.at.iter().all(|v| v.is_finite()) {
        return fault(format!("{field}.at"), "is not finite");
    }
    let slots = (0..wire.slots.len())
        .map(|slot| read_slot(places, wire, slot, &format!("{field}.slots[{slot}]")))
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

fn control_law(wire: WireControl) -> ControlLaw {
    match wire {
        WireControl::Midline => ControlLaw::Midline,
        WireControl::LeftWall => ControlLaw::LeftWall,
        WireControl::RightWall => ControlLaw::RightWall,
        WireControl::DeadEnd => ControlLaw::DeadEnd,
        WireControl::None => ControlLaw::None,
    }
}
