//! A first reading of a bag: its topics, and what sits where on the robot.
//!
//! A topic shows itself by its first message, and static transforms may come after the first scan; so which topic is
//! the only one of its type is known at the end of the bag only.

use crate::sensor::log::LogError;
use crate::sensor::log::bag::frames::StaticFrames;
use crate::sensor::log::bag::message::{ODOMETRY, OdometryMessage, SCAN, TRANSFORMS, transforms};
use crate::sensor::log::bag::messages::Messages;
use mcap::Message;
use std::collections::BTreeMap;
use std::io::{self, Read};

/// The most topics that are told apart.
const MAX_TOPICS: usize = 4096;

/// A topic of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Such as `sensor_msgs/msg/LaserScan`.
    pub message_type: String,
    /// Such as `cdr`.
    pub encoding: String,
    /// How many messages it has.
    pub messages: u64,
}

/// What a bag holds.
#[derive(Clone, Debug, Default)]
pub struct BagSurvey {
    /// By name.
    pub topics: BTreeMap<String, Topic>,
    pub(super) frames: StaticFrames,
    /// The robot's frame by each topic of odometry.
    robot_frames: BTreeMap<String, String>,
    /// What is to be said of the end, if the bag is not whole.
    end: &'static str,
}

impl BagSurvey {
    /// Reads the files of a bag, in the order of recording, once. Of a damaged bag what comes before the damage is
    /// surveyed; reading it will come to the damage again.
    pub fn read<R: Read>(files: impl IntoIterator<Item = io::Result<R>>) -> Result<BagSurvey, LogError> {
        let mut survey = BagSurvey::default();
        let mut messages = Messages::new(files.into_iter());
        for message in messages.by_ref() {
            match message {
                Ok(message) => survey.take(&message)?,
                Err(damage) if survey.topics.is_empty() => return Err(damage),
                Err(_) => {
                    survey.end = ", and is damaged there";
                    return Ok(survey);
                }
            }
        }
        if messages.broken_off {
            survey.end = ", and breaks off there";
        }
        Ok(survey)
    }

    fn take(&mut self, message: &Message) -> Result<(), LogError> {
        let (name, channel) = (&message.channel.topic, &message.channel);
        if self.topics.len() == MAX_TOPICS && !self.topics.contains_key(name) {
            return Ok(());
        }
        let topic = self.topics.entry(name.clone()).or_insert_with(|| Topic {
            message_type: channel.schema.as_ref().map(|schema| schema.name.clone()).unwrap_or_default(),
            encoding: channel.message_encoding.clone(),
            messages: 0,
        });
        topic.messages += 1;
        let number = topic.messages;
        let bad = |error: String| LogError::Bag(format!("message {number} of {name} {error}"));
        match topic.message_type.as_str() {
            _ if topic.encoding != "cdr" => {}
            TRANSFORMS if name.ends_with("tf_static") => {
                transforms(&message.data).map_err(bad)?.into_iter().for_each(|t| self.frames.add(t));
            }
            // A malformed one is refused where it is read.
            ODOMETRY if number == 1 => {
                let frame = OdometryMessage::decode(&message.data).map(|odometry| odometry.child_frame);
                self.robot_frames.insert(name.clone(), frame.unwrap_or_default());
            }
            _ => {}
        }
        Ok(())
    }

    /// The topic of laser scans: the one asked for, or the only one, or `/scan`.
    pub(super) fn scan_topic(&self, asked: Option<&str>) -> Result<String, LogError> {
        self.topic(SCAN, asked, "/scan", "--scan-topic")
    }

    /// The topic of odometry: the one asked for, or the only one, or `/odom`.
    pub(super) fn odometry_topic(&self, asked: Option<&str>) -> Result<String, LogError> {
        self.topic(ODOMETRY, asked, "/odom", "--odom-topic")
    }

    /// The frame that a topic of odometry moves; some drivers leave it out, and mean the usual one.
    pub(super) fn robot_frame(&self, odometry: &str) -> String {
        let told = self.robot_frames.get(odometry).filter(|frame| !frame.is_empty());
        let usual = ["base_footprint", "base_link"].into_iter().find(|name| self.frames.knows(name));
        told.cloned().unwrap_or_else(|| usual.unwrap_or("base_link").to_owned())
    }

    fn topic(&self, kind: &str, asked: Option<&str>, usual: &str, option: &str) -> Result<String, LogError> {
        let fitting: Vec<&String> = self
            .topics
            .iter()
            .filter(|(_, topic)| topic.message_type == kind)
            .map(|(name, _)| name)
            .collect();
        let chosen = match (asked, fitting.as_slice()) {
            (Some(asked), _) => fitting.iter().find(|name| **name == asked),
            (None, [only]) => Some(only),
            (None, several) => several.iter().find(|name| **name == usual),
        };
        let Some(&chosen) = chosen else {
            return Err(LogError::Bag(match (asked, fitting.is_empty()) {
                (_, true) => format!("the bag has no topic of type {kind}, it has {}", self.listed()),
                (Some(asked), _) => {
                    format!("{asked} is no topic of type {kind}, expected {}", names(&fitting))
                }
                (None, _) => {
                    format!(
                        "the bag has several topics of type {kind}, choose by {option}: {}",
                        names(&fitting)
                    )
                }
            }));
        };
        match self.topics.get(chosen).map(|topic| topic.encoding.as_str()) {
            Some("cdr") | None => Ok(chosen.clone()),
            Some(other) => Err(LogError::Bag(format!(
                "{chosen} is encoded as `{other}`, expected `cdr`, as ROS 2 writes it"
            ))),
        }
    }

    fn listed(&self) -> String {
        let listed: Vec<String> = self
            .topics
            .iter()
            .take(30)
            .map(|(name, topic)| format!("{name} ({})", topic.message_type))
            .collect();
        let listed = if listed.is_empty() { "no message at all".into() } else { listed.join(", ") };
        format!("{listed}{}", self.end)
    }
}

fn names(names: &[&String]) -> String {
    names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(", ")
}
