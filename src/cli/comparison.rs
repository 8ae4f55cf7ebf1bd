//! The search against the slow reference, and against clingo, candidate by candidate.

use crate::abduction::{Abduction, Axiom, AxiomSet, Candidate, Limits, Visit, VisitError};
use crate::export::profile_name;
use crate::reference::{self, Story};
use serde::Serialize;

/// What two or three judges found on their own, and whether it is the same.
#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    /// Version of this format: 1.
    pub(super) version: u32,
    /// The profile that holds exactly these axioms, or `custom`.
    pub(super) profile: &'static str,
    /// Observations of the trace.
    pub(super) observations: usize,
    /// Observations up to which all candidates were compared; what follows speaks of these.
    pub(super) compared: usize,
    /// Whether all judges found the same.
    pub(super) equal: bool,
    /// The first difference, if any.
    pub(super) difference: Option<Difference>,
    /// What the search found.
    pub(super) search: Found,
    /// What the reference found.
    pub(super) reference: Found,
    /// What clingo found; null if it was not asked.
    pub(super) clingo: Option<Found>,
    /// For each axiom held what it does.
    pub(super) axioms: Vec<Effect>,
}

/// What one judge found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Found {
    /// The number of candidates.
    pub(super) candidates: usize,
    /// The preferred ones: for each visit its place and rotation.
    pub(super) minimal: Vec<Story>,
    /// The paths and places of these.
    pub(super) size: Option<Size>,
}

/// How big a map is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Size {
    /// Paths, travelled or not.
    pub(super) paths: usize,
    /// Places.
    pub(super) places: usize,
}

/// A candidate that one judge has and another has not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Difference {
    /// The observation up to which the candidate explains the trace.
    pub(super) observation: usize,
    /// Who has it.
    pub(super) only: &'static str,
    /// Who has it not.
    pub(super) not: &'static str,
    /// Whether they differ about all candidates or about the preferred ones.
    pub(super) among: &'static str,
    /// For each visit its place and rotation.
    pub(super) visits: Story,
}

/// What an axiom does to the candidates.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Effect {
    /// The axiom.
    pub(super) axiom: &'static str,
    /// Why it was not tried without, if it was not.
    pub(super) untried: Option<&'static str>,
    /// How many candidates there are without it.
    pub(super) without: Option<usize>,
    /// How many of these break it, by the reference.
    pub(super) refutes: Option<usize>,
}

/// The search and the reference after the same observations, as long as they agree.
pub(super) struct Race<'a> {
    visits: &'a [Visit],
    laws: Vec<&'static str>,
    search: Abduction,
    stories: Vec<Story>,
}

/// How a race went on.
pub(super) enum Step {
    /// Both found the same.
    Agreed,
    /// Both would go on, but there are too many candidates to compare.
    TooMany,
    /// They found different candidates.
    Differ(Difference),
}

impl<'a> Race<'a> {
    /// A race before the first of some visits.
    pub(super) fn new(visits: &'a [Visit], axioms: AxiomSet, most: usize) -> Race<'a> {
        // One more than can be compared shows that there are too many.
        let limits = Limits { max_candidates: Some(most.saturating_add(1)) };
        let laws = axioms.iter().map(|axiom| axiom.name).collect();
        Race { visits, laws, search: Abduction::new(axioms, limits), stories: Vec::new() }
    }

    /// The number of candidates agreed on.
    pub(super) fn len(&self) -> usize {
        self.stories.len()
    }

    /// Takes the next observation, if there are not more than `most` candidates.
    pub(super) fn step(&mut self, most: usize) -> Result<Step, VisitError> {
        let observation = self.search.observations();
        let mut search = self.search.clone();
        search.observe(&self.visits[observation])?;
        if search.len() > most {
            return Ok(Step::TooMany);
        }
        let visits = &self.visits[..=observation];
        let stories = match observation {
            0 => reference::beginning(visits),
            _ => reference::extensions(visits, &self.stories, &self.laws),
        };
        let found = told(&search);
        (self.search, self.stories) = (search, stories);
        Ok(
            match Difference::first(
                observation,
                "candidates",
                ("search", &found),
                ("reference", &self.stories),
            ) {
                None => Step::Agreed,
                Some(difference) => Step::Differ(difference),
            },
        )
    }

    /// What the search found.
    pub(super) fn searched(&self) -> Found {
        let minimal: Vec<Story> = self.search.report().minimal.iter().map(story).collect();
        Found { candidates: self.search.len(), size: self.size(&minimal), minimal }
    }

    /// What the reference found.
    pub(super) fn referred(&self) -> Found {
        let minimal = reference::minimal(self.seen(), &self.stories, false);
        Found { candidates: self.stories.len(), size: self.size(&minimal), minimal }
    }

    /// What somebody else found.
    pub(super) fn found(&self, candidates: &[Story], minimal: Vec<Story>) -> Found {
        Found { candidates: candidates.len(), size: self.size(&minimal), minimal }
    }

    /// The visits so far.
    pub(super) fn seen(&self) -> &'a [Visit] {
        &self.visits[..self.search.observations()]
    }

    /// What the reference has, to compare with.
    pub(super) fn stories(&self) -> &[Story] {
        &self.stories
    }

    fn size(&self, minimal: &[Story]) -> Option<Size> {
        let (paths, places) = reference::size(self.seen(), minimal.first()?);
        Some(Size { paths, places })
    }
}

impl Difference {
    /// The first story, in lexicographic order, that one list has and the other has not. Both are in that order.
    pub(super) fn first(
        observation: usize,
        among: &'static str,
        (this, ours): (&'static str, &[Story]),
        (that, theirs): (&'static str, &[Story]),
    ) -> Option<Difference> {
        let missing = |from: &[Story], other: &[Story]| {
            from.iter().find(|story| other.binary_search(story).is_err()).cloned()
        };
        let told = |only, not, visits| Difference { observation, only, not, among, visits };
        match (missing(ours, theirs), missing(theirs, ours)) {
            (None, None) => None,
            (Some(mine), Some(yours)) if yours < mine => Some(told(that, this, yours)),
            (Some(mine), _) => Some(told(this, that, mine)),
            (None, Some(yours)) => Some(told(that, this, yours)),
        }
    }
}

impl Effect {
    /// What an axiom of a set does to some visits; not tried if there are more than `most` candidates without it.
    pub(super) fn of(
        axiom: &Axiom,
        axioms: AxiomSet,
        visits: &[Visit],
        most: usize,
    ) -> Result<Effect, VisitError> {
        let untried = |why| Effect { axiom: axiom.name, untried: Some(why), without: None, refutes: None };
        if reference::UNKNOWN.contains(&axiom.name) {
            return Ok(untried("is of measurements, which are not compared"));
        }
        let Ok(without) = axioms.without(axiom.id) else {
            return Ok(untried("is part of what a candidate is"));
        };
        let mut search = Abduction::new(without, Limits { max_candidates: Some(most.saturating_add(1)) });
        for visit in visits {
            search.observe(visit)?;
            if search.len() > most {
                return Ok(untried("more candidates without it than --max-candidates"));
            }
        }
        let stories = told(&search);
        let breaks = |story: &&Story| !reference::obeys(visits, story, axiom.name);
        Ok(Effect {
            axiom: axiom.name,
            untried: None,
            without: Some(stories.len()),
            refutes: Some(stories.iter().filter(breaks).count()),
        })
    }
}

impl Comparison {
    /// What was found up to the last observation compared, where search and reference agree or differ.
    pub(super) fn new(race: &Race<'_>, axioms: AxiomSet, difference: Option<Difference>) -> Comparison {
        let (search, reference) = (race.searched(), race.referred());
        let last = race.seen().len().saturating_sub(1);
        let minimal = ("search", &search.minimal[..]);
        let preferred = || Difference::first(last, "minimal", minimal, ("reference", &reference.minimal));
        let difference = difference.or_else(preferred);
        Comparison {
            version: 1,
            profile: profile_name(axioms),
            observations: race.visits.len(),
            compared: race.seen().len(),
            equal: difference.is_none(),
            difference,
            search,
            reference,
            clingo: None,
            axioms: Vec::new(),
        }
    }
}

fn told(search: &Abduction) -> Vec<Story> {
    search.candidates().map(|candidate| story(&candidate)).collect()
}

fn story(candidate: &Candidate) -> Story {
    candidate.visits.iter().map(|visit| (visit.place.index(), visit.rotation.into())).collect()
}
