//! Converts results to another format, or to trajectories for odometry and SLAM tools.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::error::{Code, Error, Result};
use crate::fmi::Kind;
use crate::observe::{Form, Observer, Recording, RunInfo};
use crate::roles::{Declaration, Measure, Names, Roles};
use crate::ros::{self, Topics};
use crate::system::{Column, Port, RawUnit};
use crate::time::{self, Step, Time};

impl Recording {
    /// Passes a recording to a recorder. Booleans have become Integers.
    pub fn replay(&self, name: &str, recorder: &mut dyn Observer) -> Result<()> {
        let units = self.known_units();
        let columns = self.names().iter().enumerate().zip(units).map(|((place, name), unit)| {
            let kind = match self.form_at(place) {
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
        let times =
            self.time().iter().map(|seconds| time::from_seconds(*seconds, "a time of the results"));
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
            self.row(sample, &mut row);
            outcome = recorder.sample(time, &row);
        }
        outcome.and(recorder.finish())
    }

    fn row(&self, sample: usize, row: &mut [f64]) {
        for (value, (_, column)) in row.iter_mut().zip(self.columns()) {
            *value = column[sample];
        }
    }

    fn known_units(&self) -> Vec<Option<String>> {
        let known: HashMap<&str, &str> = self.units().collect();
        self.names()
            .iter()
            .map(|name| known.get(name.as_str()).map(|unit| (*unit).to_owned()))
            .collect()
    }

    pub(crate) fn roles(&self, declared: Option<&Declaration>) -> Result<Roles> {
        let names = Names::new(self.names().iter().map(String::as_str));
        let units = self.known_units();
        let measures = self.names().iter().zip(&units);
        let measures = measures.map(|(name, unit)| Measure::named(unit.as_deref(), name));
        Roles::find(&names, &measures.collect::<Vec<_>>(), declared)
    }

    /// The truth and each estimate as text in the format, by name: axes are those of ROS (east,
    /// north, up; forward, port, up). Rows with a value that is not finite in any of them are
    /// skipped, so that all have the same rows.
    pub fn trajectories(
        &self,
        declared: Option<&Declaration>,
        format: Trajectories,
    ) -> Result<Vec<(String, String)>> {
        let roles = self.roles(declared)?;
        if roles.bodies.is_empty() {
            return Err(Error::new(Code::Results, "no path is recorded")
                .why("a path is a group called pose with x and y")
                .help("specify the variables of the paths with a file: --roles"));
        }
        let mut texts = vec![String::new(); roles.bodies.len()];
        let mut row = vec![0.0; self.names().len()];
        for (sample, time) in self.time().iter().enumerate() {
            self.row(sample, &mut row);
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
    pub fn foxglove_layout(&self, declared: Option<&Declaration>) -> Result<String> {
        Ok(ros::layout(&Topics::new(self.roles(declared)?)))
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
