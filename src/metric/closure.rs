//! Axiom `closure`: displacements composed around every loop return to where they began, all loops taken together.
//!
//! A travel that comes to a known place closes a loop. Where it leads is predicted from all travels so far and from
//! all loops they closed ([`crate::metric::layout`]), which also tell how odometry drifts. The difference, weighed by
//! the covariance of the prediction and of the travel, stays within the gate. Loops whose travels were all made
//! before have been judged before. Where bearings do not tell how the place is turned, position alone is judged.

use crate::abduction::Outcome;
use crate::metric::breach::Breach;
use crate::metric::frames::Story;
use crate::metric::layout::closed;
use nalgebra::Vector2;

/// How far the latest travel is from where the layout of all before puts its place.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    if story.outcome == Outcome::NewPlace {
        return None;
    }
    let latest = story.latest();
    story.stays[latest].travelled?.leg?;
    let closing = closed(story, latest)?;
    let gate = match closing.turn {
        Some(_) => story.parameters.pose_gate,
        None => story.parameters.position_gate,
    };
    let (off, uncertainty) = story.layout()?.off(&closing, gate.sqrt())?;
    let chi_square = match closing.turn {
        Some(_) => uncertainty.of_pose(&off, gate.sqrt()),
        None => uncertainty.of_position(&Vector2::new(off.x, off.y), gate.sqrt()),
    }?;
    (chi_square > gate).then_some(Breach::Loop { off, chi_square, gate, span: closing.span })
}
