//! Axiom `distance`: measured lengths of one path segment have a length in common.
//!
//! Each travel says that the points of the two places are as far apart as measured, up to so many standard
//! deviations of that length: what odometry is uncertain of along the way, and where in the two places the robot
//! stood. Lengths add along a path, but every travel goes along one path segment, so that no measurement speaks of a
//! sum: lengths that satisfy all of them exist if and only if each path segment for itself has one.

use crate::abduction::Outcome;
use crate::metric::breach::{Breach, Length};
use crate::metric::frames::Story;

/// Two travels along the path segment of the latest one whose intervals do not meet.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    let Outcome::Known { .. } = story.outcome else { return None };
    let latest = story.latest();
    let segment = story.ends(latest)?;
    let now = length(story, latest)?;
    let along = (1..latest).filter(|&visit| {
        story.ends(visit).is_some_and(|ends| ends == segment || ends == [segment[1], segment[0]])
    });
    let mut lengths = along.filter_map(|visit| length(story, visit));
    // Intervals on a line have a point in common if any two of them have, and those before do.
    let clashing = lengths.find(|before| before.least > now.most || before.most < now.least);
    clashing.map(|before| Breach::Length { segment, before, now })
}

/// The interval of length that the travel to a visit gives.
fn length(story: &Story<'_>, visit: usize) -> Option<Length> {
    let travelled = story.stays[visit].travelled?;
    let points = 2.0 * story.parameters.extent_sigma.powi(2);
    let reach = story.parameters.sigmas * (travelled.length_variance + points).sqrt();
    Some(Length { visit, least: travelled.length - reach, most: travelled.length + reach })
}
