//! What several judges found on their own, observation by observation, and whether it is the same.

use crate::cli::clingo::Clingo;
use crate::cli::failure::Failure;
use crate::export::answer_set::Theory;
use serde::Serialize;

/// What two or three judges found on their own, and whether it is the same. Candidates are stories of type `S`.
#[derive(Debug, Serialize)]
pub(super) struct Comparison<S> {
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
    pub(super) difference: Option<Difference<S>>,
    /// What the search found.
    pub(super) search: Found<S>,
    /// What the reference found.
    pub(super) reference: Found<S>,
    /// What clingo found; null if it was not asked.
    pub(super) clingo: Option<Found<S>>,
    /// Axioms held that are stated once only: all judges take the search's own measure, so that no more is compared than
    /// that each heeds it, map by map.
    pub(super) stated_once: Vec<&'static str>,
    /// For each axiom held what it does.
    pub(super) axioms: Vec<Effect>,
}

/// What one judge found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Found<S> {
    /// The number of candidates.
    pub(super) candidates: usize,
    /// The preferred ones: for each visit its place and rotation, or for each view its dstate.
    pub(super) minimal: Vec<S>,
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
pub(super) struct Difference<S> {
    /// The observation up to which the candidate explains the trace.
    pub(super) observation: usize,
    /// Who has it.
    pub(super) only: &'static str,
    /// Who has it not.
    pub(super) not: &'static str,
    /// Whether they differ about all candidates or about the preferred ones.
    pub(super) among: &'static str,
    /// The candidate.
    pub(super) visits: S,
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

/// The search and the reference after the same observations of a trace, as long as they agree.
pub(super) trait Race {
    /// What a candidate is told as.
    type Story: Ord + Clone;

    /// The profile that holds exactly the axioms held, or `custom`.
    fn profile(&self) -> &'static str;

    /// The axioms held that refute.
    fn axioms(&self) -> Vec<&'static str>;

    /// Those of them that all judges take from the search.
    fn stated_once(&self) -> Vec<&'static str>;

    /// Observations of the trace.
    fn observations(&self) -> usize;

    /// Observations so far.
    fn compared(&self) -> usize;

    /// Takes the next observation, unless there are too many candidates after it.
    fn step(&mut self) -> Result<Step<Self::Story>, Failure>;

    /// The candidates of the reference, in lexicographic order.
    fn stories(&self) -> &[Self::Story];

    /// The number of candidates of the search, and its preferred ones.
    fn searched(&self) -> (usize, Vec<Self::Story>);

    /// Those that the reference prefers.
    fn preferred(&self) -> Vec<Self::Story>;

    /// How big a candidate is.
    fn size(&self, story: &Self::Story) -> Size;

    /// The theory for clingo.
    fn theory(&self) -> Theory<Self::Story>;

    /// What clingo is to know of the first observations, with the clashes found so far.
    fn facts(&self, observations: usize) -> String;

    /// Whether clashes are to be found, by this race, for clingo to find the same.
    fn clashes(&self) -> bool;

    /// What an axiom does to the observations so far.
    fn effect(&self, axiom: &'static str) -> Result<Effect, Failure>;
}

/// How a race went on.
pub(super) enum Step<S> {
    /// Both found the same.
    Agreed,
    /// Both would go on, but there are too many candidates to compare.
    TooMany,
    /// They found different candidates.
    Differ(Difference<S>),
}

impl<S: Ord + Clone> Difference<S> {
    /// The first story, in lexicographic order, that one list has and the other has not. Both are in that order.
    pub(super) fn first(
        observation: usize,
        among: &'static str,
        (this, ours): (&'static str, &[S]),
        (that, theirs): (&'static str, &[S]),
    ) -> Option<Difference<S>> {
        let missing =
            |from: &[S], other: &[S]| from.iter().find(|story| other.binary_search(story).is_err()).cloned();
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
    /// An axiom that was not tried without, and why.
    pub(super) fn untried(axiom: &'static str, why: &'static str) -> Effect {
        Effect { axiom, untried: Some(why), without: None, refutes: None }
    }
}

/// What is said of an axiom without which there are too many candidates.
pub(super) const TOO_MANY_WITHOUT: &str = "more candidates without it than --max-candidates";

impl<S: Ord + Clone> Comparison<S> {
    /// What was found up to the last observation of a race, where search and reference agree or differ.
    pub(super) fn new<R: Race<Story = S>>(race: &R, difference: Option<Difference<S>>) -> Comparison<S> {
        let (candidates, minimal) = race.searched();
        let search = found(race, candidates, minimal);
        let reference = found(race, race.stories().len(), race.preferred());
        let minimal = ("search", &search.minimal[..]);
        let preferred =
            || Difference::first(last(race), "minimal", minimal, ("reference", &reference.minimal));
        let difference = difference.or_else(preferred);
        Comparison {
            version: 1,
            profile: race.profile(),
            observations: race.observations(),
            compared: race.compared(),
            equal: difference.is_none(),
            difference,
            search,
            reference,
            clingo: None,
            stated_once: race.stated_once(),
            axioms: Vec::new(),
        }
    }

    /// Adds what clingo found, and the first difference to that.
    pub(super) fn ask<R: Race<Story = S>>(
        &mut self,
        clingo: &Clingo,
        race: &R,
        most: usize,
    ) -> Result<(), Failure> {
        let (theory, observations) = (race.theory(), race.compared());
        let facts = race.facts(observations);
        let candidates = clingo.candidates(&theory, &facts, observations, most.saturating_add(1))?;
        let minimal = clingo.minimal(&theory, &facts, observations)?;
        let differs = |among, theirs, ours| {
            Difference::first(last(race), among, ("reference", theirs), ("clingo", ours))
        };
        let difference = differs("candidates", race.stories(), &candidates)
            .or_else(|| differs("minimal", &self.reference.minimal, &minimal));
        self.difference = self.difference.take().or(difference);
        self.equal = self.difference.is_none();
        self.clingo = Some(found(race, candidates.len(), minimal));
        Ok(())
    }
}

fn found<R: Race>(race: &R, candidates: usize, minimal: Vec<R::Story>) -> Found<R::Story> {
    Found { candidates, size: minimal.first().map(|story| race.size(story)), minimal }
}

fn last<R: Race>(race: &R) -> usize {
    race.compared().saturating_sub(1)
}
