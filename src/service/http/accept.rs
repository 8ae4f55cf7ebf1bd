//! The form of an answer that there is in several: what a client asks for by the header `Accept`.

use crate::service::problem::{Problem, ProblemKind};
use axum::http::{HeaderMap, header};
use serde::Deserialize;
use std::fmt;
use utoipa::ToSchema;

/// The forms of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum GridFormat {
    /// `application/json`: cells as numbers.
    Json,
    /// `image/png`: a picture in the greys of `map_server`, row 0 at the top.
    Png,
    /// `image/x-portable-graymap`: the same picture.
    Pgm,
}

impl GridFormat {
    /// The first is answered where the client takes any.
    const ALL: [GridFormat; 3] = [GridFormat::Json, GridFormat::Png, GridFormat::Pgm];

    /// Its media type.
    pub(super) fn media_type(self) -> &'static str {
        match self {
            GridFormat::Json => "application/json",
            GridFormat::Png => "image/png",
            GridFormat::Pgm => "image/x-portable-graymap",
        }
    }

    /// The form that a client likes best, by the header `Accept` (RFC 9110, section 12.5.1). Without one, any will do.
    pub(super) fn accepted(headers: &HeaderMap) -> Result<GridFormat, Problem> {
        let lines: Vec<String> = headers
            .get_all(header::ACCEPT)
            .iter()
            .map(|line| String::from_utf8_lossy(line.as_bytes()).to_ascii_lowercase())
            .collect();
        if lines.is_empty() {
            return Ok(GridFormat::ALL[0]);
        }
        let ranges: Vec<Range<'_>> =
            lines.iter().flat_map(|line| line.split(',')).filter_map(Range::of).collect();
        let liked = |format: &GridFormat| quality(&ranges, format.media_type());
        let best = GridFormat::ALL.into_iter().rev().max_by_key(liked);
        best.filter(|best| liked(best) > 0).ok_or_else(|| {
            let there: Vec<&str> = GridFormat::ALL.iter().map(|format| format.media_type()).collect();
            let detail = format!("Accept is `{}`, expected one of {}", lines.join(", "), there.join(", "));
            Problem::new(ProblemKind::NotAcceptable, detail)
        })
    }
}

impl fmt::Display for GridFormat {
    /// As queries name it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            GridFormat::Json => "json",
            GridFormat::Png => "png",
            GridFormat::Pgm => "pgm",
        })
    }
}

/// A media range, and how much it is liked, in thousandths.
struct Range<'a> {
    range: &'a str,
    quality: u32,
}

impl Range<'_> {
    fn of(text: &str) -> Option<Range<'_>> {
        let mut parts = text.split(';').map(str::trim);
        let range = parts.next().filter(|range| !range.is_empty())?;
        let quality =
            parts.find_map(|part| part.strip_prefix("q=")).map(|quality| quality.trim().parse::<f64>());
        let quality = match quality {
            None => 1.0,
            Some(Ok(quality)) if (0.0..=1.0).contains(&quality) => quality,
            Some(_) => return None,
        };
        Some(Range { range, quality: (quality * 1000.0).round() as u32 })
    }

    /// How closely it names a media type: not at all, any, any of its kind, itself.
    fn closeness(&self, media_type: &str) -> u8 {
        let kind = media_type.split('/').next().unwrap_or_default();
        match self.range {
            range if range == media_type => 3,
            range if range.strip_suffix("/*") == Some(kind) => 2,
            "*/*" => 1,
            _ => 0,
        }
    }
}

/// How much a media type is liked: as the range says that names it most closely.
fn quality(ranges: &[Range<'_>], media_type: &str) -> u32 {
    let closest = ranges.iter().rev().max_by_key(|range| range.closeness(media_type));
    closest.filter(|range| range.closeness(media_type) > 0).map_or(0, |range| range.quality)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn accepted(lines: &[&str]) -> Option<GridFormat> {
        let mut headers = HeaderMap::new();
        for line in lines {
            headers.append(header::ACCEPT, line.parse().unwrap());
        }
        GridFormat::accepted(&headers).ok()
    }

    #[test]
    fn the_form_liked_best_is_given() {
        use GridFormat::{Json, Pgm, Png};
        for (lines, expected) in [
            (&[][..], Some(Json)),
            (&["*/*"], Some(Json)),
            (&["image/*"], Some(Png)),
            (&["IMAGE/PNG"], Some(Png)),
            (&["image/png;q=0.2, image/x-portable-graymap; q=0.5"], Some(Pgm)),
            (&["application/json;q=0.4, */*;q=0.5"], Some(Png)),
            (&["*/*", "application/json;q=0"], Some(Png)),
            (&["image/*, image/png;q=0"], Some(Pgm)),
            (&["text/html", "application/json;q=0.001"], Some(Json)),
            (&["text/html, image/png;q=0"], None),
            (&["text/html"], None),
            (&["image/png;q=2"], None),
            (&[""], None),
        ] {
            assert_eq!(accepted(lines), expected, "{lines:?}");
        }
    }
}
