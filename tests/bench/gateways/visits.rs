//! The stars of the ACES visits.

use crate::aces;
use crate::maps;
use topostar::star::{PerceptionParameters, describe};

pub(super) fn print() {
    let visits = aces::load();
    let parameters = PerceptionParameters::default();
    println!("\nvisits to the places of the ACES building");
    for (k, visit) in visits.iter().enumerate() {
        match describe(&visit.lpm, &parameters) {
            Ok(place) => {
                let slot = |slot: &topostar::star::Slot| {
                    let way = if slot.outward.is_some() { "" } else { "-" };
                    let degrees = slot.bearing.unwrap_or(f64::NAN).to_degrees();
                    format!("{way}{:?} {degrees:.0} ({:.2})", slot.control, slot.margin.unwrap_or(f64::NAN))
                };
                let slots: Vec<String> = place.star.slots().iter().map(slot).collect();
                println!("  {k:2} {:2}  {}", visit.place, slots.join(", "));
                maps::draw(&place, &visit.lpm.robot_pose, &format!("visit-{k:02}"));
            }
            Err(why) => println!("  {k:2} {:2}  {why}", visit.place),
        }
    }
    let stars = aces::stars(&visits, &parameters);
    println!(
        "  as a person sees them: {}; alike at every visit: {}",
        aces::as_seen(&visits, &stars),
        aces::alike(&visits, &stars)
    );
}
