//! The control law for travel away from a place through an outward gateway.

use crate::gateway::{Beyond, Gateway};
use crate::star::ControlLaw;

/// The law that applies on most of the way beyond the gateway, and how sure that is: Midline between two walls,
/// LeftWall or RightWall along the only one within the comfort distance, None without any.
pub(super) fn outward_control(gateway: &Gateway) -> (ControlLaw, f64) {
    let share = |near: fn(&Beyond) -> bool| {
        let count = gateway.beyond.iter().filter(|&point| near(point)).count();
        count as f64 / gateway.beyond.len().max(1) as f64
    };
    let (left, right) = (share(|point| point.left), share(|point| point.right));
    let control = match (left >= 0.5, right >= 0.5) {
        (true, true) => ControlLaw::Midline,
        (true, false) => ControlLaw::LeftWall,
        (false, true) => ControlLaw::RightWall,
        (false, false) => ControlLaw::None,
    };
    let margin = (2.0 * left - 1.0).abs().min((2.0 * right - 1.0).abs());
    (control, margin)
}
