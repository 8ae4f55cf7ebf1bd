//! Axiom `apart`: two places do not lie on one spot, and ways cross nowhere but at places.
//!
//! Where the robot stood at two different places is at least [`MetricParameters::separation`] apart, or as far as the
//! shortest travel so far has led, if that is less. A new place is refuted where the layout of all visits
//! ([`crate::metric::layout`]) puts it nearer to a known one, even at the far end of the gate. So a loop that closes with
//! certainty has to be closed. A loop closed tells more of all places: then any two visits to different places are
//! compared. Nothing is said where no likely errors close the loops.
//!
//! The far end of the gate is that of first order and of a bound on what it leaves out. Where that bound alone is in the
//! way, the two visits that first order puts nearest are looked at again by the profile of the likelihood
//! ([`crate::metric::profile`]).
//!
//! Then all places and path segments are looked at together: where one moves aside, what hangs on it moves too, and there must be
//! room for all ([`crate::metric::crowd`]).
//!
//! [`MetricParameters::separation`]: crate::metric::MetricParameters::separation

use crate::abduction::Outcome;
use crate::metric::breach::Breach;
use crate::metric::crowd::{Patience, Room};
use crate::metric::frames::Story;
use crate::metric::layout::{Layout, Span};
use crate::metric::segments::Segments;
use crate::metric::share::{SHARES, in_each, in_every};
use crate::metric::uncertainty::Uncertainty;
use std::cell::OnceCell;
use std::collections::BTreeSet;

/// Two visits to different places that share one spot, whatever share of errors explains the loops.
pub(super) fn breach(story: &Story<'_>) -> Option<Breach> {
    let latest = story.latest();
    story.stays[latest].travelled?.leg?;
    let separation = separation(story);
    let spots: [OnceCell<Option<Option<Breach>>>; SHARES.len()] = Default::default();
    let spot = |share: usize| {
        let spot = |layout: &Layout| match layout.agrees() {
            true => spot(story, layout, separation).map(Some),
            // A share under which the loops do not close is none that odometry has.
            false => Some(None),
        };
        spots[share].get_or_init(|| judged(story, share, spot)?).clone()
    };
    let crowd = |share: usize| {
        let crowd = |layout: &Layout| crowd(story, share, layout, separation).map(Some);
        spot(share).or_else(|| judged(story, share, crowd)?)
    };
    let breaches = in_every(spot).or_else(|| in_each(crowd))?;
    breaches.into_iter().flatten().next()
}

/// As [`crate::metric::Measurements::to_part`].
pub(super) fn to_part(
    story: &Story<'_>,
    span: Span,
    distance: f64,
    gate: f64,
) -> [Option<f64>; SHARES.len()] {
    let rim = |layout: &Layout| {
        let known = layout.agrees() && layout.joins(span);
        if known { layout.to_rim(span, distance, gate) } else { None }
    };
    std::array::from_fn(|share| judged(story, share, rim)?)
}

/// As [`crate::metric::Measurements::room`].
pub(super) fn room(story: &Story<'_>, share: usize, distance: f64, patience: Patience) -> Option<Room> {
    let room = |layout: &Layout| {
        let segments = Segments::new(story, &first_visits(story, layout), distance);
        layout.agrees().then(|| layout.room(&segments, distance, patience, None, story.problems).0)
    };
    judged(story, share, room)?
}

/// What is made of the layout that a proposal is judged in: by the loop that the latest travel closes too, if it does.
fn judged<T>(story: &Story<'_>, share: usize, make: impl Fn(&Layout) -> T) -> Option<T> {
    match story.outcome {
        Outcome::NewPlace => story.before(share).map(make),
        _ => story.after(share).map(|layout| make(&layout)),
    }
}

/// Two visits that share one spot in a layout.
fn spot(story: &Story<'_>, layout: &Layout, separation: f64) -> Option<Breach> {
    let latest = story.latest();
    let gate = layout.left(2, story.parameters.position_gate);
    // After a loop all visits may lie elsewhere.
    let least = if story.outcome == Outcome::NewPlace { latest } else { 1 };
    let pairs = (least..=latest).flat_map(|to| (0..to).map(move |from| Span { from, to }));
    // The two visits that first order alone puts nearest to each other.
    let mut nearest: Option<(f64, Span)> = None;
    for span in pairs.filter(|span| story.place(span.from) != story.place(span.to) && layout.joins(*span)) {
        let off = layout.poses[span.to].position() - layout.poses[span.from].position();
        if off.norm() >= separation {
            continue;
        }
        let known = Uncertainty { covariance: layout.between(span)?, slack: 0.0 };
        let first = known.at_most(&off, gate.sqrt());
        if first >= separation {
            continue;
        }
        let at_most = first + layout.slack(span, gate.sqrt());
        if at_most < separation {
            return Some(Breach::Spot { span, at_most, separation });
        }
        if nearest.is_none_or(|(least, _)| first < least) {
            nearest = Some((first, span));
        }
    }
    let (_, span) = nearest?;
    let chi_square = layout.to_rim(span, separation, gate)?;
    Some(Breach::Rim { span, chi_square, gate, separation })
}

/// Places and segments that are in each other's way in a layout, as far as it is known from before or found out. What is learned is
/// known of the child.
fn crowd(story: &Story<'_>, share: usize, layout: &Layout, separation: f64) -> Option<Breach> {
    let latest = story.latest();
    let segments = Segments::new(story, &first_visits(story, layout), separation);
    let at = |visit: usize| layout.poses[visit].position();
    let beside =
        |&(visit, _): &(usize, usize)| visit != latest && (at(visit) - at(latest)).norm() < separation;
    let obstructed = || {
        let found = segments.obstructions(&layout.poses, 0.0);
        found.iter().any(|obstruction| segments.concerns(obstruction, latest))
    };
    // A new place that is in nobody's way changes nothing, nor does the way to it.
    if story.outcome == Outcome::NewPlace && !segments.firsts.iter().any(beside) && !obstructed() {
        return None;
    }
    let (room, lessons) =
        layout.room(&segments, separation, Patience::Short, story.lessons(share), story.problems);
    story.learn(share, lessons);
    match room {
        Room::Lacking(crowd) => Some(Breach::Crowd { crowd, separation }),
        Room::Found(_) | Room::Unknown => None,
    }
}

/// The first visits to all places since the last travel that was not measured.
fn first_visits(story: &Story<'_>, layout: &Layout) -> Vec<usize> {
    let latest = story.latest();
    let measured = |&visit: &usize| layout.joins(Span { from: visit - 1, to: visit });
    let since = (1..=latest).rev().find(|visit| !measured(visit)).unwrap_or(0);
    let mut places = BTreeSet::new();
    (since..=latest).filter(|&visit| places.insert(story.place(visit))).collect()
}

/// How far apart two different places are at least.
fn separation(story: &Story<'_>) -> f64 {
    let travelled = story.stays.iter().filter_map(|stay| stay.travelled);
    travelled.map(|travelled| travelled.length).fold(story.parameters.separation, f64::min)
}
