//! Axiom `angle`: measured directions around one place agree, and headings close around every loop.
//!
//! *Around a place.* The bearing of a slot, as seen on a visit, is the direction of the slot at the place, less the
//! direction of the visit's frame, within a bound on either side, modulo a turn. Directions that satisfy all visits
//! to the place exist if and only if the constraints have no cycle that sums to less than nothing. The cut modulo a
//! turn is made once, where each visit lies best on the first: there no bearing is off by half a turn, unless bounds
//! reach an eighth of a turn, in which case nothing is judged.
//!
//! *Around a loop.* The headings of a travel that comes back to a known place and of the chain between its ends
//! differ by at most the sum of their bounds: a sum, as errors may be the same on all travels.

use crate::abduction::Outcome;
use crate::geometry::wrap_angle;
use crate::metric::breach::Breach;
use crate::metric::chain::{Chains, Frame, Step, link};
use crate::metric::frames::Story;
use std::f64::consts::FRAC_PI_4;

/// What does not agree with the directions known, if the latest travel came to a known place.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    if story.outcome == Outcome::NewPlace {
        return None;
    }
    around_place(story).or_else(|| around_loop(story))
}

/// Whether no directions of the slots satisfy all visits to the latest place.
fn around_place(story: &Story<'_>) -> Option<Breach> {
    let latest = story.latest();
    let bound = story.parameters.sigmas * story.parameters.bearing_sigma;
    let visits: Vec<usize> =
        story.visits_to(story.place(latest)).filter(|&v| story.turn(v).is_some()).collect();
    if bound >= FRAC_PI_4 || visits.last() != Some(&latest) {
        return None;
    }
    let slots = story.stays[latest].bearings.len();
    let mut directions: Vec<Option<f64>> = vec![None; slots];
    // At least, at most: how much more a visit's frame is turned than a slot's direction.
    let mut constraints = Vec::new();
    for (at, &visit) in visits.iter().enumerate() {
        let turn = story.turn(visit)?;
        for (slot, bearing) in story.bearings(visit) {
            let slot = slot.0 as usize;
            let direction = *directions[slot].get_or_insert(bearing + turn);
            let off = wrap_angle(bearing + turn - direction);
            constraints.push(Constraint { from: slots + at, to: slot, most: off + bound });
            constraints.push(Constraint { from: slot, to: slots + at, most: bound - off });
        }
    }
    let satisfiable = satisfiable(slots + visits.len(), &constraints);
    (!satisfiable).then_some(Breach::Bearings { visits, bound })
}

/// The value of one variable is at most so much more than that of another.
struct Constraint {
    from: usize,
    to: usize,
    most: f64,
}

/// Slack for the rounding of sums, radians.
const ROUNDING: f64 = 1e-9;

/// Whether difference constraints have a solution (Bellman 1958): variables times constraints at most, but mostly a
/// few rounds.
fn satisfiable(variables: usize, constraints: &[Constraint]) -> bool {
    let mut values = vec![0.0; variables];
    for _ in 0..=variables {
        let mut changed = false;
        for constraint in constraints {
            let most = values[constraint.from] + constraint.most;
            if values[constraint.to] > most + ROUNDING {
                values[constraint.to] = most;
                changed = true;
            }
        }
        if !changed {
            return true;
        }
    }
    false
}

/// How far the heading is from closing the loop of the latest travel and the least uncertain chain.
fn around_loop(story: &Story<'_>) -> Option<Breach> {
    let latest = story.latest();
    let direct = story.stays[latest].travelled?.leg?;
    let mut steps = Chains::new(story).to(Frame::Place(story.place(latest)))?;
    steps.push(Step { leg: link(story, latest)?, back: false, travel: None });
    let heading = |step: &Step| if step.back { -step.leg.pose.theta } else { step.leg.pose.theta };
    let reach = |step: &Step| {
        let odometry = step.leg.odometry.m33.sqrt() + step.leg.stay.m33.sqrt();
        story.parameters.sigmas * odometry
    };
    let off = wrap_angle(direct.pose.theta - steps.iter().map(heading).sum::<f64>());
    let direct = Step { leg: direct, back: false, travel: Some(latest) };
    let bound = reach(&direct) + steps.iter().map(reach).sum::<f64>();
    (off.abs() > bound).then_some(Breach::Heading { off, bound, chain: steps })
}
