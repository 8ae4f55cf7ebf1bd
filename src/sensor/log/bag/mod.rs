//! ROS 2 bags in the MCAP format: laser scans with the odometry and the static transforms of the same bag.

mod cdr;
mod frames;
mod message;
mod messages;
mod survey;

pub use survey::{BagSurvey, Topic};

use crate::sensor::log::entry::{Content, CutOff, Entry, LaserNumber, Sweep};
use crate::sensor::log::geometry;
use crate::sensor::log::reader::{LogOptions, ScanReader};
use crate::sensor::log::{LARGEST, LogError};
use frames::PlanarMount;
use mcap::Message;
use message::{OdometryMessage, ScanMessage};
use messages::Messages;
use std::collections::{BTreeMap, VecDeque};
use std::io::{self, Read};

/// The scans of a bag whose files have been surveyed, in the order of recording.
pub fn bag_scans<I: Iterator<Item = io::Result<R>>, R: Read>(
    files: I,
    survey: BagSurvey,
    options: LogOptions,
) -> Result<ScanReader<BagEntries<I, R>>, LogError> {
    Ok(ScanReader::new(BagEntries::new(files, survey, &options)?, options))
}

/// The scans and the odometry of a bag in the order of recording. Ends after the first malformed message.
///
/// Of a scan's ranges those count that are at least `range_min` and less than `range_max` (REP-117), as many sensors
/// give the latter where nothing came back. Beams are turned to go counter-clockwise seen from above, for lasers that
/// turn the other way or hang upside down. A stamp that was not filled in is that of the recorder, a bound that was not
/// filled in is none.
pub struct BagEntries<I, R> {
    messages: Messages<I, R>,
    survey: BagSurvey,
    scans: String,
    odometry: String,
    robot_frame: String,
    mount_told: bool,
    start_told: bool,
    mounts: BTreeMap<String, PlanarMount>,
    remarks: VecDeque<String>,
    bounds_told: bool,
    read: u64,
    ended: bool,
}

impl<I: Iterator<Item = io::Result<R>>, R: Read> BagEntries<I, R> {
    /// Over the files of a bag. Fails if it is not clear from which topics to read.
    pub fn new(files: I, survey: BagSurvey, options: &LogOptions) -> Result<Self, LogError> {
        let scans = survey.scan_topic(options.scan_topic.as_deref())?;
        let odometry = survey.odometry_topic(options.odom_topic.as_deref())?;
        let robot_frame = survey.robot_frame(&odometry);
        let remark = format!("scans from {scans}, odometry from {odometry}, which moves {robot_frame}");
        Ok(BagEntries {
            messages: Messages::new(files),
            survey,
            scans,
            odometry,
            robot_frame,
            mount_told: options.mount.is_some(),
            start_told: options.start_angle.is_some(),
            mounts: BTreeMap::new(),
            remarks: [remark].into(),
            bounds_told: false,
            read: 0,
            ended: false,
        })
    }

    fn entry(&mut self, message: &Message) -> Result<Entry, LogError> {
        self.read += 1;
        let topic = &message.channel.topic;
        let kind = topic.clone();
        let recorded = message.log_time as f64 * 1e-9;
        let content = if *topic == self.scans {
            self.sweep(&message.data, recorded).map(Content::Sweep)
        } else if *topic == self.odometry {
            OdometryMessage::decode(&message.data).map(|odometry| Content::Odometry {
                stamp: Some(odometry.header.stamp.unwrap_or(recorded)),
                odom_from_robot: odometry.odom_from_robot,
            })
        } else if topic.ends_with("tf_static") {
            // Read by the survey.
            return Ok(Entry { kind: kind.into(), content: Content::Known });
        } else {
            Ok(Content::Other)
        };
        match content {
            Ok(content) => Ok(Entry { kind: kind.into(), content }),
            Err(error) => {
                Err(LogError::Bag(format!("message {} of the bag, on {topic}, {error}", self.read)))
            }
        }
    }

    fn sweep(&mut self, data: &[u8], recorded: f64) -> Result<Sweep, String> {
        let scan = ScanMessage::decode(data)?;
        let angles = (scan.start_angle, scan.angle_increment);
        geometry::check(angles, scan.ranges.len(), self.start_told)?;
        let mount = self.mount(&scan.header.frame)?;
        let (nearest, farthest) = self.bounds(&scan);
        let valid = |range: f64| if range >= nearest && range < farthest { range } else { f64::NAN };
        let mut ranges: Vec<f64> = scan.ranges.into_iter().map(valid).collect();
        let upside_down = mount.is_some_and(|mount| mount.upside_down);
        let turn = if upside_down { -1.0 } else { 1.0 };
        let (mut start, mut step) = (turn * scan.start_angle, turn * scan.angle_increment);
        if step < 0.0 {
            ranges.reverse();
            start += step * ranges.len().saturating_sub(1) as f64;
            step = -step;
        }
        Ok(Sweep {
            laser: LaserNumber::FRONT,
            stamp: Some(scan.header.stamp.unwrap_or(recorded)),
            start_angle: Some(start),
            angle_increment: Some(step),
            ranges,
            no_return_from: (farthest > 0.0 && farthest < LARGEST).then_some(farthest),
            poses: None,
            robot_from_laser: mount.map(|mount| mount.robot_from_laser),
        })
    }

    /// The bounds of valid ranges: those of a message, as far as they are some.
    fn bounds(&mut self, &ScanMessage { range_min, range_max, .. }: &ScanMessage) -> (f64, f64) {
        let nearest = if range_min < f64::INFINITY { range_min } else { 0.0 };
        let farthest = if range_max > nearest { range_max } else { f64::INFINITY };
        if (nearest, farthest) != (range_min, range_max) && !std::mem::replace(&mut self.bounds_told, true) {
            self.remarks.push_back(format!(
                "from message {} on, {} has range_min {} and range_max {}, expected the second above the first; what was \
                 not filled in bounds nothing (--max-range)",
                self.read, self.scans, range_min as f32, range_max as f32
            ));
        }
        (nearest, farthest)
    }

    /// Where the laser of a frame sits; `None` if only the reader's options say it.
    fn mount(&mut self, frame: &str) -> Result<Option<PlanarMount>, String> {
        if let Some(mount) = self.mounts.get(frame) {
            return Ok(Some(*mount));
        }
        match self.survey.frames.mount(&self.robot_frame, frame) {
            Ok(mount) => {
                self.mounts.insert(frame.to_owned(), mount);
                Ok(Some(mount))
            }
            Err(_) if self.mount_told => Ok(None),
            Err(error) => Err(format!("cannot be laid on the robot: {error}")),
        }
    }
}

impl<I: Iterator<Item = io::Result<R>>, R: Read> Iterator for BagEntries<I, R> {
    type Item = Result<Entry, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        if let Some(remark) = self.remarks.pop_front() {
            return Some(Ok(Entry { kind: "".into(), content: Content::Remark(remark) }));
        }
        let entry = match self.messages.next() {
            Some(Ok(message)) => self.entry(&message),
            Some(Err(error)) => Err(error),
            None => {
                self.ended = true;
                let cut_off = Entry { kind: "".into(), content: Content::CutOff(CutOff::Stream) };
                return self.messages.broken_off.then_some(Ok(cut_off));
            }
        };
        self.ended |= entry.is_err();
        Some(entry)
    }
}

#[cfg(test)]
mod tests;
