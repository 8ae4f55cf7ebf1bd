//! The readings that were taken otherwise than they were read, so that a map explains the walk.

use crate::abduction::Report;
use crate::export::Preferred;
use crate::mending::{Change, ChangeKind, Mended};
use crate::star::ControlLaw;
use crate::trace::wire_star::WireControl;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use utoipa::ToSchema;

/// What was changed of the readings of a trace that no map explains as it was read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Mending {
    /// How many observations there are.
    pub observations: usize,
    /// The first of them that the map explains with these changes; 0 where it explains all.
    pub first: usize,
    /// How many it explains, from that one on: where they are not all, the longest stretch found.
    pub explained: usize,
    /// The sum of the margins that the changes overrule; a place passed unseen counts as the most doubtful of them may.
    pub doubt: f64,
    /// Whether none of the changes that are looked for explain as many with less doubt; false where a limit cut the search.
    pub proven: bool,
    /// The changes, by observation.
    pub changes: Vec<Misreading>,
    /// The observation of each visit of the map, in order; null at a place that the robot passed unseen. An observation that
    /// is not among them is of no place.
    pub told: Vec<Option<usize>>,
    /// The preferred map of the observations explained, with the changes. The preferred map of the report itself stays null, as
    /// nothing explains the trace as it was read; what is called proven here is so if the changes are right.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<Preferred>,
}

/// A reading that is taken otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Misreading {
    /// The observation, counted from 0.
    pub observation: usize,
    /// The slot as it was read, clockwise; null for a gateway that was not read.
    pub slot: Option<u8>,
    /// Its direction in the frame of the observation, radians, where that is known.
    pub bearing: Option<f64>,
    /// What is taken otherwise.
    pub kind: MisreadingKind,
    /// The control law as it was read, where that is what is taken otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<WireControl>,
    /// The control law as it is taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<WireControl>,
    /// How far the reading was from it, as a fraction of the deciding threshold.
    pub margin: f64,
    /// The observation whose place it is taken to be of; null where a gateway, and with it the place, is none.
    pub like: Option<usize>,
    /// The same in words.
    pub words: String,
}

/// What is taken otherwise of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MisreadingKind {
    /// The control law.
    Label,
    /// Whether, and with which gateway, the slot is on one path.
    Path,
    /// The place of the end of a path among the gateways.
    Order,
    /// A gateway is none.
    GatewayDropped,
    /// An opening that was a little too narrow is a gateway.
    GatewayAdded,
    /// An opening too narrow for a gateway is one, because the robot went through it on another visit.
    GatewayDriven,
    /// A gateway is none, and without it the observation is of no place: the robot was on its way along a path.
    Passed,
    /// On the way there the robot passed the place of another observation unseen.
    Missed,
}

impl Mending {
    /// Of a trace with so many observations; `found` is what explains those that are explained.
    pub fn of(mended: &Mended, observations: usize, found: &Report) -> Mending {
        let explained = mended.explained;
        Mending {
            observations,
            first: mended.first,
            explained,
            doubt: f64::from(mended.sum.doubt) / 1000.0,
            proven: mended.proven,
            changes: mended.changes.iter().map(Misreading::of).collect(),
            told: mended.told.iter().map(|told| told.observation).collect(),
            map: Preferred::of(found),
        }
    }
}

impl Mending {
    /// The observations of which something is taken otherwise, ascending.
    pub fn observations_changed(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.changes.iter().map(|change| change.observation).collect();
        all.dedup();
        all
    }

    /// What is taken otherwise of an observation, in words.
    pub fn remarks(&self, observation: usize) -> Vec<String> {
        let changes = self.changes.iter().filter(|change| change.observation == observation);
        changes.map(|change| change.words.clone()).collect()
    }
}

impl Misreading {
    fn of(change: &Change) -> Misreading {
        let (from, to) = match change.kind {
            ChangeKind::Label { from, to } => (Some(WireControl::from(from)), Some(WireControl::from(to))),
            _ => (None, None),
        };
        let kind = match change.kind {
            ChangeKind::Label { .. } => MisreadingKind::Label,
            ChangeKind::Path => MisreadingKind::Path,
            ChangeKind::Order => MisreadingKind::Order,
            ChangeKind::Dropped => MisreadingKind::GatewayDropped,
            ChangeKind::Added => MisreadingKind::GatewayAdded,
            ChangeKind::Driven => MisreadingKind::GatewayDriven,
            ChangeKind::Passed => MisreadingKind::Passed,
            ChangeKind::Missed => MisreadingKind::Missed,
        };
        let &Change { observation, slot, bearing, doubt, like, .. } = change;
        let slot = slot.map(|slot| slot.0);
        let (margin, words) = (doubt.margin(), words(change));
        Misreading { observation, slot, bearing, kind, from, to, margin, like, words }
    }
}

/// The law as traces spell it.
fn law(control: ControlLaw) -> &'static str {
    match control {
        ControlLaw::Midline => "midline",
        ControlLaw::LeftWall => "left_wall",
        ControlLaw::RightWall => "right_wall",
        ControlLaw::DeadEnd => "dead_end",
        ControlLaw::None => "none",
    }
}

fn words(change: &Change) -> String {
    let Change { observation, slot, bearing, kind, doubt, like } = change;
    let like = like.map_or_else(String::new, |like| format!(" observation {like}"));
    if *kind == ChangeKind::Missed {
        let doubt = 100.0 * doubt.margin();
        return format!(
            "on the way to observation {observation} the place of{like} was passed unseen, counted as {doubt:.0} %"
        );
    }
    let slot = slot.map_or_else(String::new, |slot| format!(", slot {}", slot.0));
    let at = bearing.map_or_else(String::new, |bearing| format!(" at {:.0} degrees", bearing.to_degrees()));
    let margin = format!("margin {:.0} %", 100.0 * doubt.margin());
    let what = match kind {
        ChangeKind::Label { from, to } => format!("{} read as {}, {margin}", law(*to), law(*from)),
        ChangeKind::Path => format!("its path goes on otherwise, {margin}"),
        ChangeKind::Order => format!("the end of its path lies elsewhere among the gateways, {margin}"),
        ChangeKind::Dropped => format!("the gateway is none, {margin}"),
        ChangeKind::Passed => {
            return format!(
                "observation {observation}{slot}{at}: the gateway is none, so the place is but a way through, {margin}"
            );
        }
        ChangeKind::Added => format!("an opening a little too narrow is a gateway, {margin}"),
        ChangeKind::Driven | ChangeKind::Missed => "the robot has gone through this narrow opening".into(),
    };
    format!("observation {observation}{slot}{at}: {what}, as at{like}")
}

/// What was changed and how far that leads, as lines of text.
pub fn mending_text(mending: &Mending) -> String {
    let Mending { observations, first, explained, told, .. } = mending;
    let whole = explained == observations;
    let mut text = String::from("no map explains the walk as it was read");
    text += &match whole {
        true => ". The map is that of the walk".to_owned(),
        false => format!(
            ", nor with doubtful readings changed. The map is that of observations {first} to {}, the longest stretch \
             explained,",
            (first + explained).saturating_sub(1)
        ),
    };
    text += &changes_text(mending);
    // Writing into a String cannot fail.
    if *told != (*first..first + explained).map(Some).collect::<Vec<_>>() {
        let name =
            |one: &Option<usize>| one.map_or_else(|| "unseen".into(), |observation| observation.to_string());
        let names: Vec<String> = told.iter().map(name).collect();
        let _ = writeln!(text, "  its visits are observations {}", names.join(" "));
    }
    if !whole {
        let left = observations - explained;
        let _ = writeln!(
            text,
            "  {left} observations are left, which nothing found explains together with these"
        );
    }
    text + "\n"
}

fn changes_text(Mending { doubt, proven, changes, .. }: &Mending) -> String {
    if changes.is_empty() {
        return " as it was read\n".into();
    }
    let least = if *proven { "that are looked for" } else { "found" };
    let head = format!(
        " with these readings changed, the least doubtful changes {least} (doubt {:.0} % in all):\n",
        100.0 * doubt
    );
    changes.iter().fold(head, |text, change| format!("{text}  {}\n", change.words))
}
