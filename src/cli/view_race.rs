//! Traces of views: the search beside the slow reference, in profile `classic`.

use crate::classic::{Candidate, Exhaustive, Sight, Sights, breadth_first};
use crate::cli::comparison::{Difference, Effect, Race, Size, Step, TOO_MANY_WITHOUT};
use crate::cli::failure::Failure;
use crate::export::answer_set::{Theory, VIEWS, view_facts};
use crate::reference::views::{self, LAWS, Story};

/// Search and reference after the same observations.
pub(super) struct ViewRace<'a> {
    seen: &'a [Sight],
    /// The most candidates compared after an observation.
    most: usize,
    /// What was taken so far, and what the search made of it.
    taken: Sights,
    search: Exhaustive,
    stories: Vec<Story>,
}

impl<'a> ViewRace<'a> {
    /// A race before the first view.
    pub(super) fn new(seen: &'a [Sight], most: usize) -> ViewRace<'a> {
        let taken = Sights::default();
        ViewRace { seen, most, search: breadth_first(&taken, most), taken, stories: Vec::new() }
    }

    fn so_far(&self) -> &'a [Sight] {
        &self.seen[..self.compared()]
    }

    fn told(&self) -> Vec<Story> {
        self.search.candidates().map(|candidate| story(&candidate)).collect()
    }
}

impl Race for ViewRace<'_> {
    type Story = Story;

    fn profile(&self) -> &'static str {
        "classic"
    }

    fn axioms(&self) -> Vec<&'static str> {
        LAWS.to_vec()
    }

    fn stated_once(&self) -> Vec<&'static str> {
        Vec::new()
    }

    fn observations(&self) -> usize {
        self.seen.len()
    }

    fn compared(&self) -> usize {
        self.taken.as_slice().len()
    }

    fn step(&mut self) -> Result<Step<Story>, Failure> {
        let observation = self.compared();
        let mut taken = self.taken.clone();
        taken.push(self.seen[observation]).map_err(|error| Failure::Input(error.to_string()))?;
        // One more than can be compared shows that there are too many.
        let search = breadth_first(&taken, self.most.saturating_add(1));
        if search.candidates().count() > self.most {
            return Ok(Step::TooMany);
        }
        (self.taken, self.search) = (taken, search);
        self.stories = match observation {
            0 => views::beginning(self.so_far()),
            _ => views::extensions(self.so_far(), &self.stories, &LAWS),
        };
        let found = self.told();
        let (ours, theirs) = (("search", &found[..]), ("reference", &self.stories[..]));
        Ok(Difference::first(observation, "candidates", ours, theirs).map_or(Step::Agreed, Step::Differ))
    }

    fn stories(&self) -> &[Story] {
        &self.stories
    }

    fn searched(&self) -> (usize, Vec<Story>) {
        (self.search.candidates().count(), self.search.report().minimal.iter().map(story).collect())
    }

    fn preferred(&self) -> Vec<Story> {
        views::minimal(self.so_far(), &self.stories)
    }

    fn size(&self, story: &Story) -> Size {
        let (paths, places) = views::size(self.so_far(), story);
        Size { abnormalities: None, paths, places }
    }

    fn theory(&self) -> Theory<Story> {
        VIEWS
    }

    fn facts(&self, observations: usize) -> String {
        view_facts(&self.seen[..observations], &LAWS)
    }

    fn clashes(&self) -> bool {
        false
    }

    fn effect(&self, axiom: &'static str) -> Result<Effect, Failure> {
        let others: Vec<&str> = LAWS.into_iter().filter(|law| *law != axiom).collect();
        let mut stories = views::beginning(self.so_far());
        for last in 1..self.compared() {
            stories = views::extensions(&self.seen[..=last], &stories, &others);
            if stories.len() > self.most {
                return Ok(Effect::untried(axiom, TOO_MANY_WITHOUT));
            }
        }
        let breaks = |story: &&Story| !views::obeys(self.so_far(), story, axiom);
        let refutes = Some(stories.iter().filter(breaks).count());
        Ok(Effect { axiom, untried: None, without: Some(stories.len()), refutes })
    }
}

fn story(candidate: &Candidate) -> Story {
    candidate.dstates.iter().map(|dstate| dstate.index()).collect()
}
