//! Where the robot came into a place, and where it left it: when it passed the line of a gateway.

use crate::gateway::Gateway;
use crate::geometry::Point;
use crate::visit::Moment;

/// A robot that passes a gateway may be this far beside it, metres: its half width.
const BESIDE: f64 = 0.3;

/// The first moment at which the robot was at the place, and the first at which it had left it, by the lines of its
/// gateways. `way` is all that is known of its way; at the scans `inside` it is at the place. A robot that was at the
/// place when the log began or ended came in with the first moment, or left with the last; nothing if nothing is known
/// of its way.
pub(super) fn passages(
    way: &[Moment],
    inside: [usize; 2],
    center: &Point,
    gateways: &[Gateway],
) -> Option<[Moment; 2]> {
    let outside = |moment: &Moment| {
        let at = moment.local_from_robot.position() - center.coords;
        gateways.iter().any(|gateway| is_beyond(gateway, &at))
    };
    let before = way.partition_point(|moment| moment.scan <= inside[0]);
    let after = way.partition_point(|moment| moment.scan < inside[1]);
    let came = way[..before].iter().rposition(outside).map_or(0, |last| last + 1);
    let left = way[after..].iter().position(outside).map_or(way.len(), |first| after + first);
    let last = way.last()?;
    Some([*way.get(came).unwrap_or(last), *way.get(left).unwrap_or(last)])
}

/// Whether a point lies beyond the line of a gateway, in the strip as wide as the gateway.
fn is_beyond(gateway: &Gateway, at: &Point) -> bool {
    let offset = at - gateway.center;
    let outward = gateway.outward();
    outward.dot(&offset) >= 0.0 && outward.perp(&offset).abs() <= gateway.width / 2.0 + BESIDE
}
