//! How simple a story is.

use crate::abduction::Visit;
use crate::reference::abnormalities;
use crate::reference::told::{End, Story, Told};
use std::collections::{BTreeMap, BTreeSet};

/// The simplest of some stories, all that are equally simple; with `soft` boundaries those of the fewest
/// abnormalities first.
pub fn minimal(visits: &[Visit], stories: &[Story], soft: bool) -> Vec<Story> {
    let simplicity = |story: &Story| (soft.then(|| abnormalities(visits, story)), size(visits, story));
    let least = stories.iter().map(simplicity).min();
    stories.iter().filter(|story| Some(simplicity(story)) == least).cloned().collect()
}

/// The number of paths, travelled or not, and of places.
pub fn size(visits: &[Visit], story: &Story) -> (usize, usize) {
    let told = Told::new(visits, story);
    // Each dstate its own label; dstates of one path take the least, until nothing changes.
    let mut labels: BTreeMap<End, End> = told.ends().into_iter().map(|end| (end, end)).collect();
    let mut joined: Vec<(End, End)> = told.ends().into_iter().map(|end| (end, told.opposite(end))).collect();
    joined.extend(told.segments());
    loop {
        let before = labels.clone();
        for (a, b) in &joined {
            let least = labels[a].min(labels[b]);
            labels.extend([(*a, least), (*b, least)]);
        }
        if labels == before {
            return (labels.into_values().collect::<BTreeSet<End>>().len(), told.stars.len());
        }
    }
}
