//! Reads the recorded traces in `worlds/` as visits: stars, turns and travels only.

use serde_json::Value;
use topostar::abduction::Visit;
use topostar::star::{ControlLaw, Direction, FragmentId, GatewayId, Slot, SlotIndex, SmallScaleStar};

/// The visits of a trace file of `worlds/`, by its name without ending.
pub(crate) fn visits(name: &str) -> Vec<Visit> {
    let path = format!("{}/worlds/{name}.ndjson", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let mut visits: Vec<Visit> = Vec::new();
    let mut facing = None;
    for line in text.lines() {
        let event: Value = serde_json::from_str(line).unwrap();
        match event["kind"].as_str().unwrap() {
            "observation" => {
                let star = star(&event["star"]["slots"]).large_scale();
                let arrival = slot_index(&event["dstate"]);
                visits.push(Visit { departure: facing, star, arrival });
                facing = Some(arrival);
            }
            "turn" => facing = Some(slot_index(&event["to"])),
            "travel" => (),
            kind => panic!("{path}: unknown kind {kind}"),
        }
    }
    visits
}

fn slot_index(value: &Value) -> SlotIndex {
    SlotIndex(value.as_u64().unwrap() as u8)
}

fn star(slots: &Value) -> SmallScaleStar {
    let gateway = |value: &Value| value.as_u64().map(|id| GatewayId(id as u32));
    let slot = |slot: &Value| Slot {
        fragment: FragmentId(slot["fragment"].as_u64().unwrap() as u32),
        direction: if slot["direction"] == "+" { Direction::Plus } else { Direction::Minus },
        outward: gateway(&slot["out"]),
        inward: gateway(&slot["in"]),
        control: control(slot["control"].as_str().unwrap()),
        bearing: None,
        width: None,
        margin: None,
    };
    SmallScaleStar::new(slots.as_array().unwrap().iter().map(slot).collect()).unwrap()
}

fn control(name: &str) -> ControlLaw {
    match name {
        "midline" => ControlLaw::Midline,
        "left_wall" => ControlLaw::LeftWall,
        "right_wall" => ControlLaw::RightWall,
        "dead_end" => ControlLaw::DeadEnd,
        "none" => ControlLaw::None,
        name => panic!("unknown control law {name}"),
    }
}
