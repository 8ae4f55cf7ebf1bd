//! The search against the slow reference, and against clingo, candidate by candidate.

use crate::abduction::{
    Abduction, Assertion, Axiom, AxiomSet, Boundary, Candidate, Limits, Visit, VisitError, WordError,
};
use crate::export::profile_name;
use crate::reference::{self, Story};
use serde::Serialize;
use thiserror::Error;

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
    /// How big these are.
    pub(super) size: Option<Size>,
}

/// How big a map is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Size {
    /// Pairs of paths of which one is no boundary for what the other leads to; null where boundaries do not rank.
    pub(super) abnormalities: Option<usize>,
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

/// What is compared: visits, the axioms they are explained by, and what an operator said in the end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question<'a> {
    pub(super) visits: &'a [Visit],
    pub(super) axioms: AxiomSet,
    pub(super) word: &'a [Assertion],
    /// The most candidates compared after an observation.
    pub(super) most: usize,
}

/// Why a question cannot be asked.
#[derive(Debug, Error)]
pub(super) enum QuestionError {
    /// A visit cannot come where it does.
    #[error(transparent)]
    Visit(#[from] VisitError),
    /// An assertion cannot be taken.
    #[error(transparent)]
    Word(#[from] WordError),
}

/// The search and the reference after the same observations, as long as they agree.
pub(super) struct Race<'a> {
    question: Question<'a>,
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

impl<'a> Question<'a> {
    fn search(&self, axioms: AxiomSet) -> Abduction {
        // One more than can be compared shows that there are too many.
        let max_candidates = Some(self.most.saturating_add(1));
        Abduction::new(axioms, Limits { max_candidates, ..Limits::default() })
    }

    /// The search gone on with by one observation, and by what was said of it and earlier ones.
    fn observe(&self, search: &mut Abduction, observation: usize) -> Result<(), QuestionError> {
        search.observe(&self.visits[observation])?;
        let latest = self.word.iter().filter(|assertion| assertion.visits.iter().max() == Some(&observation));
        latest.copied().try_for_each(|assertion| search.assert(assertion))?;
        Ok(())
    }

    /// Whether the operator allows a story, or the beginning of one.
    fn allows(&self, story: &Story) -> bool {
        self.word.iter().all(|assertion| {
            let [a, b] = assertion.visits.map(|visit| story.get(visit).map(|it| it.0));
            a.is_none() || b.is_none() || (a == b) == assertion.same
        })
    }
}

impl<'a> Race<'a> {
    /// A race before the first visit.
    pub(super) fn new(question: Question<'a>) -> Race<'a> {
        let laws = question.axioms.iter().map(|axiom| axiom.name).collect();
        Race { question, laws, search: question.search(question.axioms), stories: Vec::new() }
    }

    /// The number of candidates agreed on.
    pub(super) fn len(&self) -> usize {
        self.stories.len()
    }

    /// Takes the next observation, unless there are too many candidates after it.
    pub(super) fn step(&mut self) -> Result<Step, QuestionError> {
        let observation = self.search.observations();
        let mut search = self.search.clone();
        self.question.observe(&mut search, observation)?;
        if search.len() > self.question.most {
            return Ok(Step::TooMany);
        }
        let visits = &self.question.visits[..=observation];
        let mut stories = match observation {
            0 => reference::beginning(visits),
            _ => reference::extensions(visits, &self.stories, &self.laws),
        };
        stories.retain(|story| self.question.allows(story));
        (self.search, self.stories) = (search, stories);
        let found = told(&self.search);
        let (ours, theirs) = (("search", &found[..]), ("reference", &self.stories[..]));
        Ok(Difference::first(observation, "candidates", ours, theirs).map_or(Step::Agreed, Step::Differ))
    }

    /// What the search found.
    pub(super) fn searched(&self) -> Found {
        let minimal: Vec<Story> = self.search.report().minimal.iter().map(story).collect();
        Found { candidates: self.search.len(), size: self.size(&minimal), minimal }
    }

    /// What the reference found.
    pub(super) fn referred(&self) -> Found {
        let minimal = reference::minimal(self.seen(), &self.stories, self.ranks());
        Found { candidates: self.stories.len(), size: self.size(&minimal), minimal }
    }

    /// What somebody else found.
    pub(super) fn found(&self, candidates: &[Story], minimal: Vec<Story>) -> Found {
        Found { candidates: candidates.len(), size: self.size(&minimal), minimal }
    }

    /// The visits so far.
    pub(super) fn seen(&self) -> &'a [Visit] {
        &self.question.visits[..self.search.observations()]
    }

    /// What the reference has, to compare with.
    pub(super) fn stories(&self) -> &[Story] {
        &self.stories
    }

    fn size(&self, minimal: &[Story]) -> Option<Size> {
        let story = minimal.first()?;
        let (paths, places) = reference::size(self.seen(), story);
        let abnormalities = self.ranks().then(|| reference::abnormalities(self.seen(), story));
        Some(Size { abnormalities, paths, places })
    }

    /// Whether boundaries rank.
    fn ranks(&self) -> bool {
        self.question.axioms.boundary() == Some(Boundary::Soft)
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
    /// What an axiom of the question does to its visits; not tried if there are too many candidates without it.
    pub(super) fn of(axiom: &Axiom, question: &Question<'_>) -> Result<Effect, QuestionError> {
        let untried = |why| Effect { axiom: axiom.name, untried: Some(why), without: None, refutes: None };
        if reference::UNKNOWN.contains(&axiom.name) {
            return Ok(untried("is of measurements, which are not compared"));
        }
        let Ok(without) = question.axioms.without(axiom.id) else {
            return Ok(untried("is part of what a candidate is"));
        };
        let mut search = question.search(without);
        for observation in 0..question.visits.len() {
            question.observe(&mut search, observation)?;
            if search.len() > question.most {
                return Ok(untried("more candidates without it than --max-candidates"));
            }
        }
        let stories = told(&search);
        let breaks = |story: &&Story| !reference::obeys(question.visits, story, axiom.name);
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
    pub(super) fn new(race: &Race<'_>, difference: Option<Difference>) -> Comparison {
        let (search, reference) = (race.searched(), race.referred());
        let last = race.seen().len().saturating_sub(1);
        let minimal = ("search", &search.minimal[..]);
        let preferred = || Difference::first(last, "minimal", minimal, ("reference", &reference.minimal));
        let difference = difference.or_else(preferred);
        Comparison {
            version: 1,
            profile: profile_name(race.question.axioms),
            observations: race.question.visits.len(),
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
