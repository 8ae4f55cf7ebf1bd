//! CARMEN logs, line by line: one message a line, `#` before comments, most messages followed by
//! `ipc_timestamp ipc_hostname logger_timestamp`.
//!
//! | message | fields |
//! |---|---|
//! | `FLASER`, `RLASER` | `n r1..rn laser_x laser_y laser_theta robot_x robot_y robot_theta` |
//! | `ROBOTLASER1`.. | `laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode n r1..rn m s1..sm`, the two poses, `tv rv forward_safety_dist side_safety_dist turn_axis`; old ones without `m` and `turn_axis` |
//! | `RAWLASER1`.. | as before up to `sm` |
//! | `ODOM` | `x y theta tv rv accel` |
//! | `TRUEPOS` | `true_x true_y true_theta odom_x odom_y odom_theta` |
//! | `PARAM` | `name value` |
//!
//! Metres, radians, seconds. What fields a line has is decided by the number of its words.

mod layout;

use crate::geometry::Pose;
use crate::sensor::log::LogError;
use crate::sensor::log::entry::{Content, CutOff, Entry, LaserNumber, Sweep, SweepPoses};
use crate::sensor::log::fields::Fields;
use crate::sensor::log::geometry;
use crate::sensor::log::lines::Lines;
use crate::sensor::log::no_return::FRACTION;
use crate::sensor::log::reader::{LogOptions, ScanReader};
use layout::Layout;
use std::borrow::Cow;
use std::io::BufRead;

/// The scans of a CARMEN log.
pub fn carmen_scans<R: BufRead>(input: R, options: LogOptions) -> ScanReader<CarmenEntries<R>> {
    let entries = CarmenEntries::with_options(input, &options);
    ScanReader::new(entries, options)
}

/// The messages of a CARMEN log in file order. Ends after the first malformed line.
#[derive(Debug)]
pub struct CarmenEntries<R> {
    lines: Lines<R>,
    start_told: bool,
    ended: bool,
}

impl<R: BufRead> CarmenEntries<R> {
    /// Over the text of a log.
    pub fn new(input: R) -> Self {
        CarmenEntries::with_options(input, &LogOptions::default())
    }

    /// The same, where a told angle of the first beam needs none in the messages.
    pub fn with_options(input: R, options: &LogOptions) -> Self {
        CarmenEntries { lines: Lines::new(input), start_told: options.start_angle.is_some(), ended: false }
    }

    /// The true poses alone, each with its stamp: seconds, and the pose of the robot in the simulated world.
    pub fn truths(self) -> impl Iterator<Item = Result<(Option<f64>, Pose), LogError>> {
        self.filter_map(|entry| match entry {
            Ok(Entry { content: Content::Truth { stamp, world_from_robot, .. }, .. }) => {
                Some(Ok((stamp, world_from_robot)))
            }
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        })
    }

    fn read(&mut self) -> Result<Option<Entry>, LogError> {
        let more = self.lines.advance()?;
        if !more {
            self.ended = true;
            return Ok(self.last_word().map(|content| Entry { kind: "".into(), content }));
        }
        let (line, cut_off) = (self.lines.number, self.lines.cut_off());
        let cut = || Ok(Some(Entry { kind: "".into(), content: Content::CutOff(CutOff::Line(line)) }));
        let parsed = self.lines.text().and_then(|text| parse(&text));
        match parsed.and_then(|parsed| self.checked(parsed)) {
            Ok((entry, complete)) if complete || !cut_off => Ok(Some(entry)),
            Ok(_) => cut(),
            // A file without a single line end is no log that breaks off.
            Err(_) if cut_off && (line > 1 || self.lines.broken_off) => cut(),
            Err(message) => Err(LogError::Line { line, message }),
        }
    }

    /// What is to be said of the end of the file.
    fn last_word(&self) -> Option<Content> {
        let passed_over =
            "bytes behind the end of the compressed file were passed over; nothing is missing before them";
        if self.lines.broken_off {
            Some(Content::CutOff(CutOff::Stream))
        } else {
            self.lines.trailing_bytes.then(|| Content::Remark(passed_over.into()))
        }
    }

    fn checked(&self, (entry, complete): (Entry, bool)) -> Result<(Entry, bool), String> {
        if let Content::Sweep(Sweep {
            start_angle: Some(start), angle_increment: Some(step), ranges, ..
        }) = &entry.content
        {
            let fault = geometry::check((*start, *step), ranges.len(), self.start_told);
            fault.map_err(|fault| format!("{} {fault}", entry.kind))?;
        }
        Ok((entry, complete))
    }
}

impl<R: BufRead> Iterator for CarmenEntries<R> {
    type Item = Result<Entry, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let entry = self.read();
        self.ended |= entry.is_err();
        entry.transpose()
    }
}

/// The entry of a line, and whether it cannot have been longer.
fn parse(text: &str) -> Result<(Entry, bool), String> {
    let mut words = text.split_ascii_whitespace();
    let kind = words.next().unwrap_or_default();
    let (name, number) = match kind.strip_suffix(|c: char| c.is_ascii_digit()) {
        Some(name @ ("ROBOTLASER" | "RAWLASER")) => (name, kind[name.len()..].parse().unwrap_or_default()),
        _ => (kind, 0),
    };
    let mut fields = match name {
        "FLASER" | "RLASER" | "ROBOTLASER" | "RAWLASER" | "ODOM" | "TRUEPOS" | "PARAM" => {
            Fields::new(kind, words)
        }
        _ => return Ok((Entry { kind: kind_passed_over(kind), content: Content::Other }, true)),
    };
    let content = match name {
        "FLASER" => Content::Sweep(flaser(&mut fields, LaserNumber::FRONT)?),
        "RLASER" => Content::Sweep(flaser(&mut fields, LaserNumber::REAR)?),
        "ROBOTLASER" => Content::Sweep(robot_laser(&mut fields, LaserNumber(number))?),
        "RAWLASER" => Content::Sweep(raw_laser(&mut fields, LaserNumber(number))?),
        "ODOM" => odometry(&mut fields)?,
        "TRUEPOS" => Content::Truth {
            world_from_robot: fields.pose("the true pose")?,
            odom_from_robot: fields.pose("the odometry's pose")?,
            stamp: fields.stamp(),
        },
        _ => {
            let (name, value) = (fields.word("a name")?.to_owned(), fields.word("a value")?.to_owned());
            Content::Parameter { name, value }
        }
    };
    Ok((Entry { kind: kind.to_owned().into(), content }, fields.is_complete()))
}

/// What a line that is passed over is counted as; names are bounded, as it may be anything.
fn kind_passed_over(kind: &str) -> Cow<'static, str> {
    match kind {
        "" => "blank line".into(),
        _ if kind.starts_with('#') => "comment".into(),
        _ => kind.chars().filter(|c| !c.is_control()).take(24).collect::<String>().into(),
    }
}

fn flaser(fields: &mut Fields, laser: LaserNumber) -> Result<Sweep, String> {
    let count = fields.count()?;
    let ranges = fields.readings(count)?;
    let poses = poses(fields)?;
    Ok(Sweep {
        laser,
        stamp: fields.stamp(),
        start_angle: None,
        angle_increment: None,
        ranges,
        no_return_from: None,
        poses: Some(poses),
        robot_from_laser: None,
    })
}

fn poses(fields: &mut Fields) -> Result<SweepPoses, String> {
    Ok(SweepPoses {
        world_from_laser: fields.pose("the laser's pose")?,
        odom_from_robot: fields.pose("the robot's pose")?,
    })
}

fn robot_laser(fields: &mut Fields, laser: LaserNumber) -> Result<Sweep, String> {
    let head = sweep_head(fields, laser)?;
    let expected = "two poses and four or five numbers more behind its readings";
    let layout = Layout::find(layout::ROBOT, fields, laser, expected)?;
    let poses = poses(fields)?;
    fields.skip(layout.behind_poses());
    Ok(Sweep { stamp: fields.stamp(), poses: Some(poses), ..head })
}

fn raw_laser(fields: &mut Fields, laser: LaserNumber) -> Result<Sweep, String> {
    let head = sweep_head(fields, laser)?;
    Layout::find(
        layout::RAW,
        fields,
        laser,
        "a number of remissions and as many of them behind its readings",
    )?;
    Ok(Sweep { stamp: fields.stamp(), ..head })
}

/// What `ROBOTLASER` and `RAWLASER` have in common, up to the readings.
fn sweep_head(fields: &mut Fields, laser: LaserNumber) -> Result<Sweep, String> {
    fields.word("the laser's type")?;
    let start_angle = fields.number("the start angle")?;
    let view = fields.number("the field of view")?;
    let resolution = fields.number("the angular resolution")?;
    let maximum = fields.number("the maximum range")?;
    fields.word("the accuracy")?;
    fields.word("the remission mode")?;
    let count = fields.count()?;
    let ranges = fields.readings(count)?;
    let step = if resolution > 0.0 { resolution } else { view / count.saturating_sub(1).max(1) as f64 };
    Ok(Sweep {
        laser,
        stamp: None,
        start_angle: Some(start_angle),
        angle_increment: (step > 0.0).then_some(step),
        ranges,
        no_return_from: (maximum > 0.0).then_some(FRACTION * maximum),
        poses: None,
        robot_from_laser: None,
    })
}

fn odometry(fields: &mut Fields) -> Result<Content, String> {
    let odom_from_robot = fields.pose("the robot's pose")?;
    // Translational and rotational velocity, and in all but old logs the acceleration.
    let (ahead, host) = (fields.numbers_ahead(), fields.rest().len() > fields.numbers_ahead());
    fields.skip(if host { ahead.saturating_sub(1).min(3) } else { ahead.min(3) });
    Ok(Content::Odometry { stamp: fields.stamp(), odom_from_robot })
}

#[cfg(test)]
mod tests;
