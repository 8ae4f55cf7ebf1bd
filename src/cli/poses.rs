//! How far the poses of a log are off, beside checked relations.

use crate::cli::failure::Failure;
use crate::cli::input::read_relations;
use crate::export::{PoseError, PoseErrorRow, PoseErrors};
use crate::sensor::MatchingParameters;
use crate::visit::relations::{Compared, Reach, Spread, Track};
use std::fmt::Write;
use std::path::Path;

/// The errors of a track beside the relations in a file.
pub(super) fn pose_errors(track: &Track, file: &Path) -> Result<PoseErrors, Failure> {
    let found = track.compare(&read_relations(file)?, MatchingParameters::default().memory);
    let row = |&(reach, Compared { relations, odometry, matched }): &(Reach, Compared)| PoseErrorRow {
        relations: name(reach).into(),
        count: relations,
        odometry: error(&odometry),
        matched: error(&matched),
    };
    Ok(PoseErrors { unknown: found.unknown, rows: found.rows.iter().map(row).collect() })
}

fn error([translation, rotation]: &[Spread; 2]) -> PoseError {
    let three = |spread: &Spread| [spread.mean, spread.median, spread.max];
    PoseError { metres: three(translation), degrees: three(rotation).map(f64::to_degrees) }
}

fn name(reach: Reach) -> &'static str {
    match reach {
        Reach::All => "all",
        Reach::Loops => "loops",
        Reach::Within => "within",
        Reach::Beyond => "beyond",
    }
}

/// The errors as a table.
pub(super) fn poses_in_words(errors: &PoseErrors) -> String {
    let mut text = format!(
        "\nposes beside checked relations: mean, median, largest error of the displacement; within and beyond the \
         {:.0} m of driving that are remembered\n{:8}{:>7}  {:^26}  {:^26}  {:^22}  {:^22}\n",
        MatchingParameters::default().memory,
        "",
        "",
        "odometry, metres",
        "matched, metres",
        "odometry, degrees",
        "matched, degrees",
    );
    for row in &errors.rows {
        let metres = |error: &PoseError| error.metres.map(|v| format!("{v:8.3}")).join(" ");
        let degrees = |error: &PoseError| error.degrees.map(|v| format!("{v:7.2}")).join(" ");
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "{:8}{:7}  {}  {}  {}  {}",
            row.relations,
            row.count,
            metres(&row.odometry),
            metres(&row.matched),
            degrees(&row.odometry),
            degrees(&row.matched),
        );
    }
    match errors.unknown {
        0 => text,
        unknown => text + &format!("{unknown} relations are at stamps that no scan has\n"),
    }
}
