//! The grammar of a trace of views: an observation, then a turn or a travel, then an observation, and so on (seed,
//! section 3.3: v0, a1, v1, a2, v2, ...).

use crate::trace::event::{Event, EventKind, Percept, TurnDescription, TurnTarget};
use crate::trace::experience_error::ExperienceError;

/// What an observation of a trace of views tells the logic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewSighting {
    /// What the robot did before; `None` at the first observation.
    pub action: Option<ViewAction>,
    /// The name of the view.
    pub view: String,
}

/// What a robot does between two views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewAction {
    /// A turn within the place.
    Turn(TurnDescription),
    /// A travel along a path.
    Travel,
}

/// Where a trace of views stands: a state machine without I/O.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewExperience {
    next_seq: u64,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Phase {
    #[default]
    Start,
    Facing,
    Acted(ViewAction),
}

impl ViewExperience {
    /// An experience before its first event.
    pub fn new() -> Self {
        ViewExperience::default()
    }

    /// The `seq` that the next event must carry.
    pub fn next_seq(&self) -> u64 {
        self.next_seq
    }

    /// Takes an event; on an error nothing has changed. Gives what the logic needs for an observation, nothing for a
    /// turn or a travel.
    pub fn accept(&mut self, event: &Event) -> Result<Option<ViewSighting>, ExperienceError> {
        if event.seq != self.next_seq {
            return Err(ExperienceError::Sequence { expected: self.next_seq, found: event.seq });
        }
        let (phase, sighting) = match (&event.kind, self.phase) {
            (EventKind::Observation(seen), Phase::Start) => {
                (Phase::Facing, Some(ViewSighting { action: None, view: view(&seen.percept)? }))
            }
            (EventKind::Observation(seen), Phase::Acted(action)) => {
                (Phase::Facing, Some(ViewSighting { action: Some(action), view: view(&seen.percept)? }))
            }
            (EventKind::Turn(turn), Phase::Facing) => (Phase::Acted(description(turn.target)?), None),
            (EventKind::Travel(_), Phase::Facing) => (Phase::Acted(ViewAction::Travel), None),
            // An operator's word is on visits to places, of which views alone tell nothing.
            (EventKind::Assert(_) | EventKind::Retract { .. }, _) => {
                return Err(stars_in_views("/kind", "stars"));
            }
            (found, phase) => return Err(out_of_order(found, phase)),
        };
        self.phase = phase;
        self.next_seq += 1;
        Ok(sighting)
    }

    /// The experience after one event more.
    pub(super) fn after(&self, event: &Event) -> Result<ViewExperience, ExperienceError> {
        let mut next = self.clone();
        next.accept(event).map(|_| next)
    }
}

fn view(percept: &Percept) -> Result<String, ExperienceError> {
    match percept {
        Percept::View(view) => Ok(view.clone()),
        Percept::Star { .. } => Err(stars_in_views("/star", "stars")),
        Percept::Lpm(_) => Err(stars_in_views("/lpm", "grids")),
    }
}

fn description(target: TurnTarget) -> Result<ViewAction, ExperienceError> {
    match target {
        TurnTarget::Described(turn) => Ok(ViewAction::Turn(turn)),
        TurnTarget::Slot(_) => Err(stars_in_views("/to", "stars")),
        TurnTarget::Heading(_) => Err(stars_in_views("/heading", "grids")),
        TurnTarget::Angle(_) => Err(stars_in_views("/angle", "stars or grids")),
    }
}

fn stars_in_views(pointer: &'static str, found: &'static str) -> ExperienceError {
    ExperienceError::Mixed { pointer, found, expected: "views" }
}

fn out_of_order(found: &EventKind, phase: Phase) -> ExperienceError {
    let expected = match phase {
        Phase::Start => "an observation first",
        Phase::Facing => "a turn or a travel after a view",
        Phase::Acted(_) => "the view that the turn or travel led to",
    };
    ExperienceError::Order { found: found.name(), expected }
}

#[cfg(test)]
mod tests {
    use crate::trace::ndjson::{read_trace, write_trace};

    const STAR: &str = r#"{"seq":0,"kind":"observation","star":{"slots":[{"fragment":1,"direction":"+","out":null,"in":2,"control":"dead_end"},{"fragment":1,"direction":"-","out":2,"in":null,"control":"midline"}]},"dstate":1}"#;
    const VIEW: &str = r#"{"seq":0,"kind":"observation","view":"a"}"#;

    fn fault(lines: &[&str]) -> (usize, String) {
        let (events, error) = read_trace(lines.join("\n").as_bytes());
        (events.len(), error.map_or_else(String::new, |error| error.to_string()))
    }

    #[test]
    fn a_view_follows_on_every_action() {
        let text = [
            VIEW,
            r#"{"seq":1,"kind":"turn","turn":"around"}"#,
            r#"{"seq":2,"kind":"observation","view":"b"}"#,
            r#"{"seq":3,"kind":"turn","turn":"left","angle":1.5}"#,
            r#"{"seq":4,"kind":"observation","view":"c"}"#,
            r#"{"seq":5,"kind":"travel"}"#,
        ];
        let (events, fault) = read_trace(text.join("\n").as_bytes());
        assert!(fault.is_none(), "{fault:?}");
        let mut written = Vec::new();
        write_trace(&mut written, &events).unwrap();
        assert_eq!(String::from_utf8(written).unwrap().trim_end(), text.join("\n"));
    }

    #[test]
    fn what_may_not_come_is_refused_at_its_line() {
        let star = STAR.replace("\"seq\":0", "\"seq\":1");
        let star_after_travel = STAR.replace("\"seq\":0", "\"seq\":2");
        let travel = r#"{"seq":1,"kind":"travel"}"#;
        let cases: [(&[&str], &str); 10] = [
            (&[r#"{"seq":0,"kind":"turn","turn":"left"}"#], "line 1: /kind a turn may not come here"),
            (
                &[VIEW, &VIEW.replace('0', "1")],
                "line 2: /kind a observation may not come here, expected a turn",
            ),
            (&[VIEW, &star], "line 2: /kind a observation may not come here"),
            (
                &[VIEW, travel, r#"{"seq":2,"kind":"turn","turn":"left"}"#],
                "line 3: /kind a turn may not come here",
            ),
            (&[VIEW, travel, &star_after_travel], "line 3: /star belongs to a trace of stars, but this is a"),
            (&[VIEW, r#"{"seq":1,"kind":"turn","to":1}"#], "line 2: /to belongs to a trace of stars"),
            (
                &[VIEW, r#"{"seq":1,"kind":"retract","assert":0}"#],
                "line 2: /kind belongs to a trace of stars",
            ),
            (
                &[STAR, r#"{"seq":1,"kind":"turn","turn":"left"}"#],
                "line 2: /turn belongs to a trace of views",
            ),
            (
                &[STAR, travel, &VIEW.replace('0', "2")],
                "line 3: /view belongs to a trace of views, but this is",
            ),
            (&[VIEW, travel, r#"{"seq":3,"kind":"travel"}"#], "line 3: /seq is 3, expected 2"),
        ];
        for (lines, expected) in cases {
            let (kept, error) = fault(lines);
            assert_eq!(kept, lines.len() - 1);
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn what_is_no_event_is_refused_by_field() {
        let cases = [
            (r#""observation","view":"""#, "/view is empty"),
            (r#""observation","view":3"#, "/view invalid type: integer `3`, expected a string"),
            (r#""observation","view":"a","dstate":0"#, "/dstate stands beside a view"),
            (r#""observation"}"#, "an observation needs a star (with dstate), an lpm or a view"),
            (r#""turn","turn":"back""#, "/turn unknown variant `back`, expected one of `left`"),
            (r#""turn","turn":"left","to":1"#, "/to stands beside turn"),
            (r#""turn","view":"a","turn":"left""#, "/view belongs to events of kind observation"),
            (
                r#""travel","turn":"left""#,
                "/turn belongs to events of kind turn, but this one is of kind travel",
            ),
        ];
        for (rest, expected) in cases {
            let line = format!("{{\"seq\":0,\"kind\":{}}}", rest.trim_end_matches('}'));
            let (_, error) = fault(&[&line]);
            assert!(error.starts_with(&format!("line 1: {expected}")), "{error}");
        }
    }
}
