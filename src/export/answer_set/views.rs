//! A trace of views as an answer-set program, and the candidates back from its models.

use crate::classic::{Action, Sight};
use crate::export::answer_set::Theory;
use crate::reference::views::Story;

/// The theory of profile `classic`.
pub const VIEWS: Theory<Story> = Theory {
    laws: &[("classic.lp", include_str!("../../../axioms/classic.lp"))],
    preference: ("classic_preference.lp", include_str!("../../../axioms/classic_preference.lp")),
    story: |model, observations| story(model.iter().map(String::as_str), observations),
};

/// The facts of a trace of views and of the axioms held, in the words of `axioms/classic.lp`.
pub fn view_facts(seen: &[Sight], axioms: &[&str]) -> String {
    let mut text: String = axioms.iter().map(|axiom| format!("axiom(\"{axiom}\").\n")).collect();
    for (k, sight) in seen.iter().enumerate() {
        text += &format!("observation({k}). sees({k},{}).", sight.view.0);
        if k > 0 {
            text += &format!(" does({k},{}).", action(sight.action));
        }
        text.push('\n');
    }
    text
}

fn action(action: Action) -> &'static str {
    match action {
        Action::Left => "left",
        Action::Right => "right",
        Action::Around => "around",
        Action::Travel => "travel",
    }
}

/// The story that a model tells in its atoms `at(Observation,Dstate)`. None unless there is one for each observation,
/// and each dstate is called by its first.
fn story<'a>(model: impl IntoIterator<Item = &'a str>, observations: usize) -> Option<Story> {
    let mut told: Vec<Option<usize>> = vec![None; observations];
    for atom in model {
        let Some(terms) = atom.strip_prefix("at(").and_then(|rest| rest.strip_suffix(')')) else { continue };
        let (observation, dstate) = terms.split_once(',')?;
        *told.get_mut(observation.parse::<usize>().ok()?)? = Some(dstate.parse().ok()?);
    }
    // Dstates by the observation of their first visit, in that order.
    let mut known: Vec<usize> = Vec::new();
    let mut story = Story::new();
    for (observation, dstate) in told.into_iter().enumerate() {
        let name = dstate?;
        if name == observation {
            known.push(name);
        }
        story.push(known.iter().position(|known| *known == name)?);
    }
    Some(story)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_stories() {
        let model = ["at(2,2)", "at(0,0)", "stop(1,2,3)", "at(1,0)", "at(3,2)"];
        assert_eq!(story(model, 4), Some(vec![0, 0, 1, 1]));
        for broken in [&model[..4], &["at(0)"], &["at(0,1)"], &["at(7,0)"], &["at(a,0)"]] {
            assert_eq!(story(broken.iter().copied(), 4), None, "{broken:?}");
        }
    }
}
