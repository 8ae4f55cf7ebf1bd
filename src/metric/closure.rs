//! Axiom `closure`: displacements composed around every loop return to where they began, all loops taken together.
//!
//! A travel that comes to a known place closes a loop. Where it leads is predicted from all travels so far and from
//! all loops they closed ([`crate::metric::layout`]), which also tell how odometry drifts. The difference, weighed by
//! the covariance of the prediction and of the travel, stays within its gate, and together with what it took to close
//! all loops before within the gate of all. What passes is laid out with the loop closed: what chi-square that takes
//! more, linearised where it leads, stays within the same gates. Where bearings do not tell how the place is turned,
//! position alone is judged.

use crate::abduction::Outcome;
use crate::metric::breach::Breach;
use crate::metric::frames::Story;
use crate::metric::layout::{Layout, Loop, closed};
use crate::metric::share::in_every;
use crate::metric::uncertainty::quantile;
use nalgebra::Vector2;

/// How far the latest travel is from where the layout of all before puts its place, if no share explains it.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    if story.outcome == Outcome::NewPlace {
        return None;
    }
    let latest = story.latest();
    story.stays[latest].travelled?.leg?;
    let closing = closed(story, latest)?;
    let open = in_every(|share| open(story, story.before(share)?, &closing));
    open.or_else(|| in_every(|share| unlikely(story, share, &closing)))?.pop()
}

/// How a loop takes more than its gate, or all loops more than theirs, in the layout that closes them.
fn unlikely(story: &Story<'_>, share: usize, closing: &Loop) -> Option<Breach> {
    let ((before, known), (after, all)) =
        (story.before(share)?.chi_square(), story.after(share)?.chi_square());
    let alone =
        if closing.turn.is_some() { story.parameters.pose_gate } else { story.parameters.position_gate };
    let gate = alone.min(quantile(all) - before);
    let (chi_square, degrees) = (after - before, all - known);
    (chi_square > gate).then_some(Breach::Loops { chi_square, gate, degrees, span: closing.span })
}

/// How the loop does not close in a layout.
fn open(story: &Story<'_>, layout: &Layout, closing: &Loop) -> Option<Breach> {
    let (degrees, alone) = match closing.turn {
        Some(_) => (3, story.parameters.pose_gate),
        None => (2, story.parameters.position_gate),
    };
    let gate = if layout.agrees() { layout.left(degrees, alone) } else { alone };
    let (off, uncertainty) = layout.off(closing, gate.sqrt())?;
    let chi_square = match closing.turn {
        Some(_) => uncertainty.of_pose(&off, gate.sqrt()),
        None => uncertainty.of_position(&Vector2::new(off.x, off.y), gate.sqrt()),
    }?;
    let open = chi_square > gate || !layout.agrees();
    open.then_some(Breach::Loop { off, chi_square, gate, span: closing.span })
}
