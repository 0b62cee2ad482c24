//! Converts results to another format, or to trajectories for odometry and SLAM tools.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::roles::{Declaration, Measure, Names, Roles};
use crate::ros::{self, Topics};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{self, Step, Time};
use cosim_core::observe::{Form, Observer, Recording, RunInfo};
use cosim_core::system::{Column, Port, RawUnit};
use cosim_import::Kind;

/// Passes a recording to a recorder. Booleans have become Integers.
pub fn replay(recording: &Recording, name: &str, recorder: &mut dyn Observer) -> Result<()> {
    let units = known_units(recording);
    let columns = recording.names().iter().enumerate().zip(units).map(|((place, name), unit)| {
        let kind = match recording.form_at(place) {
            Form::Real => Kind::Real,
            Form::Whole => Kind::Integer,
            Form::Text => Kind::String,
        };
        let port = Port { component: 0, variable: place };
        Column {
            name: name.clone(),
            port,
            kind,
            unit: unit.map(|name| RawUnit { name, unit: None }),
        }
    });
    let columns: Vec<Column> = columns.collect();
    let times = recording
        .time()
        .iter()
        .map(|seconds| time::from_seconds(*seconds, "a time of the results"));
    let times: Vec<Time> = times.collect::<Result<_>>()?;
    let (Some(&start), Some(&stop)) = (times.first(), times.last()) else {
        return Err(Error::new(Code::Results, "the results are empty"));
    };
    let output_interval = Step::whole(Time::from_ns(1));
    let info = RunInfo { name, columns: &columns, start, stop, output_interval, resumed: None };
    let mut row = vec![0.0; columns.len()];
    let mut outcome = recorder.start(&info);
    for (sample, time) in times.into_iter().enumerate() {
        if outcome.is_err() {
            break;
        }
        copy_row(recording, sample, &mut row);
        outcome = recorder.sample(time, &row);
    }
    outcome.and(recorder.finish())
}

fn copy_row(recording: &Recording, sample: usize, row: &mut [f64]) {
    for (value, (_, column)) in row.iter_mut().zip(recording.columns()) {
        *value = column[sample];
    }
}

fn known_units(recording: &Recording) -> Vec<Option<String>> {
    let known: HashMap<&str, &str> = recording.units().collect();
    recording
        .names()
        .iter()
        .map(|name| known.get(name.as_str()).map(|unit| (*unit).to_owned()))
        .collect()
}

/// The truth and each estimate as text in the format, by name: axes are those of ROS (east,
/// north, up; forward, port, up). Rows with a value that is not finite in any of them are
/// skipped, so that all have the same rows.
pub fn trajectories(
    recording: &Recording,
    declared: Option<&Declaration>,
    format: Trajectories,
) -> Result<Vec<(String, String)>> {
    let roles = Roles::recorded(recording, declared)?;
    if roles.bodies.is_empty() {
        return Err(Error::new(Code::Results, "no path is recorded")
            .why("a path is a group called pose with x and y")
            .help("specify the variables of the paths with a file: --roles"));
    }
    let mut texts = vec![String::new(); roles.bodies.len()];
    let mut row = vec![0.0; recording.names().len()];
    for (sample, time) in recording.time().iter().enumerate() {
        copy_row(recording, sample, &mut row);
        let poses = roles.bodies.iter().map(|body| ros::pose(roles.axes, body, &row));
        let Some(poses) = poses.collect::<Option<Vec<_>>>() else { continue };
        for (text, pose) in texts.iter_mut().zip(poses) {
            format.line(text, *time, &pose);
        }
    }
    let mut taken = HashMap::new();
    let names = roles.bodies.iter();
    let names = names.map(|body| ros::unique(ros::identifier(&body.name), &mut taken));
    Ok(names.zip(texts).collect())
}

/// A layout for Foxglove and Lichtblick with the topics that the results have as MCAP.
pub fn foxglove_layout(recording: &Recording, declared: Option<&Declaration>) -> Result<String> {
    Ok(ros::layout(&Topics::new(Roles::recorded(recording, declared)?)))
}

impl Roles {
    /// The roles of recorded variables.
    pub fn recorded(recording: &Recording, declared: Option<&Declaration>) -> Result<Self> {
        let names = Names::new(recording.names().iter().map(String::as_str));
        let units = known_units(recording);
        let measures = recording.names().iter().zip(&units);
        let measures = measures.map(|(name, unit)| Measure::named(unit.as_deref(), name));
        Self::find(&names, &measures.collect::<Vec<_>>(), declared)
    }
}

/// A format of trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trajectories {
    /// TUM: time, x, y, z and the quaternion x, y, z, w.
    Tum,
    /// KITTI: the rotation matrix with the position, row by row; without the time.
    Kitti,
}

impl Trajectories {
    fn line(self, text: &mut String, time: f64, pose: &ros::Pose) {
        let [x, y, z] = pose.position;
        let [qx, qy, qz, qw] = pose.orientation;
        // Writing to a string cannot fail.
        let _ = match self {
            Self::Tum => writeln!(text, "{time:?} {x:?} {y:?} {z:?} {qx:?} {qy:?} {qz:?} {qw:?}"),
            Self::Kitti => {
                let [a, b, c] = pose.rotation();
                let line = |[p, q, r]: [f64; 3], last: f64| format!("{p:?} {q:?} {r:?} {last:?}");
                writeln!(text, "{} {} {}", line(a, x), line(b, y), line(c, z))
            }
        };
    }
}
