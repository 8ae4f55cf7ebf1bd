//! The reasons of a candidate in words.

use crate::export::{Alternative, Count, Explanation, Prospect, Relation, Report, Visits};
use std::fmt::Write;

/// Why the preferred candidate is as it is, what refuted its rivals, and where to look next, as lines of text.
pub fn explanation_text(explanation: &Explanation, report: &Report) -> String {
    let mut text = String::from("why places are taken for one: each coming back from the unknown\n");
    if explanation.closures.is_empty() {
        text += "  there is none\n";
    }
    explanation.closures.iter().for_each(|closure| text += &visits_text(closure, report));
    text += "\nwhat refuted rivals: how many, and one example\n";
    for (axiom, count) in report.refuted.iter().filter(|(_, count)| **count > 0) {
        let example = explanation.refuted.get(axiom).map_or_else(
            || "no branch that is left shows one".into(),
            |example| format!("at observation {}, {}", example.observation, example.words),
        );
        // Writing into a String cannot fail.
        let _ = writeln!(text, "  {axiom} {count}: {example}");
    }
    text += "\nwhere to look next\n";
    text += &match &explanation.next {
        Some(next) => next_text(next, report.candidates),
        None if report.candidates.value < 2 && report.complete => "  no rival is left to tell apart\n".into(),
        None if report.candidates.value < 2 => "  no rival was kept to tell apart\n".into(),
        None => "  no gateway is sure to refute a candidate\n".into(),
    };
    text
}

/// What a candidate and its rivals say of two visits, as lines of text.
pub fn visits_text(said: &Visits, report: &Report) -> String {
    let [a, b] = said.visits;
    let [agree, otherwise] =
        if said.same { [said.together, said.apart] } else { [said.apart, said.together] };
    let mut text = match said.same {
        true => format!("  observations {a} and {b} are one place, {}", said.places[0]),
        false => {
            format!("  observations {a} and {b} are two places, {} and {}", said.places[0], said.places[1])
        }
    };
    let kept = if report.complete { "" } else { " that were kept" };
    let _ = writeln!(text, ": so in {} of {} candidates{kept}", agree.value, report.candidates.value);
    said.reasons.iter().for_each(|reason| {
        let _ = writeln!(text, "    {}", reason.words);
    });
    if let Some(difference) = &said.difference {
        let _ = writeln!(text, "    the stars seen differ: of place {}, {difference}", said.places[0]);
    }
    for alternative in &said.alternatives {
        let _ = writeln!(text, "    as place {}, {}", alternative.place, alternative_text(alternative));
    }
    text + &rival_text(said, otherwise, report)
}

fn alternative_text(alternative: &Alternative) -> String {
    let seqs: Vec<String> = alternative.asserts.iter().map(|assert| assert.seq.to_string()).collect();
    match &alternative.refuted {
        Some(it) => format!("refuted at observation {} by {}: {}", it.observation, it.axiom, it.words),
        None if seqs.is_empty() => "nothing refutes it".into(),
        None => format!("no axiom refutes it, but the assert with seq {} does", seqs.join(", ")),
    }
}

fn rival_text(said: &Visits, otherwise: Count, report: &Report) -> String {
    let Some(rival) = &said.rival else {
        return match report.complete {
            true => "    no candidate says otherwise\n".into(),
            false => {
                "    no candidate that was kept says otherwise; an assert that does finds the simplest\n"
                    .into()
            }
        };
    };
    let ties = match said.minimal_rivals.len() {
        0 => String::new(),
        minimal => format!("; {minimal} of them as simple as the preferred"),
    };
    format!(
        "    otherwise in {}, the simplest of which is candidate {} with {} paths and {} places{ties}\n",
        number(otherwise),
        rival.candidate,
        rival.paths,
        rival.places,
    )
}

fn next_text(next: &Prospect, candidates: Count) -> String {
    let way: Vec<String> =
        next.route.iter().map(|gateway| format!("{}.{}", gateway.place, gateway.slot)).collect();
    let kind = if next.explored { "explored" } else { "unexplored" };
    let mut text = format!(
        "  by gateway {}, {kind}: of {} candidates {:.1} are expected to fall, {} at least\n",
        way.join(", then "),
        number(candidates),
        next.expected,
        next.worst
    );
    for prediction in &next.predictions {
        let seen = match &prediction.star {
            Some(star) => {
                let ways = star.iter().filter(|slot| slot.navigable).count();
                format!("expect a known place with {ways} {}", if ways == 1 { "way" } else { "ways" })
            }
            None => "do not know what is there".into(),
        };
        let on = if prediction.travel + 1 == next.route.len() { "" } else { " before its end" };
        let _ = writeln!(text, "    {} {seen}{on}: {} fall", prediction.candidates, prediction.falls);
    }
    text
}

fn number(count: Count) -> String {
    match count.relation {
        Relation::Eq => count.value.to_string(),
        Relation::Gte => format!("at least {}", count.value),
    }
}
