//! How a measured axiom is broken, and the words for it.

use crate::abduction::Clash;
use crate::map::{DstateId, PlaceId};
use crate::metric::chain::Step;
use crate::metric::crowd::{Crowd, InTheWay};
use crate::metric::frames::Story;
use crate::metric::layout::Span;
use nalgebra::Vector3;

/// What does not agree. Angles in radians, lengths in metres.
#[derive(Clone, Debug)]
pub(super) enum Breach {
    /// Two lengths of one path segment.
    Length { segment: [DstateId; 2], before: Length, now: Length },
    /// The bearings of the slots of one place.
    Bearings { visits: Vec<usize>, bound: f64 },
    /// The heading around a loop.
    Heading { off: f64, bound: f64, chain: Vec<Step> },
    /// The displacement around a loop.
    Loop { off: Vector3<f64>, chi_square: f64, gate: f64, span: Span },
    /// The displacement around a loop, once all that was before has given way to it.
    Loops { chi_square: f64, gate: f64, degrees: usize, span: Span },
    /// The spots of two places.
    Spot { span: Span, at_most: f64, separation: f64 },
    /// The same, by what it takes to have them apart.
    Rim { span: Span, chi_square: f64, gate: f64, separation: f64 },
    /// The room of all places and segments, by what it takes that all have it; some of these are in each other's way.
    Crowd { crowd: Crowd, separation: f64 },
}

/// An interval of length, and the visit that the travel measured led to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Length {
    pub(super) visit: usize,
    pub(super) least: f64,
    pub(super) most: f64,
}

impl Breach {
    /// The breach as what clashes.
    pub(super) fn clash(&self, story: &Story<'_>) -> Clash {
        let latest = story.latest();
        match self {
            Breach::Length { segment, before, now } => {
                let words = format!(
                    "the path segment {} - {} is {} long by the travel to observation {}, and {} by the travel to \
                     observation {}",
                    segment[0],
                    segment[1],
                    before.words(),
                    before.visit,
                    now.words(),
                    now.visit,
                );
                clash(story, vec![before.visit, now.visit], vec![*segment], words)
            }
            Breach::Bearings { visits, bound } => {
                let words = format!(
                    "no directions of the slots of place {} lie within {:.1} degrees of the bearings seen on \
                     {} visits",
                    story.place(latest),
                    bound.to_degrees(),
                    visits.len(),
                );
                clash(story, visits.clone(), Vec::new(), words)
            }
            Breach::Heading { off, bound, chain } => {
                let words = format!(
                    "the heading is {:.1} degrees from closing the loop through {} other travels, whose bound is \
                     {:.1} degrees",
                    off.to_degrees(),
                    travels(chain).len(),
                    bound.to_degrees(),
                );
                around(story, chain, words)
            }
            Breach::Loop { off, chi_square, gate, span } => {
                let words = format!(
                    "the travel ends {:.2} m and {:.1} degrees from where all travels and the loops they closed put \
                     place {}: chi-square {chi_square:.1}, gate {gate:.1}",
                    off.x.hypot(off.y),
                    off.z.to_degrees(),
                    story.place(latest),
                );
                over(story, *span, words)
            }
            Breach::Loops { chi_square, gate, degrees, span } => {
                let words = format!(
                    "no likely errors of all travels close this loop and all before it at once: it takes chi-square \
                     {chi_square:.1} more, gate {gate:.1} for {degrees} degrees of freedom",
                );
                over(story, *span, words)
            }
            Breach::Spot { span, at_most, separation } => {
                let words = format!(
                    "by all travels and the loops they closed, the robot stood at {} at most {at_most:.2} m from \
                     where it stood at {}; two places are at least {separation:.2} m apart",
                    stood(story, span.to),
                    stood(story, span.from),
                );
                over(story, *span, words)
            }
            Breach::Rim { span, chi_square, gate, separation } => {
                let words = format!(
                    "all travels and the loops they closed put the robot at {} nearer to where it stood at {} than \
                     the {separation:.2} m that two places are apart at least: to have them apart takes chi-square \
                     {chi_square:.1} more at least, gate {gate:.1}",
                    stood(story, span.to),
                    stood(story, span.from),
                );
                over(story, *span, words)
            }
            Breach::Crowd { crowd, separation } => {
                let Crowd { chi_square, gate, clashing } = crowd;
                let visits = || clashing.iter().flat_map(InTheWay::visits);
                let span =
                    Span { from: visits().min().unwrap_or(latest), to: visits().max().unwrap_or(latest) };
                let pairs: Vec<String> =
                    clashing.iter().map(|pair| in_the_way(story, pair, *separation)).collect();
                let words = format!(
                    "all travels and the loops they closed leave no room: it takes chi-square {chi_square:.1} more \
                     at least, gate {gate:.1}, to have {}",
                    pairs.join("; "),
                );
                over(story, span, words)
            }
        }
    }
}

/// What it would be to have two things out of each other's way, in words.
fn in_the_way(story: &Story<'_>, pair: &InTheWay, separation: f64) -> String {
    let segment = |[from, to]: [usize; 2]| format!("segment {} - {}", story.place(from), story.place(to));
    match *pair {
        InTheWay::Places(span) => {
            let [from, to] = [span.from, span.to].map(|visit| story.place(visit));
            format!("places {from} and {to} {separation:.2} m apart")
        }
        InTheWay::Segments(one, other) => format!("{} not across {}", segment(one), segment(other)),
        InTheWay::Passing(passing, visit) => {
            format!("{} not through place {}", segment(passing), story.place(visit))
        }
    }
}

fn stood(story: &Story<'_>, visit: usize) -> String {
    format!("place {} on observation {visit}", story.place(visit))
}

impl Length {
    fn words(&self) -> String {
        format!("{:.2} to {:.2} m", self.least.max(0.0), self.most)
    }
}

/// The visits that the travels of a chain led to.
fn travels(chain: &[Step]) -> Vec<usize> {
    chain.iter().filter_map(|step| step.travel).collect()
}

/// A clash of the latest travel with those of a chain.
fn around(story: &Story<'_>, chain: &[Step], words: String) -> Clash {
    let visits: Vec<usize> = travels(chain).into_iter().chain([story.latest()]).collect();
    let segments = visits.iter().filter_map(|&visit| story.ends(visit)).collect();
    let observations = visits.iter().flat_map(|&visit| [visit - 1, visit]).collect();
    clash(story, observations, segments, words)
}

/// A clash of all travels of a span.
fn over(story: &Story<'_>, span: Span, words: String) -> Clash {
    let segments = (span.from + 1..=span.to).filter_map(|visit| story.ends(visit)).collect();
    clash(story, (span.from..=span.to).collect(), segments, words)
}

fn clash(story: &Story<'_>, observations: Vec<usize>, segments: Vec<[DstateId; 2]>, words: String) -> Clash {
    let places: Vec<PlaceId> = observations.iter().map(|&visit| story.assignment(visit).place).collect();
    sorted(Clash { observations, places, segments, words })
}

/// Each thing once, ascending.
fn sorted(mut clash: Clash) -> Clash {
    clash.observations.sort_unstable();
    clash.observations.dedup();
    clash.places.sort_unstable();
    clash.places.dedup();
    for ends in &mut clash.segments {
        ends.sort_unstable();
    }
    clash.segments.sort_unstable();
    clash.segments.dedup();
    clash
}
