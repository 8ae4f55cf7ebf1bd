//! CARMEN logs: front laser messages with their odometry, line by line.
//!
//! `FLASER n r1 .. rn laser_x laser_y laser_theta robot_x robot_y robot_theta ..trailers`: the first pose is the
//! laser's, the second the robot's by odometry. The angles of the beams are not in the message; they follow
//! from the number of beams as in CARMEN's own reader: a field of view that starts at -90 degrees, in steps of
//! 1 degree for 180 and 181 beams, 0.5 for 360 and 361, else of 180 / (n - 1) degrees. Ranges at the largest
//! value of the log mean that nothing came back.

use crate::geometry::Pose;
use crate::sensor::LaserScan;
use std::f64::consts::FRAC_PI_2;
use std::io::{self, BufRead, Read};
use thiserror::Error;

/// Ranges from this fraction of the log's largest value on count as no return.
const NO_RETURN_FRACTION: f64 = 0.99;
/// The most beams a scan may announce.
const MAX_BEAMS: usize = 100_000;
/// The longest line that is read, bytes; a scan of the most beams fits.
const MAX_LINE: u64 = 4 * 1024 * 1024;

/// A log read to its end: the scans in file order and what was passed over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CarmenLog {
    /// The front laser's scans in file order.
    pub scans: Vec<LaserScan>,
    /// Lines that carry other messages or comments.
    pub skipped: usize,
}

/// Why a log could not be read.
#[derive(Debug, Error)]
pub enum CarmenError {
    /// A malformed line.
    #[error("line {line}: {message}")]
    Line {
        /// Line number, from 1.
        line: usize,
        /// What was found and expected.
        message: String,
    },
    /// The input could not be read.
    #[error("line {line}: cannot be read: {source}")]
    Read {
        /// Line number, from 1.
        line: usize,
        /// The cause.
        source: io::Error,
    },
    /// No front laser message at all.
    #[error("no FLASER line in the log, expected a CARMEN log with front laser messages")]
    NoScans,
}

impl CarmenLog {
    /// Reads a log. A last line without its line end is taken to be cut off and skipped.
    pub fn read(input: impl BufRead) -> Result<CarmenLog, CarmenError> {
        let mut log = CarmenLog::default();
        let mut input = input;
        let mut text = Vec::new();
        for line in 1.. {
            text.clear();
            let read = input.by_ref().take(MAX_LINE + 1).read_until(b'\n', &mut text);
            match read.map_err(|source| CarmenError::Read { line, source })? {
                0 => break,
                read if read as u64 > MAX_LINE => {
                    let message = format!("is longer than {MAX_LINE} bytes, expected one message a line");
                    return Err(CarmenError::Line { line, message });
                }
                _ => {}
            }
            let text = String::from_utf8_lossy(&text);
            // A byte order mark would hide the first scan, and every scan would be counted one too low.
            let text = text.trim_start_matches('\u{feff}');
            let cut_off = !text.ends_with('\n');
            match parse_line(text) {
                Ok(Some(scan)) => log.scans.push(scan),
                Ok(None) => log.skipped += 1,
                Err(_) if cut_off => log.skipped += 1,
                Err(message) => return Err(CarmenError::Line { line, message }),
            }
        }
        if log.scans.is_empty() {
            return Err(CarmenError::NoScans);
        }
        mark_no_returns(&mut log.scans);
        Ok(log)
    }
}

fn parse_line(text: &str) -> Result<Option<LaserScan>, String> {
    let mut words = text.split_ascii_whitespace();
    if words.next() != Some("FLASER") {
        return Ok(None);
    }
    let count = words.next().ok_or("FLASER without a number of readings")?;
    let beams: usize =
        count.parse().map_err(|_| format!("FLASER announces `{count}` readings, expected a whole number"))?;
    if !(2..=MAX_BEAMS).contains(&beams) {
        return Err(format!("FLASER announces {beams} readings, expected 2 to {MAX_BEAMS}"));
    }
    let numbers = words.take(beams + 7).map(number).collect::<Result<Vec<f64>, String>>()?;
    if numbers.len() < beams + 7 {
        return Err(format!(
            "FLASER announces {beams} readings and has {} numbers after that, expected {} readings, two poses and a stamp: {}",
            numbers.len(),
            beams,
            beams + 7
        ));
    }
    let pose = |at: usize| Pose::new(numbers[at], numbers[at + 1], numbers[at + 2]);
    let (odom_from_laser, odom_from_robot) = (pose(beams), pose(beams + 3));
    let (start_angle, angle_increment) = beam_angles(beams);
    Ok(Some(LaserScan {
        stamp: numbers[beams + 6],
        odom_from_robot,
        robot_from_laser: odom_from_robot.inverse().compose(&odom_from_laser),
        start_angle,
        angle_increment,
        ranges: numbers[..beams].iter().map(|&r| Some(r)).collect(),
    }))
}

fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{word}` is not a finite number")),
    }
}

fn beam_angles(beams: usize) -> (f64, f64) {
    let degrees = match beams {
        180 | 181 => 1.0,
        360 | 361 => 0.5,
        n => 180.0 / (n - 1) as f64,
    };
    (-FRAC_PI_2, f64::to_radians(degrees))
}

fn mark_no_returns(scans: &mut [LaserScan]) {
    let ranges = || scans.iter().flat_map(|scan| scan.ranges.iter().flatten());
    let limit = NO_RETURN_FRACTION * ranges().copied().fold(0.0, f64::max);
    for range in scans.iter_mut().flat_map(|scan| &mut scan.ranges) {
        *range = range.filter(|&r| r > 0.0 && r < limit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: &str = "FLASER 3 1.0 2.0 50.0 1.1 2.0 0.0 1.0 2.0 0.0 7.5 nohost 0.1\n";

    #[test]
    fn the_second_pose_is_the_robot() {
        let text = format!("# comment\nPARAM x y\n{LINE}FLASER 3 1.0 2.");
        let log = CarmenLog::read(text.as_bytes()).unwrap();
        assert_eq!((log.scans.len(), log.skipped), (1, 3));
        let scan = &log.scans[0];
        assert_eq!(scan.odom_from_robot, Pose::new(1.0, 2.0, 0.0));
        assert!((scan.robot_from_laser.x - 0.1).abs() < 1e-12);
        assert_eq!(scan.ranges, [Some(1.0), Some(2.0), None]);
        assert_eq!(scan.stamp, 7.5);
        let hits: Vec<_> = scan.hits().collect();
        assert!((hits[0].y + 1.0).abs() < 1e-12 && (hits[1].x - 2.1).abs() < 1e-12);
    }

    #[test]
    fn a_byte_order_mark_does_not_hide_the_first_scan() {
        let log = CarmenLog::read(format!("\u{feff}{LINE}{LINE}").as_bytes()).unwrap();
        assert_eq!((log.scans.len(), log.skipped), (2, 0));
    }

    #[test]
    fn a_line_without_end_is_refused_before_it_fills_the_memory() {
        let endless = LINE.as_bytes().chain(io::repeat(b'0'));
        let error = CarmenLog::read(io::BufReader::new(endless)).unwrap_err();
        assert_eq!(error.to_string(), "line 2: is longer than 4194304 bytes, expected one message a line");
    }

    #[test]
    fn a_broken_line_in_the_middle_is_refused_with_its_number() {
        for bad in
            ["FLASER\n", "FLASER x\n", "FLASER 3 1.0 nan 2.0 0 0 0 0 0 0 1\n", "FLASER 99999999999 1\n"]
        {
            let error = CarmenLog::read(format!("{LINE}{bad}{LINE}").as_bytes()).unwrap_err();
            assert!(error.to_string().starts_with("line 2: "), "{error}");
        }
        assert!(matches!(CarmenLog::read(&b""[..]), Err(CarmenError::NoScans)));
    }
}
