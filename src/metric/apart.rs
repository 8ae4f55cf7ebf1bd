//! Axiom `apart`: two places do not lie on one spot.
//!
//! Where the robot stood at two different places is at least [`MetricParameters::separation`] apart, or as far as the
//! shortest travel so far has led, if that is less. A new place is refuted where the layout of all visits
//! ([`crate::metric::layout`]) puts it nearer to a known one, even at the far end of the gate. So a loop that closes with
//! certainty has to be closed. A loop closed tells more of all places: then any two visits to different places are
//! compared. Nothing is said where no likely errors close the loops.
//!
//! [`MetricParameters::separation`]: crate::metric::MetricParameters::separation

use crate::abduction::Outcome;
use crate::metric::breach::Breach;
use crate::metric::frames::Story;
use crate::metric::layout::{Layout, SHARES, Span, in_every};

/// Two visits to different places that share one spot, whatever share of errors explains the loops.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    let latest = story.latest();
    story.stays[latest].travelled?.leg?;
    let separation = separation(story);
    let breaches = in_every(|share| {
        let after;
        let layout = match story.outcome {
            Outcome::NewPlace => story.layout(share)?,
            _ => {
                after = Layout::new(story, latest + 1, SHARES[share])?;
                &after
            }
        };
        // A share under which the loops do not close is none that odometry has.
        if layout.agrees() { spot(story, layout, separation).map(Some) } else { Some(None) }
    })?;
    breaches.into_iter().flatten().next()
}

/// Two visits that share one spot in a layout.
fn spot(story: &Story<'_>, layout: &Layout, separation: f64) -> Option<Breach> {
    let latest = story.latest();
    if story.outcome == Outcome::NewPlace {
        let mut spans = (0..latest).map(|from| Span { from, to: latest });
        return spans.find_map(|span| shared(story, layout, span, separation));
    }
    let mut pairs = (0..=latest).flat_map(|to| (0..to).map(move |from| Span { from, to }));
    pairs.find_map(|span| match story.place(span.from) == story.place(span.to) {
        true => None,
        false => shared(story, layout, span, separation),
    })
}

/// How two visits share one spot, if they do.
fn shared(story: &Story<'_>, layout: &Layout, span: Span, separation: f64) -> Option<Breach> {
    if !layout.joins(span) {
        return None;
    }
    let [from, to] = [span.from, span.to].map(|visit| layout.poses[visit].position());
    if (to - from).norm() >= separation {
        return None;
    }
    let gate = layout.left(2, story.parameters.position_gate).sqrt();
    let at_most = layout.between(span, gate)?.at_most(&(to - from), gate);
    (at_most < separation).then_some(Breach::Spot { span, at_most, separation })
}

/// How far apart two different places are at least.
fn separation(story: &Story<'_>) -> f64 {
    let travelled = story.stays.iter().filter_map(|stay| stay.travelled);
    travelled.map(|travelled| travelled.length).fold(story.parameters.separation, f64::min)
}
