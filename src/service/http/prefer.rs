//! What a client would rather have: the header `Prefer` (RFC 7240).

use axum::http::{HeaderMap, HeaderName};
use std::time::Duration;

/// The header of a preference.
const PREFER: HeaderName = HeaderName::from_static("prefer");

/// Not to wait for the answer, or not for long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RespondAsync {
    /// Whole seconds that the client waits, if it said so.
    pub(super) wait: Option<u32>,
}

impl RespondAsync {
    /// The preference of a request, if it has it. What is unknown or not well-formed is passed over, and of what is said
    /// twice the first counts, as section 2 has it.
    pub(super) fn of(headers: &HeaderMap) -> Option<RespondAsync> {
        let lines: Vec<&str> = headers.get_all(PREFER).iter().filter_map(|line| line.to_str().ok()).collect();
        let preferences = || lines.iter().flat_map(|line| split(line, ',')).filter_map(named);
        let value = |of: &str| preferences().find(|(name, _)| name == of).map(|(_, value)| value);
        let wait = value("wait").filter(|value| value.bytes().all(|digit| digit.is_ascii_digit()));
        let wait = wait.and_then(|value| value.parse().ok());
        value("respond-async")?.is_empty().then_some(RespondAsync { wait })
    }

    /// How long the client waits.
    pub(super) fn patience(self) -> Duration {
        Duration::from_secs(self.wait.unwrap_or_default().into())
    }

    /// The preference as it was applied.
    pub(super) fn applied(self) -> String {
        match self.wait {
            None => "respond-async".into(),
            Some(wait) => format!("respond-async, wait={wait}"),
        }
    }
}

/// What lies between separators; in quotes there are none, nor are quotes after a backslash there.
fn split(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let (mut quoted, mut escaped) = (false, false);
    text.split(move |c| {
        quoted ^= c == '"' && !escaped;
        escaped = c == '\\' && quoted && !escaped;
        c == separator && !quoted
    })
}

/// The name of a preference, in small letters, and its value, without quotes, if these are two or none; parameters are left out.
fn named(preference: &str) -> Option<(String, &str)> {
    let preference = split(preference, ';').next()?;
    let (name, value) = preference.split_once('=').unwrap_or((preference, ""));
    let value = value.trim();
    let bare = value.strip_prefix('"').and_then(|value| value.strip_suffix('"'));
    let value = bare.or((!value.contains('"')).then_some(value))?;
    Some((name.trim().to_ascii_lowercase(), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_read_as_rfc_7240_has_them() {
        let once = |wait| Some(RespondAsync { wait });
        for (lines, expected) in [
            (&[][..], None),
            (&["return=minimal"], None),
            (&["wait=10"], None),
            (&["respond-async"], once(None)),
            (&["Respond-Async"], once(None)),
            (&["respond-async, wait=10"], once(Some(10))),
            (&["wait=\"10\"", "respond-async; foo=bar"], once(Some(10))),
            (&["foo; bar,respond-async ,  Wait = 3"], once(Some(3))),
            (&["respond-async, wait=1, wait=2"], once(Some(1))),
            (&["respond-async, wait=-1"], once(None)),
            (&["respond-async, wait=soon"], once(None)),
            (&["respond-async, wait=99999999999"], once(None)),
            (&["respond-async=\"\""], once(None)),
            (&["respond-async=false"], None),
            (&["foo=\"a, respond-async, b\""], None),
            (&["foo=\"a\\\", respond-async, b\""], None),
            (&["foo=\"a\\\\\", respond-async"], once(None)),
            (&["respond-async=x, respond-async"], None),
            (&["respond-async=\""], None),
            (&["respond-async=\"; x\""], None),
            (&["foo=\"; respond-async\", wait=\"10"], None),
            (&["respond-async, wait=\"10"], once(None)),
            (&["respond-async, wait=+10"], once(None)),
            (&["respond-asynchronously"], None),
            (&[""], None),
        ] {
            let mut headers = HeaderMap::new();
            for line in lines {
                headers.append(PREFER, line.parse().unwrap());
            }
            assert_eq!(RespondAsync::of(&headers), expected, "{lines:?}");
        }
        assert_eq!(RespondAsync { wait: Some(3) }.applied(), "respond-async, wait=3");
    }
}
