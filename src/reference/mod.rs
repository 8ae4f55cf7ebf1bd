//! The slow reference: all assignments of observations to places, each checked from the definitions alone.
//!
//! Nothing here is clever, incremental or shared with [`crate::abduction`] but the [`Visit`], the input of both. A
//! [`Story`] takes each observation for a place and a rotation; a law is a question about a whole story. What the
//! search finds has to be what this finds: tests ask that of random worlds, `topostar check` of a user's trace. Of what
//! was measured it knows lengths and directions, [`Measured`].
//!
//! Costs are exponential in the visits, and polynomial of some degree for each story.

mod boundary;
mod laws;
mod measured;
mod planarity;
mod simplicity;
mod told;
pub mod views;

pub use boundary::{Evidence, abnormalities, beside};
pub use laws::{DEFAULT, PAPER, UNKNOWN, knows, obeys};
pub use measured::{Interval, MEASURED, Measured};
pub use simplicity::{minimal, size};
pub use told::{End, Story, segments, travels};

use crate::abduction::Visit;
use laws::obeys_all;

/// All stories under which the laws hold, in lexicographic order. With `prune`, stories whose beginning breaks a
/// law are not followed; the laws are monotone, so that the answer is the same.
pub fn explanations(visits: &[Visit], laws: &[&str], prune: bool) -> Vec<Story> {
    let mut stories = beginning(visits);
    for last in 1..visits.len() {
        let visits = &visits[..=last];
        stories = match prune {
            true => extensions(visits, &stories, laws),
            false => stories.iter().flat_map(|story| children(visits, story)).collect(),
        };
    }
    stories.retain(|story| obeys_all(visits, story, laws));
    stories
}

/// The stories of the first visit alone, which no law speaks against: it is to place 0. None if there is no visit.
pub fn beginning(visits: &[Visit]) -> Vec<Story> {
    visits.first().map(|_| vec![(0, 0)]).into_iter().collect()
}

/// The stories of all visits that begin with one of some stories of all visits but the last, and obey the laws. In
/// lexicographic order, if the stories are.
pub fn extensions(visits: &[Visit], stories: &[Story], laws: &[&str]) -> Vec<Story> {
    let children = stories.iter().flat_map(|story| children(visits, story));
    children.filter(|story| obeys_all(visits, story, laws)).collect()
}

/// The story gone on with in every way: the next visit to each known place, turned in each way, or to a new place.
fn children(visits: &[Visit], story: &Story) -> impl Iterator<Item = Story> {
    let known = told::place_count(story);
    let rotations = visits.get(story.len()).map_or(0, |visit| visit.star.size());
    let old = (0..known).flat_map(move |place| (0..rotations).map(move |rotation| (place, rotation)));
    old.chain([(known, 0)]).map(|step| [story.as_slice(), &[step]].concat())
}
