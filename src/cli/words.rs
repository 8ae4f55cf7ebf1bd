//! What was found, in words.

use crate::abduction::{Report, Strategy};
use crate::export::{self, MapGraph, TieOrder, TieStrain, Ties, explanation_text, map_text, visits_text};

/// The report in words.
pub(super) fn in_words(report: &Report, wire: &export::Report) -> String {
    let mut text = search_in_words(report.strategy, wire);
    let (Some(candidate), Some(preferred)) = (report.minimal.first(), &wire.preferred) else {
        return text + "no map\n";
    };
    text += &headline(&wire.candidates, preferred, wire.minimal.len());
    text += "\n";
    text += &map_text(&MapGraph::of(candidate));
    text + &ties_in_words(report, wire.ties.as_ref())
}

/// The maps as simple as the preferred one, and what strains all of these.
fn ties_in_words(report: &Report, ties: Option<&Ties>) -> String {
    let strain = |at: usize| match ties.map(|ties| ties.strains.get(at).and_then(Option::as_ref)) {
        None => String::new(),
        Some(None) => "; not relaxed, or to no rest".into(),
        Some(Some(strain)) => format!("; {}", strain_in_words(strain)),
    };
    let told = match ties.map(|ties| ties.ordered_by) {
        None => String::new(),
        Some(TieOrder::Strain) => format!("preferred as the least strained of them{}\n", strain(0)),
        Some(TieOrder::Assignment) => {
            format!("preferred as the first of them, as not all strains can be compared{}\n", strain(0))
        }
    };
    let rivals = report.minimal.iter().enumerate().skip(1);
    let rivals =
        rivals.map(|(at, rival)| format!("as simple: visits {}{}\n", numbers(&rival.places()), strain(at)));
    rivals.fold(told, |text, rival| text + &rival)
}

/// What strains one of the maps that are equally simple.
fn strain_in_words(strain: &TieStrain) -> String {
    let TieStrain { chi_square, degrees_of_freedom, walls_differ, log10_probability } = strain;
    let probability = match *log10_probability {
        common if common > -2.0 => format!("{:.2}", 10_f64.powf(common)),
        rare => format!("1e{rare:.0}"),
    };
    let walls = match walls_differ {
        0 => String::new(),
        1 => "walls differ on a visit to a known place, ".into(),
        visits => format!("walls differ on {visits} visits to known places, "),
    };
    format!(
        "strain {chi_square:.1} with {degrees_of_freedom} degrees of freedom, {walls}probability {probability}"
    )
}

/// What the search did: how many candidates it left, or how far it proves what it found.
fn search_in_words(strategy: Strategy, wire: &export::Report) -> String {
    let refuted: Vec<String> = wire.refuted.iter().map(|(axiom, count)| format!("{axiom} {count}")).collect();
    let refuted = refuted.join(", ");
    match strategy {
        Strategy::BreadthFirst => {
            let counts: Vec<String> = wire.candidates_per_observation.iter().map(u64::to_string).collect();
            let cut =
                if wire.complete { "" } else { "lower bounds from where --max-candidates cut the search\n" };
            format!(
                "candidates after each observation  {}\nmaps created {}, refuted {refuted}\n{cut}\n",
                counts.join(" "),
                wire.maps_created
            )
        }
        Strategy::BestFirst => {
            let bound = wire.bound.map(|export::Bound { paths, places }| {
                format!("no map has fewer than {paths} paths, nor with {paths} fewer than {places} places\n")
            });
            let (steps, bound) = (wire.steps.unwrap_or_default(), bound.unwrap_or_default());
            format!("partial maps looked at {steps}, refuted {refuted}\n{bound}\n")
        }
    }
}

/// The reasons in words, if there are any: of two visits, if they were asked for, and else all.
pub(super) fn reasons_in_words(wire: &export::Report) -> String {
    let Some(explanation) = &wire.explain else { return String::new() };
    let reasons = match &explanation.visits {
        Some(visits) => visits_text(visits, wire),
        None => explanation_text(explanation, wire),
    };
    format!("\n{reasons}")
}

/// What was found beside the truth in words, if that was asked for.
pub(super) fn truth_in_words(wire: &export::Report) -> String {
    let Some(truth) = &wire.truth else { return String::new() };
    let pairs = |pairs: &[[usize; 2]]| pairs.iter().map(|[a, b]| format!(" {a}+{b}")).collect::<String>();
    let missed: String =
        truth.missed.iter().map(|mark| format!(" {} at scan {}", mark.place, mark.scan)).collect();
    let stars: String = truth
        .stars
        .iter()
        .map(|star| {
            format!(
                " {} {}x {}",
                star.place,
                star.visits.len(),
                if star.equal { "equal" } else { "NOT equal" }
            )
        })
        .collect();
    let map = match truth.map_is_true {
        Some(true) => "the preferred map is the true one",
        Some(false) => "the preferred map is not the true one",
        None => "there is no map",
    };
    let list =
        |name: &str, items: String| if items.is_empty() { String::new() } else { format!("{name}{items}\n") };
    format!(
        "\nbeside the truth: {} of {} arrivals found, {} invented; {map}\n",
        truth.found,
        truth.marks,
        truth.invented.len()
    ) + &list("missed", missed)
        + &list("invented visits ", numbers(&truth.invented))
        + &list("stars of places seen again ", stars)
        + &list("wrongly one place, visits", pairs(&truth.merged))
        + &list("wrongly two places, visits", pairs(&truth.split))
}

/// The preferred map in two lines: how sure it is and how big, and the place of each visit.
pub(super) fn headline(candidates: &export::Count, preferred: &export::Preferred, ties: usize) -> String {
    let export::Preferred { places, paths, segments, dstates, visits, .. } = preferred;
    let abnormalities =
        preferred.abnormalities.map(|count| format!(", {count} abnormalities")).unwrap_or_default();
    format!(
        "preferred map: {}\n{places} places, {paths} paths, {segments} path segments, {dstates} dstates{abnormalities}\n\
         visits to places {}\n",
        certainty(candidates, preferred, ties),
        numbers(visits),
    )
}

/// How sure the preferred map is.
pub(super) fn certainty(candidates: &export::Count, preferred: &export::Preferred, ties: usize) -> String {
    let count = match candidates.relation {
        export::Relation::Eq => format!("1 of {} possible", candidates.value),
        export::Relation::Gte => format!("1 of at least {} possible", candidates.value),
    };
    let simplest =
        if preferred.unique { "the simplest".into() } else { format!("1 of {ties} equally simple") };
    let proof = if preferred.proven { "proven" } else { "not proven" };
    format!("{count}, {simplest}, {proof}")
}

pub(super) fn numbers(places: &[usize]) -> String {
    places.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_that_differ_are_told_beside_strain() {
        let told = |walls_differ, log10_probability| {
            strain_in_words(&TieStrain {
                chi_square: 17.04,
                degrees_of_freedom: 18,
                walls_differ,
                log10_probability,
            })
        };
        let strain = "strain 17.0 with 18 degrees of freedom,";
        assert_eq!(told(0, -0.301), format!("{strain} probability 0.50"));
        assert_eq!(
            told(1, -1.301),
            format!("{strain} walls differ on a visit to a known place, probability 0.05")
        );
        assert_eq!(
            told(2, -2.3),
            format!("{strain} walls differ on 2 visits to known places, probability 1e-2")
        );
    }
}
