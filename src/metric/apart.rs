//! Axiom `apart`: two places do not lie on one spot.
//!
//! Where the robot stood at two different places is at least [`MetricParameters::separation`] apart, or as far as the
//! shortest travel so far has led, if that is less. A new place is refuted where the least uncertain chain to some
//! visit knows better even at the far end of the gate. So a loop that closes with certainty has to be closed.
//!
//! [`MetricParameters::separation`]: crate::metric::MetricParameters::separation

use crate::abduction::Outcome;
use crate::metric::breach::Breach;
use crate::metric::chain::{Chains, Frame, Step};
use crate::metric::frames::Story;
use crate::metric::uncertainty::Composed;

/// The first visit whose spot the latest one, said to be to a new place, shares.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    let Outcome::NewPlace = story.outcome else { return None };
    let latest = story.latest();
    let leg = story.stays[latest].travelled?.leg?;
    let separation = separation(story);
    let gate = story.parameters.position_gate.sqrt();
    let direct = Step { leg, back: false, travel: Some(latest) };
    let chains = Chains::new(story);
    (0..latest).find_map(|visit| {
        let chain = Composed::new(chains.to(Frame::Visit(visit))?);
        let distance = (leg.pose.position() - chain.pose.position()).norm();
        if distance >= separation {
            return None;
        }
        let at_most = distance + chain.against(&direct, gate).radius(gate);
        (at_most < separation).then(|| Breach::Spot { visit, at_most, separation, chain: chain.into_steps() })
    })
}

/// How far apart two different places are at least.
fn separation(story: &Story<'_>) -> f64 {
    let travelled = story.stays.iter().filter_map(|stay| stay.travelled);
    travelled.map(|travelled| travelled.length).fold(story.parameters.separation, f64::min)
}
