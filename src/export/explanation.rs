//! The reasons of a candidate, as JSON.

use crate::abduction::{Abduction, Candidate};
use crate::explanation::{self, Opinion, Together, closures, examples, outlook, together_each};
use crate::export::{Alternative, Count, GraphGateway, Prospect, Refutation};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// Why a candidate is as it is.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub struct Explanation {
    /// Its position among the candidates.
    pub candidate: usize,
    /// Each coming back: a visit that it takes for a known place though the robot came there from the unknown, with
    /// the first visit to that place.
    pub closures: Vec<Visits>,
    /// What was asked of two visits; null if nothing was.
    pub visits: Option<Visits>,
    /// For axioms that refuted rivals, one example each; along this candidate where there is one.
    pub refuted: BTreeMap<String, Refutation>,
    /// The gateway at which most other candidates are expected to fall; null if none would.
    pub next: Option<Prospect>,
}

/// Why two visits are one place in a candidate, or are not, and what the rivals say.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Visits {
    /// The two observations, ascending.
    pub visits: [usize; 2],
    /// Whether they are one place in the candidate.
    pub same: bool,
    /// The numbers of their places there.
    pub places: [usize; 2],
    /// In how many candidates they are one place.
    pub together: Count,
    /// In how many they are not.
    pub apart: Count,
    /// Why they are one place; together these suffice. Empty if they are not.
    pub reasons: Vec<Reason>,
    /// What the later visit would be at the place of the other; empty if they are one place.
    pub alternatives: Vec<Alternative>,
    /// How the stars seen differ, if they do.
    pub difference: Option<String>,
    /// The simplest candidate that says otherwise: what it costs to say so. Null if all candidates agree.
    pub rival: Option<Rival>,
    /// The positions of the minimal candidates that say otherwise.
    pub minimal_rivals: Vec<usize>,
}

/// A reason why an observation is of a known place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Reason {
    /// Of which sort it is.
    pub kind: ReasonKind,
    /// The observation.
    pub observation: usize,
    /// The gateway left by before it.
    pub from: GraphGateway,
    /// The gateway at the far end.
    pub to: GraphGateway,
    /// The earlier observation it rests on: for a closure the first visit to the place, for a known path segment the
    /// one at the end of the first travel along it.
    pub since: usize,
    /// The rotations under which the star seen lies on that of the place; left out for known path segments.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignments: Option<Vec<u8>>,
    /// The reason in one sentence.
    pub words: String,
}

/// The sorts of reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ReasonKind {
    /// The robot came from the unknown, and what it saw is taken for the place.
    Closure,
    /// The robot went along a known path segment.
    Known,
}

/// A candidate that says otherwise.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Rival {
    /// Its position among the candidates.
    pub candidate: usize,
    /// Its abnormalities; left out unless the axiom `boundary` is held soft.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub abnormalities: Option<usize>,
    /// The number of its paths.
    pub paths: usize,
    /// The number of its places.
    pub places: usize,
}

impl Explanation {
    /// The reasons of the candidate at a position, and what it says of two visits, if that is asked for. None unless
    /// there are this candidate and these visits.
    pub fn of(abduction: &Abduction, candidate: usize, visits: Option<[usize; 2]>) -> Option<Explanation> {
        let own = abduction.candidate(candidate)?;
        let asked: Vec<[usize; 2]> = closures(abduction, &own).into_iter().chain(visits).collect();
        let said = together_each(abduction, candidate, &asked)?;
        let mut closures: Vec<Visits> = said.iter().map(|said| Visits::of(said, &own)).collect();
        let visits = visits.and_then(|_| closures.pop());
        let refuted = examples(abduction, candidate);
        let named = |(id, refutation): (&crate::abduction::AxiomId, &crate::abduction::Refutation)| {
            (id.name().to_owned(), Refutation::of(refutation))
        };
        let best = outlook(abduction, candidate)?.prospects.into_iter().next();
        let candidates = abduction.len() as u64;
        Some(Explanation {
            candidate,
            closures,
            visits,
            refuted: refuted.iter().map(named).collect(),
            next: best.filter(|best| best.expected > 0).map(|best| Prospect::of(&best, candidates)),
        })
    }
}

impl Visits {
    /// What a candidate and its rivals say of two visits.
    pub fn of(said: &Together, own: &Candidate) -> Visits {
        let (reasons, alternatives, difference) = match &said.opinion {
            Opinion::One { reasons, .. } => (reasons.iter().map(Reason::of).collect(), Vec::new(), None),
            Opinion::Two { alternatives, difference, .. } => {
                let difference = difference.map(|difference| difference.to_string());
                (Vec::new(), alternatives.iter().map(Alternative::of).collect(), difference)
            }
        };
        let rival = said.rival.as_ref().map(|rival| Rival {
            candidate: rival.candidate,
            abnormalities: rival.simplicity.abnormalities,
            paths: rival.simplicity.paths,
            places: rival.simplicity.places,
        });
        Visits {
            visits: said.visits,
            same: matches!(said.opinion, Opinion::One { .. }),
            places: said.visits.map(|visit| own.visits[visit].place.index()),
            together: said.together.into(),
            apart: said.apart.into(),
            reasons,
            alternatives,
            difference,
            rival,
            minimal_rivals: said.minimal_rivals.clone(),
        }
    }
}

impl Reason {
    fn of(reason: &explanation::Reason) -> Reason {
        match reason {
            explanation::Reason::Closure { observation, from, to, first, alignments } => Reason {
                kind: ReasonKind::Closure,
                observation: *observation,
                from: GraphGateway::of(*from),
                to: GraphGateway::of(*to),
                since: *first,
                alignments: Some(alignments.clone()),
                words: format!(
                    "observation {observation}, come to by the unexplored gateway {from}, is taken for place {}, first \
                     seen at observation {first}: the stars are alike{}",
                    to.place,
                    match alignments.len() {
                        0 | 1 => String::new(),
                        several => format!(" in {several} rotations, of which this is one"),
                    }
                ),
            },
            explanation::Reason::Known { observation, from, to, since } => Reason {
                kind: ReasonKind::Known,
                observation: *observation,
                from: GraphGateway::of(*from),
                to: GraphGateway::of(*to),
                since: *since,
                alignments: None,
                words: format!(
                    "observation {observation} is of place {}, as gateway {from} leads there since observation {since}",
                    to.place
                ),
            },
        }
    }
}
