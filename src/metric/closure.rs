//! Axiom `closure`: displacements composed around a loop return to where they began.
//!
//! A travel that comes to a known place, along a path segment known or new, closes a loop with every chain of
//! measurements between its ends. It must agree with the least uncertain one: their difference, weighed by the
//! covariance of both ([`crate::metric::uncertainty`]), stays within the gate. Loops whose travels were all made
//! before have been judged before. Where bearings do not tell how the place is turned, position alone is judged.

use crate::abduction::Outcome;
use crate::geometry::{Pose, wrap_angle};
use crate::metric::breach::Breach;
use crate::metric::chain::{Chains, Frame, Step, link};
use crate::metric::frames::Story;
use crate::metric::leg::Leg;
use crate::metric::uncertainty::Composed;
use nalgebra::{Matrix3, Vector2, Vector3};

/// How far the latest travel is from where the least uncertain chain comes to.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    if story.outcome == Outcome::NewPlace {
        return None;
    }
    let latest = story.latest();
    let leg = story.stays[latest].travelled?.leg?;
    let mut steps = Chains::new(story).to(Frame::Place(story.place(latest)))?;
    let turned = link(story, latest);
    steps.push(Step { leg: turned.unwrap_or_else(|| unturned(story)), back: false, travel: None });
    let chain = Composed::new(steps);
    let off = difference(&leg.pose, &chain.pose);
    let direct = Step { leg, back: false, travel: Some(latest) };
    let gate = match turned {
        Some(_) => story.parameters.pose_gate,
        None => story.parameters.position_gate,
    };
    let uncertainty = chain.against(&direct, gate.sqrt());
    let chi_square = match turned {
        Some(_) => uncertainty.of_pose(&off, gate.sqrt()),
        None => uncertainty.of_position(&Vector2::new(off.x, off.y), gate.sqrt()),
    }?;
    (chi_square > gate).then(|| Breach::Loop { off, chi_square, gate, chain: chain.into_steps() })
}

/// The position of a visit in the frame of its place, whatever its heading.
fn unturned(story: &Story<'_>) -> Leg {
    let extent = story.parameters.extent_sigma.powi(2);
    let stay = Matrix3::from_diagonal(&Vector3::new(extent, extent, 0.0));
    Leg { pose: Pose::IDENTITY, odometry: Matrix3::zeros(), stay }
}

fn difference(a: &Pose, b: &Pose) -> Vector3<f64> {
    Vector3::new(a.x - b.x, a.y - b.y, wrap_angle(a.theta - b.theta))
}
