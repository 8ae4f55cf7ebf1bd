//! Traces of stars: the search beside the slow reference, with what was measured if the axioms speak of it.

use crate::abduction::{
    Abduction, Assertion, Assignment, Axiom, AxiomSet, Boundary, Candidate, Evidence, Limits, Visit, judge,
};
use crate::cli::comparison::{Difference, Effect, Race, Size, Step, TOO_MANY_WITHOUT};
use crate::cli::failure::Failure;
use crate::export::answer_set::{Bounds, Nogood, Rounding, STARS, Theory, facts, nogood_facts};
use crate::export::profile_name;
use crate::map::PlaceId;
use crate::metric::{Measurements, MetricParameters};
use crate::reference::{self, MEASURED, Measured, Story};
use crate::trace::Sighting;
use std::sync::Arc;

/// What is compared: visits, the axioms they are explained by, and what an operator said in the end.
#[derive(Debug)]
pub(super) struct Question {
    pub(super) visits: Vec<Visit>,
    pub(super) axioms: AxiomSet,
    pub(super) word: Vec<Assertion>,
    /// The most candidates compared after an observation.
    pub(super) most: usize,
    /// What was measured, if anything was and an axiom asks for it.
    pub(super) senses: Option<Senses>,
}

/// What was measured, for each judge as it takes it.
#[derive(Debug)]
pub(super) struct Senses {
    /// For the search, after each observation.
    evidence: Vec<Option<Arc<dyn Evidence>>>,
    /// For the reference.
    measured: Measured,
    /// For clingo.
    bounds: Bounds,
}

/// Search and reference after the same observations.
pub(super) struct StarRace<'a> {
    question: &'a Question,
    search: Abduction,
    stories: Vec<Story>,
    /// What measurements refute and no rule of clingo does.
    nogoods: Vec<Nogood>,
}

impl Senses {
    /// None unless something was measured that an axiom asks for.
    pub(super) fn of(seen: &[Sighting], axioms: AxiomSet) -> Option<Senses> {
        let measured = Measured::new(seen, MetricParameters::default());
        if !measured.any() || axioms == axioms.without_measured() {
            return None;
        }
        let mut measurements = Measurements::default();
        let evidence = seen.iter().map(|sighting| {
            measurements = measurements.with(sighting);
            measurements.evidence()
        });
        let evidence = evidence.collect();
        Some(Senses { evidence, bounds: Bounds::of(&measured, Rounding::Outward), measured })
    }

    /// The first of the measured axioms held that the latest visit of a story breaks.
    fn broken(&self, visits: &[Visit], story: &Story, axioms: AxiomSet) -> Option<&'static str> {
        let mut measured = axioms.iter().filter(|axiom| axiom.is_measured());
        measured.find(|axiom| !self.holds(visits, story, axiom)).map(|axiom| axiom.name)
    }

    fn holds(&self, visits: &[Visit], story: &Story, axiom: &Axiom) -> bool {
        if MEASURED.contains(&axiom.name) {
            return self.measured.obeys(visits, story, axiom.name);
        }
        let evidence = self.evidence.get(story.len().saturating_sub(1)).and_then(Option::as_deref);
        let alone = AxiomSet::built_in().with(axiom.id);
        let latest = story.len().saturating_sub(1);
        // What is refuted before is for the beginning to say.
        let refuted = assignments(story).and_then(|told| judge(visits, evidence, alone, &told).err());
        refuted.is_none_or(|refuted| refuted.axiom != axiom.id || refuted.observation != latest)
    }
}

impl Question {
    fn search(&self, axioms: AxiomSet) -> Abduction {
        // One more than can be compared shows that there are too many.
        let max_candidates = Some(self.most.saturating_add(1));
        Abduction::new(axioms, Limits { max_candidates, ..Limits::default() })
    }

    /// The search gone on with by one observation, and by what was said of it and earlier ones.
    fn observe(&self, search: &mut Abduction, observation: usize) -> Result<(), Failure> {
        let evidence = self.senses.as_ref().and_then(|senses| senses.evidence[observation].clone());
        search.observe_measured(&self.visits[observation], evidence).map_err(refused)?;
        let latest = self.word.iter().filter(|assertion| assertion.visits.iter().max() == Some(&observation));
        latest.copied().try_for_each(|assertion| search.assert(assertion)).map_err(refused)
    }

    /// Whether the operator allows a story, or the beginning of one.
    fn allows(&self, story: &Story) -> bool {
        self.word.iter().all(|assertion| {
            let [a, b] = assertion.visits.map(|visit| story.get(visit).map(|it| it.0));
            a.is_none() || b.is_none() || (a == b) == assertion.same
        })
    }

    /// How many stories have a beginning that breaks an axiom.
    fn breaking(&self, stories: &[Story], axiom: &Axiom) -> usize {
        let Some(senses) = self.senses.as_ref().filter(|_| axiom.is_measured()) else {
            let breaks = |story: &&Story| !reference::obeys(&self.visits[..story.len()], story, axiom.name);
            return stories.iter().filter(breaks).count();
        };
        // In their order, stories share beginnings with the one before: whether each of these breaks it is known.
        let (mut before, mut broken): (&[(usize, usize)], Vec<bool>) = (&[], Vec::new());
        let mut count = 0;
        for story in stories {
            broken.truncate(before.iter().zip(story).take_while(|(a, b)| a == b).count());
            for length in broken.len() + 1..=story.len() {
                let earlier = broken.last().copied().unwrap_or(false);
                let visits = &self.visits[..length];
                broken.push(earlier || !senses.holds(visits, &story[..length].to_vec(), axiom));
            }
            count += usize::from(broken.last().copied().unwrap_or(false));
            before = story;
        }
        count
    }
}

impl<'a> StarRace<'a> {
    /// A race before the first visit.
    pub(super) fn new(question: &'a Question) -> StarRace<'a> {
        let search = question.search(question.axioms);
        StarRace { question, search, stories: Vec::new(), nogoods: Vec::new() }
    }

    /// The visits so far.
    fn seen(&self) -> &'a [Visit] {
        &self.question.visits[..self.search.observations()]
    }

    /// Whether boundaries rank.
    fn ranks(&self) -> bool {
        self.question.axioms.boundary() == Some(Boundary::Soft)
    }

    /// The stories of the reference gone on with to all of some visits.
    fn extended(&mut self, visits: &[Visit]) -> Vec<Story> {
        let question = self.question;
        let axioms = question.axioms;
        let laws: Vec<&str> = axioms.without_measured().iter().map(|axiom| axiom.name).collect();
        let mut stories = match visits.len() {
            1 => reference::beginning(visits),
            _ => reference::extensions(visits, &self.stories, &laws),
        };
        stories.retain(|story| question.allows(story));
        if let Some(senses) = &question.senses {
            stories.retain(|story| {
                let Some(axiom) = senses.broken(visits, story, axioms) else { return true };
                let mut held = axioms.iter();
                if !held.any(|axiom| senses.bounds.refute(visits, story, axiom.name)) {
                    self.nogoods.push(Nogood::beginning(axiom, story, visits.len() - 1));
                }
                false
            });
        }
        stories
    }
}

impl Race for StarRace<'_> {
    type Story = Story;

    fn profile(&self) -> &'static str {
        profile_name(self.question.axioms)
    }

    fn axioms(&self) -> Vec<&'static str> {
        self.question.axioms.iter().map(|axiom| axiom.name).collect()
    }

    fn stated_once(&self) -> Vec<&'static str> {
        let once = |name: &&str| reference::UNKNOWN.contains(name);
        self.question
            .senses
            .as_ref()
            .map(|_| self.axioms().into_iter().filter(once).collect())
            .unwrap_or_default()
    }

    fn observations(&self) -> usize {
        self.question.visits.len()
    }

    fn compared(&self) -> usize {
        self.search.observations()
    }

    fn step(&mut self) -> Result<Step<Story>, Failure> {
        let observation = self.search.observations();
        let mut search = self.search.clone();
        self.question.observe(&mut search, observation)?;
        if search.len() > self.question.most {
            return Ok(Step::TooMany);
        }
        self.stories = self.extended(&self.question.visits[..=observation]);
        self.search = search;
        let found = told(&self.search);
        let (ours, theirs) = (("search", &found[..]), ("reference", &self.stories[..]));
        Ok(Difference::first(observation, "candidates", ours, theirs).map_or(Step::Agreed, Step::Differ))
    }

    fn stories(&self) -> &[Story] {
        &self.stories
    }

    fn searched(&self) -> (usize, Vec<Story>) {
        (self.search.len(), self.search.report().minimal.iter().map(story).collect())
    }

    fn preferred(&self) -> Vec<Story> {
        reference::minimal(self.seen(), &self.stories, self.ranks())
    }

    fn size(&self, story: &Story) -> Size {
        let (paths, places) = reference::size(self.seen(), story);
        let abnormalities = self.ranks().then(|| reference::abnormalities(self.seen(), story));
        Size { abnormalities, paths, places }
    }

    fn theory(&self) -> Theory<Story> {
        STARS
    }

    fn facts(&self, observations: usize) -> String {
        let Question { visits, axioms, word, senses, .. } = self.question;
        let bounds = senses.as_ref().map(|senses| senses.bounds.first(observations).facts());
        facts(&visits[..observations], *axioms, word)
            + &bounds.unwrap_or_default()
            + &nogood_facts(&self.nogoods)
    }

    fn clashes(&self) -> bool {
        self.question.senses.is_some()
    }

    fn effect(&self, axiom: &'static str) -> Result<Effect, Failure> {
        let Some(held) = self.question.axioms.iter().find(|held| held.name == axiom) else {
            return Ok(Effect::untried(axiom, "is not held"));
        };
        if held.is_measured() && self.question.senses.is_none() {
            return Ok(Effect::untried(axiom, "is of measurements, of which the trace has none"));
        }
        let Ok(without) = self.question.axioms.without(held.id) else {
            return Ok(Effect::untried(axiom, "is part of what a candidate is"));
        };
        let mut search = self.question.search(without);
        for observation in 0..self.compared() {
            self.question.observe(&mut search, observation)?;
            if search.len() > self.question.most {
                return Ok(Effect::untried(axiom, TOO_MANY_WITHOUT));
            }
        }
        let stories = told(&search);
        let refutes = Some(self.question.breaking(&stories, held));
        Ok(Effect { axiom, untried: None, without: Some(stories.len()), refutes })
    }
}

fn told(search: &Abduction) -> Vec<Story> {
    search.candidates().map(|candidate| story(&candidate)).collect()
}

fn story(candidate: &Candidate) -> Story {
    candidate.visits.iter().map(|visit| (visit.place.index(), visit.rotation.into())).collect()
}

/// None where a number is none that a search has.
fn assignments(story: &Story) -> Option<Vec<Assignment>> {
    let assignment = |&(place, rotation): &(usize, usize)| {
        Some(Assignment { place: PlaceId::new(place)?, rotation: rotation.try_into().ok()? })
    };
    story.iter().map(assignment).collect()
}

/// What a visit or a word is refused with.
fn refused(error: impl std::fmt::Display) -> Failure {
    Failure::Input(error.to_string())
}
