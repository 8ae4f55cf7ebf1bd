//! The clockwise listing of a place's directed path fragments (seed, section 4.3).

use crate::gateway::Gateway;
use crate::geometry::{Point, bearing, clockwise_from, wrap_angle};
use crate::star::control::outward_control;
use crate::star::fragments::Fragment;
use crate::star::projection::Projection;
use crate::star::{ControlLaw, Direction, FragmentId, GatewayId, Slot};
use std::f64::consts::PI;

/// A directed path fragment before it has a place in the listing. Gateways are indices as found.
#[derive(Clone, Debug)]
pub(super) struct Directed {
    /// Index of the fragment as found.
    pub(super) fragment: usize,
    pub(super) outward: Option<usize>,
    pub(super) inward: Option<usize>,
    /// Where it leaves the place, seen from the middle, radians.
    position: f64,
    control: ControlLaw,
    /// Heading of the robot that faces this way, radians.
    pub(super) bearing: f64,
    width: f64,
    margin: f64,
}

/// Both directions of every fragment. Outward ends lie at their gateways, and terminating inward ends where their
/// projection ends.
pub(super) fn directed(
    center: &Point,
    gateways: &[Gateway],
    fragments: &[Fragment],
    projections: &[Option<Projection>],
) -> Vec<Directed> {
    let mut all = Vec::new();
    for (index, fragment) in fragments.iter().enumerate() {
        let outward = |gateway: usize, inward: Option<usize>| {
            let (control, sure) = outward_control(&gateways[gateway]);
            Directed {
                fragment: index,
                outward: Some(gateway),
                inward,
                position: bearing(&(gateways[gateway].center - center)),
                control,
                bearing: gateways[gateway].bearing,
                width: gateways[gateway].width,
                margin: sure.min(gateways[gateway].margin).min(fragment.margin),
            }
        };
        all.push(outward(fragment.gateway, fragment.partner));
        if let Some(partner) = fragment.partner {
            all.push(outward(partner, Some(fragment.gateway)));
        } else if let Some(projection) = projections[index] {
            let gateway = &gateways[fragment.gateway];
            all.push(Directed {
                outward: None,
                inward: Some(fragment.gateway),
                position: bearing(&(projection.end - center)),
                control: projection.control,
                bearing: wrap_angle(gateway.bearing + PI),
                margin: projection.margin.min(gateway.margin).min(fragment.margin),
                ..outward(fragment.gateway, None)
            });
        }
    }
    all
}

/// The directed fragments clockwise from the one at `start`.
pub(super) fn clockwise(mut all: Vec<Directed>, start: usize) -> Vec<Directed> {
    let Some(from) = all.get(start).map(|first| first.position) else { return all };
    let first = all.remove(start);
    all.sort_by(|a, b| clockwise_from(from, a.position).total_cmp(&clockwise_from(from, b.position)));
    all.insert(0, first);
    all
}

/// The slots of a listing, numbered as the seed's figures are: gateways clockwise by their outward sides, fragments
/// by first appearance, `+` being the direction of the first appearance. Also the gateways' indices as found, in
/// the order of their numbers.
pub(super) fn number(listing: &[Directed]) -> (Vec<Slot>, Vec<usize>) {
    let order: Vec<usize> = listing.iter().filter_map(|one| one.outward).collect();
    let number = |gateway: usize| {
        let position = order.iter().position(|&other| other == gateway)?;
        Some(GatewayId(position as u32 + 1))
    };
    let mut seen: Vec<usize> = Vec::new();
    let slot = |one: &Directed| {
        let known = seen.iter().position(|&fragment| fragment == one.fragment);
        if known.is_none() {
            seen.push(one.fragment);
        }
        Slot {
            fragment: FragmentId(known.unwrap_or(seen.len() - 1) as u32 + 1),
            direction: if known.is_none() { Direction::Plus } else { Direction::Minus },
            outward: one.outward.and_then(number),
            inward: one.inward.and_then(number),
            control: one.control,
            bearing: Some(one.bearing),
            width: Some(one.width),
            margin: Some(one.margin),
        }
    };
    (listing.iter().map(slot).collect(), order)
}
