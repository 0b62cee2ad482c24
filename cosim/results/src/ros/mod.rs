//! ROS 2 messages made from recorded values, for Foxglove, RViz and rosbag2.
//!
//! The truth and each estimate is a `nav_msgs/Odometry`, each measurement of a sensor the
//! corresponding ROS message, and `/tf` carries the poses of the bodies. Axes follow REP 103: the
//! world `map` is east, north, up, a body `base_link` forward, port, up.

mod cdr;
mod channels;
mod definition;
mod frames;
mod layout;
mod message;

use cdr::Cdr;

pub(crate) use cdr::CDR_HEADER;
pub use channels::{COLUMNS, Channels, DERIVED, Field};
pub(crate) use frames::{Pose, pose};
pub(crate) use layout::layout;

use std::collections::HashMap;

use self::message::Kind;
use crate::roles::{Place, Roles};
use cosim_base::time::Time;

/// The topics of a run, and when each has something new.
pub(crate) struct Topics {
    roles: Roles,
    all: Vec<Topic>,
    frames: Vec<String>,
}

/// One topic.
pub(crate) struct Topic {
    /// `filter/odometry`, without a leading slash.
    pub(crate) name: String,
    kind: Kind,
    /// The position of its body or sensor.
    of: usize,
    /// The stamp of the newest sample.
    stamp: Option<Time>,
}

impl Topic {
    /// The type name in ROS, and its definition with those of all nested types.
    pub(crate) fn schema(&self) -> (&'static str, String) {
        (self.kind.name(), definition::of(self.kind.name()))
    }

    fn schema_name(&self) -> &'static str {
        self.kind.name()
    }
}

/// The name of the world frame.
const WORLD: &str = "map";

impl Topics {
    pub(crate) fn new(roles: Roles) -> Self {
        let topic = |owner: &str, kind: Kind, of| {
            let name = format!("{}/{}", identifier(owner), kind.topic());
            Topic { name, kind, of, stamp: None }
        };
        let bodies = roles.bodies.iter().enumerate();
        let mut all: Vec<Topic> =
            bodies.map(|(at, body)| topic(&body.name, Kind::Odometry, at)).collect();
        for (at, sensor) in roles.sensors.iter().enumerate() {
            let kinds = Kind::of(sensor).into_iter();
            all.extend(kinds.map(|kind| topic(&sensor.name, kind, at)));
        }
        if !roles.bodies.is_empty() {
            let name = Kind::Transforms.topic().to_owned();
            all.push(Topic { name, kind: Kind::Transforms, of: 0, stamp: None });
        }
        let main = roles.main();
        let frame = |(at, body): (usize, &crate::roles::Body)| match main == Some(at) {
            true => "base_link".to_owned(),
            false => format!("{}/base_link", identifier(&body.name)),
        };
        let frames = roles.bodies.iter().enumerate().map(frame).collect();
        Self { roles, all, frames }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Topic> {
        self.all.iter()
    }

    /// Shows `see` the message of each topic that has one at this instant.
    pub(crate) fn each<E>(
        &mut self,
        now: Time,
        row: &[f64],
        message: &mut Vec<u8>,
        mut see: impl FnMut(usize, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        for (at, topic) in self.all.iter_mut().enumerate() {
            message.clear();
            let mut cdr = Cdr::new(message);
            let made = match topic.kind {
                Kind::Odometry => {
                    let body = &self.roles.bodies[topic.of];
                    message::odometry(
                        &mut cdr,
                        self.roles.axes,
                        body,
                        &self.frames[topic.of],
                        now,
                        row,
                    )
                }
                Kind::Transforms => {
                    message::transforms(&mut cdr, &self.roles, &self.frames, now, row)
                }
                measured => {
                    let sensor = &self.roles.sensors[topic.of];
                    let Some(stamp) = sampled(sensor.stamp, sensor.valid, now, row) else {
                        continue;
                    };
                    if sensor.stamp.is_some() && topic.stamp == Some(stamp) {
                        continue;
                    }
                    topic.stamp = Some(stamp);
                    message::measured(&mut cdr, measured, self.roles.axes, sensor, stamp, row)
                }
            };
            if made {
                see(at, message)?;
            }
        }
        Ok(())
    }
}

/// When a sensor took its newest sample, if there is one.
fn sampled(stamp: Option<Place>, valid: Option<Place>, now: Time, row: &[f64]) -> Option<Time> {
    if valid.is_some_and(|valid| valid.value(row) == 0.0) {
        return None;
    }
    let Some(stamp) = stamp else { return Some(now) };
    Time::try_from_seconds(stamp.value(row)).ok().filter(|stamp| *stamp >= Time::ZERO)
}

/// A name as ROS allows it: lower-case letters, digits, single underscores, starting with a letter.
pub(crate) fn identifier(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("_").to_ascii_lowercase();
    match name.chars().next() {
        Some(first) if first.is_ascii_digit() => format!("v{name}"),
        _ => name,
    }
}

/// The name, or the name with a number appended: numbers already used for it are not tried again.
pub(crate) fn unique(name: String, taken: &mut HashMap<String, usize>) -> String {
    let mut number = taken.get(&name).copied().unwrap_or(0);
    let mut candidate = name.clone();
    while taken.contains_key(&candidate) {
        number += 1;
        candidate = format!("{name}_{}", number + 1);
    }
    taken.insert(name, number);
    taken.entry(candidate.clone()).or_insert(0);
    candidate
}
