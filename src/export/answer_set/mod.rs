//! A trace as an answer-set program, and the candidates back from its models.

use crate::abduction::{Assertion, AxiomSet, Boundary, Visit};
use crate::reference::Story;
use crate::star::{ControlLaw, LargeScaleStar};
use std::fmt::Write;

mod bounds;
mod views;

pub use bounds::{Bounds, Rounding};
pub use views::{VIEWS, view_facts};

/// A theory, file by file, and how its models are read.
///
/// All maps are the models of facts and laws; with the preference, the optimal models are the preferred maps.
pub struct Theory<S> {
    /// Names and texts of the files but the last.
    pub laws: &'static [(&'static str, &'static str)],
    /// What makes a map preferred.
    pub preference: (&'static str, &'static str),
    /// The story that the atoms of a model tell of so many observations; none unless they tell of each.
    pub story: fn(&[String], usize) -> Option<S>,
}

/// The theory of stars, with facts by [`facts`].
pub const STARS: Theory<Story> = Theory {
    laws: &[
        ("star.lp", include_str!("../../../axioms/star.lp")),
        ("causal.lp", include_str!("../../../axioms/causal.lp")),
        ("topological.lp", include_str!("../../../axioms/topological.lp")),
        ("planarity.lp", include_str!("../../../axioms/planarity.lp")),
        ("boundary.lp", include_str!("../../../axioms/boundary.lp")),
        ("metrical.lp", include_str!("../../../axioms/metrical.lp")),
    ],
    preference: ("preference.lp", include_str!("../../../axioms/preference.lp")),
    story: |model, observations| story(model.iter().map(String::as_str), observations),
};

impl<S> Theory<S> {
    /// All files, the preference last.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        self.laws.iter().copied().chain([self.preference])
    }

    /// A program of facts and laws, whose models are all maps, or also of what makes a map preferred.
    pub fn program(&self, facts: &str, preferred: bool) -> String {
        let preference = preferred.then_some(self.preference.1);
        let laws = self.laws.iter().map(|(_, text)| *text);
        laws.chain(preference).chain([facts]).collect::<Vec<&str>>().join("\n")
    }
}

/// Visits that cannot hold together, found by measuring a model: their observations and the axiom they break.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Nogood {
    /// The name of the axiom.
    pub axiom: &'static str,
    /// Each with the observation that was the first visit to its place, and its rotation.
    pub visits: Vec<(usize, usize, usize)>,
}

impl Nogood {
    /// The visits of a story up to an observation, which is as much as any measured axiom asks for.
    pub fn beginning(axiom: &'static str, story: &Story, latest: usize) -> Nogood {
        Nogood::new(axiom, story, &(0..=latest).collect::<Vec<usize>>())
    }

    /// The visits of some observations of a story. Whatever story has them breaks the axiom.
    pub fn new(axiom: &'static str, story: &Story, observations: &[usize]) -> Nogood {
        let first = |place| story.iter().position(|visit| visit.0 == place);
        let named = |&observation: &usize| {
            let &(place, rotation) = story.get(observation)?;
            Some((observation, first(place)?, rotation))
        };
        Nogood { axiom, visits: observations.iter().filter_map(named).collect() }
    }
}

/// The facts of a trace, of the axioms held and of what an operator said, in the words of `axioms/star.lp`. What was
/// said of visits not made is left out.
pub fn facts(visits: &[Visit], axioms: AxiomSet, word: &[Assertion]) -> String {
    let mut text = String::new();
    for axiom in axioms.iter() {
        text += &format!("axiom(\"{}\").\n", axiom.name);
    }
    if axioms.boundary() == Some(Boundary::Soft) {
        text += "axiom(\"boundary\"). soft(\"boundary\").\n";
    }
    for &Assertion { visits: [a, b], same, .. } in word {
        if a.max(b) < visits.len() {
            text += &format!("{}({a},{b}).\n", if same { "same" } else { "different" });
        }
    }
    for (k, visit) in visits.iter().enumerate() {
        text += &format!("observation({k}). arrival({k},{}).", visit.arrival.0);
        if let Some(departure) = visit.departure {
            text += &format!(" departure({k},{}).", departure.0);
        }
        text += &star(k, &visit.star);
    }
    text
}

fn star(k: usize, star: &LargeScaleStar) -> String {
    let mut text = format!(" size({k},{}).\n", star.size());
    for (slot, it) in star.slots().iter().enumerate() {
        let (control, gateway) = (control(it.control), u8::from(it.navigable));
        text += &format!("slot({k},{slot},{},{control},{gateway}). ", it.opposite.0);
    }
    text.trim_end().to_owned() + "\n"
}

fn control(law: ControlLaw) -> &'static str {
    match law {
        ControlLaw::Midline => "midline",
        ControlLaw::LeftWall => "left_wall",
        ControlLaw::RightWall => "right_wall",
        ControlLaw::DeadEnd => "dead_end",
        ControlLaw::None => "none",
    }
}

/// The facts of nogoods, in the words of `axioms/metrical.lp`.
pub fn nogood_facts<'a>(nogoods: impl IntoIterator<Item = &'a Nogood>) -> String {
    let mut text = String::new();
    for (number, nogood) in nogoods.into_iter().enumerate() {
        text += &format!("nogood({number},\"{}\").", nogood.axiom);
        for (observation, place, rotation) in &nogood.visits {
            // Writing to a string does not fail.
            let _ = write!(text, " in({number},{observation},{place},{rotation}).");
        }
        text.push('\n');
    }
    text
}

/// The story that a model tells in its atoms `visit(Observation,Place,Rotation)`; other atoms are passed over. None
/// unless there is one for each observation, and each place is called by its first.
pub fn story<'a>(model: impl IntoIterator<Item = &'a str>, observations: usize) -> Option<Story> {
    let mut told: Vec<Option<(usize, usize)>> = vec![None; observations];
    for atom in model {
        let Some(terms) = atom.strip_prefix("visit(").and_then(|rest| rest.strip_suffix(')')) else {
            continue;
        };
        let numbers: Vec<usize> = terms.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
        let &[observation, place, rotation] = &numbers[..] else { return None };
        *told.get_mut(observation)? = Some((place, rotation));
    }
    // Places by the observation of their first visit, in that order.
    let mut known: Vec<usize> = Vec::new();
    let mut story = Story::new();
    for (observation, visit) in told.into_iter().enumerate() {
        let (name, rotation) = visit?;
        if name == observation {
            known.push(name);
        }
        story.push((known.iter().position(|known| *known == name)?, rotation));
    }
    Some(story)
}

/// All stories under the theory that no measurement speaks against, by a solver that gives all models of the theory
/// with some more facts, and a measurement that says which observations of a story clash, and by which axiom.
///
/// Solves again with the clashes of all models until no model has one. Exact, if a clash is one in every story with
/// the same visits of these observations; ends, since a nogood takes away a model at least.
pub fn solve_and_measure<E>(
    mut solve: impl FnMut(&str) -> Result<Vec<Story>, E>,
    measure: impl Fn(&Story) -> Option<Nogood>,
) -> Result<Vec<Story>, E> {
    let mut nogoods: Vec<Nogood> = Vec::new();
    loop {
        let stories = solve(&nogood_facts(&nogoods))?;
        let mut found: Vec<Nogood> = stories.iter().filter_map(&measure).collect();
        found.sort_unstable();
        found.dedup();
        found.retain(|nogood| !nogoods.contains(nogood));
        if found.is_empty() {
            return Ok(stories);
        }
        nogoods.extend(found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_stories() {
        let model = ["visit(2,2,0)", "visit(0,0,0)", "right(1,2,3)", "visit(1,0,3)", "visit(3,2,1)"];
        assert_eq!(story(model, 4), Some(vec![(0, 0), (0, 3), (1, 0), (1, 1)]));
        for broken in [&model[..4], &["visit(0,0)"], &["visit(0,1,0)"], &["visit(7,0,0)"], &["visit(a,0,0)"]]
        {
            assert_eq!(story(broken.iter().copied(), 4), None, "{broken:?}");
        }
    }

    #[test]
    fn measuring_takes_away_what_clashes() {
        // Two visits, the second to the first place in three ways or to a new one; turned ones clash.
        let all: Vec<Story> = [(0, 0), (0, 1), (0, 2), (1, 0)].map(|second| vec![(0, 0), second]).to_vec();
        let solve = |facts: &str| -> Result<Vec<Story>, ()> {
            let kept = |it: &&Story| !facts.contains(&format!(",1,0,{}).", it[1].1));
            Ok(all.iter().filter(kept).cloned().collect())
        };
        let measure = |it: &Story| (it[1].1 > 0).then(|| Nogood::new("angle", it, &[0, 1]));
        let left = solve_and_measure(solve, measure).unwrap();
        assert_eq!(left, [vec![(0, 0), (0, 0)], vec![(0, 0), (1, 0)]]);
    }
}
