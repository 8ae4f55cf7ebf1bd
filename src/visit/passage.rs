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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Vector, direction};
    use nalgebra::Matrix3;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    const WIDTH: f64 = 2.0;

    fn gateway(away: f64, bearing: f64) -> Gateway {
        let (center, left) = (Point::origin() + direction(bearing) * away, direction(bearing + PI / 2.0));
        let ends = [center + left * (WIDTH / 2.0), center - left * (WIDTH / 2.0)];
        let (width, passage) = (WIDTH, WIDTH);
        Gateway { center, ends, bearing, read_error: 0.0, width, passage, margin: 1.0, beyond: Vec::new() }
    }

    fn way(points: impl Iterator<Item = Point>) -> Vec<Moment> {
        let moment = |(scan, at): (usize, Point)| Moment {
            scan,
            local_from_robot: Pose { x: at.x, y: at.y, theta: 0.0 },
            drift: Matrix3::zeros(),
            driven: 0.0,
        };
        points.enumerate().map(moment).collect()
    }

    proptest! {
        /// A robot that comes along one corridor and leaves by another passes the lines where they lie, whichever scans it is
        /// known to be inside at; also where it drove about beyond one of them before, and beside a gateway on its way.
        #[test]
        fn a_robot_came_and_left_where_it_passed_the_lines(
            (x, y) in (-50.0..50.0f64, -50.0..50.0f64),
            (from, to) in (-3.1..3.1f64, -3.1..3.1f64),
            (came_by, left_by) in (0.5..2.0f64, 0.5..2.0f64),
            (early, late) in (0.0..0.99f64, 0.0..0.99f64),
            turns in prop::collection::vec(0.0..1.0f64, 0..3),
        ) {
            let center = Point::new(x, y);
            prop_assume!((from - to).cos() < 0.0);
            let gateways = [gateway(came_by, from), gateway(left_by, to)];
            // Metres along the way: to and fro outside, in, and out again.
            let start = 6.0;
            let ins = turns.iter().flat_map(|&turn| [start, came_by + 0.3 + turn]).chain([start, 0.0]);
            let mut inward: Vec<f64> = vec![start];
            for to in ins {
                let at = inward[inward.len() - 1];
                let steps = ((to - at).abs() / 0.1).ceil() as usize;
                inward.extend((1..=steps).map(|k| at + (to - at) * k as f64 / steps as f64));
            }
            let outward: Vec<f64> = (1..60).map(|k| 0.1 * f64::from(k)).collect();
            let at = |along: Vector, far: f64| center + along * far;
            let points = inward.iter().map(|&far| at(direction(from), far));
            let way = way(points.chain(outward.iter().map(|&far| at(direction(to), far))));
            let came = inward.iter().rposition(|&far| far >= came_by).unwrap() + 1;
            let left = inward.len() + outward.iter().position(|&far| far >= left_by).unwrap();
            let within = |share: f64, [low, high]: [usize; 2]| low + (share * (high - low) as f64) as usize;
            let first = within(early, [came, left]);
            let inside = [first, within(late, [first, left])];
            let found = passages(&way, inside, &center, &gateways).unwrap();
            prop_assert_eq!(found.map(|moment| moment.scan), [came, left]);
        }
    }

    /// Beyond the line of a gateway is only what lies in its strip.
    #[test]
    fn beside_a_gateway_is_not_beyond_it() {
        let east = gateway(1.0, 0.0);
        let sides =
            [(1.0, 0.0), (5.0, 1.29), (5.0, -1.29), (0.99, 0.0), (5.0, 1.31), (5.0, -1.31), (-5.0, 0.0)];
        let beyond = sides.map(|(x, y)| is_beyond(&east, &Point::new(x, y)));
        assert_eq!(beyond, [true, true, true, false, false, false, false]);
    }

    #[test]
    fn without_gateways_the_whole_way_is_at_the_place() {
        let all = way((0..5).map(|k| Point::new(f64::from(k), 0.0)));
        let found = passages(&all, [2, 3], &Point::origin(), &[]).unwrap();
        assert_eq!(found.map(|moment| moment.scan), [0, 4]);
        assert_eq!(passages(&[], [0, 0], &Point::origin(), &[]), None);
    }
}
