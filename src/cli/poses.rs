//! How far the poses of a log are off, beside checked relations.

use crate::cli::failure::Failure;
use crate::cli::input::read_relations;
use crate::cli::patchwork::Patchwork;
use crate::export::{PoseError, PoseErrorRow, PoseErrors};
use crate::geometry::Pose;
use crate::sensor::MatchingParameters;
use crate::visit::relations::{Compared, Reach, Spread, Track};
use std::fmt::Write;
use std::path::Path;

/// The errors of a track beside the relations in a file, and those of its patchwork.
pub(super) fn pose_errors(
    track: &Track,
    patchwork: Option<&Patchwork<'_>>,
    file: &Path,
) -> Result<PoseErrors, Failure> {
    let relations = read_relations(file)?;
    let compared = |track: &Track| track.compare(&relations, MatchingParameters::default().memory);
    let found = compared(track);
    let relaid = patchwork.and_then(|patchwork| patchwork.trajectories.as_ref()).map(|ways| {
        let relaid = |way: &Vec<(f64, Pose)>| compared(&track.relaid(way.iter().map(|(_, pose)| *pose)));
        [relaid(&ways.by_map), relaid(&ways.by_scans)]
    });
    let row = |(at, &(reach, Compared { relations, odometry, matched })): (usize, &(Reach, Compared))| {
        let of = |which: usize| relaid.as_ref().map(|relaid| error(&relaid[which].rows[at].1.matched));
        PoseErrorRow {
            relations: name(reach).into(),
            count: relations,
            odometry: error(&odometry),
            matched: error(&matched),
            by_map: of(0),
            by_scans: of(1),
        }
    };
    Ok(PoseErrors { unknown: found.unknown, rows: found.rows.iter().enumerate().map(row).collect() })
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
         {:.0} m of driving that are remembered\n{:26}{:^26}  {:^22}\n",
        MatchingParameters::default().memory,
        "",
        "metres",
        "degrees",
    );
    for row in &errors.rows {
        let poses = [
            ("odometry", Some(row.odometry)),
            ("matched", Some(row.matched)),
            ("map", row.by_map),
            ("map and scans", row.by_scans),
        ];
        let known = poses.into_iter().filter_map(|(name, error)| Some((name, error?)));
        for (at, (name, error)) in known.enumerate() {
            let relations =
                if at == 0 { format!("{:6} {:4}", row.relations, row.count) } else { String::new() };
            let metres = error.metres.map(|v| format!("{v:8.3}")).join(" ");
            let degrees = error.degrees.map(|v| format!("{v:7.2}")).join(" ");
            // Writing into a String cannot fail.
            let _ = writeln!(text, "{relations:12}{name:13} {metres}  {degrees}");
        }
    }
    match errors.unknown {
        0 => text,
        unknown => text + &format!("{unknown} relations are at stamps that no scan has\n"),
    }
}
