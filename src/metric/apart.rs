//! Axiom `apart`: two places do not lie on one spot.
//!
//! Where the robot stood at two different places is at least [`MetricParameters::separation`] apart, or as far as the
//! shortest travel so far has led, if that is less. A new place is refuted where the layout of all visits
//! ([`crate::metric::layout`]) knows better even at the far end of the gate. So a loop that closes with certainty has
//! to be closed. A loop closed tells more of all places: then any two are compared by where they were first visited.
//!
//! [`MetricParameters::separation`]: crate::metric::MetricParameters::separation

use crate::abduction::Outcome;
use crate::metric::breach::Breach;
use crate::metric::frames::Story;
use crate::metric::layout::{Layout, Span};

/// Two visits to different places that share one spot.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    let latest = story.latest();
    story.stays[latest].travelled?.leg?;
    let separation = separation(story);
    let Outcome::NewPlace = story.outcome else {
        let layout = Layout::new(story, latest + 1)?;
        let first = |place: usize| story.first_visit(place);
        let mut pairs = (0..story.places()).flat_map(|to| (0..to).map(move |from| (from, to)));
        return pairs.find_map(|(from, to)| {
            shared(story, &layout, Span { from: first(from), to: first(to) }, separation)
        });
    };
    let layout = story.layout()?;
    (0..latest).find_map(|from| shared(story, layout, Span { from, to: latest }, separation))
}

/// How two visits share one spot, if they do.
fn shared(story: &Story<'_>, layout: &Layout, span: Span, separation: f64) -> Option<Breach> {
    if !layout.joins(span) {
        return None;
    }
    let [from, to] = [span.from, span.to].map(|visit| layout.poses[visit].position());
    let distance = (to - from).norm();
    if distance >= separation {
        return None;
    }
    let gate = story.parameters.position_gate.sqrt();
    let at_most = distance + layout.between(span, gate)?.radius(gate);
    (at_most < separation).then_some(Breach::Spot { span, at_most, separation })
}

/// How far apart two different places are at least.
fn separation(story: &Story<'_>) -> f64 {
    let travelled = story.stays.iter().filter_map(|stay| stay.travelled);
    travelled.map(|travelled| travelled.length).fold(story.parameters.separation, f64::min)
}
