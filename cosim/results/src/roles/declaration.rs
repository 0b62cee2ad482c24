//! A file that declares the roles of recorded variables, for systems whose names do not show them.
//!
//! ```toml
//! axes = "ned"
//!
//! [truth]
//! pose = "plant.eta"
//!
//! [estimates.observer]
//! pose = { x = "obs.north", y = "obs.east", yaw = "obs.heading" }
//! sigma = "obs.sigma"
//!
//! [courses.leg]
//! position = "guidance.aim"
//!
//! [sensors.log]
//! velocity = "dvl.velocity"
//! ```
//!
//! A group is a text, to which `.x`, `.y`, ... are appended, or a table of axes and variables.

use std::path::Path;

use super::{
    ATTITUDE, Axes, Body, Course, Group, Measure, Names, PLACE, POSE, Place, RATE, Roles, SPEED,
    Sensor, VELOCITY, covariances,
};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names::did_you_mean;
use cosim_core::table::{Document, Entry, Table};

/// The declared roles of the variables of a system.
#[derive(Debug, Clone, Default)]
pub struct Declaration {
    axes: Axes,
    truth: Option<Described>,
    estimates: Vec<Described>,
    courses: Vec<Described>,
    sensors: Vec<Described>,
}

/// A body, a course or a sensor, by its groups.
#[derive(Debug, Clone, Default)]
struct Described {
    name: String,
    groups: Vec<(String, Spelled)>,
}

/// How the variables of a group are named.
#[derive(Debug, Clone)]
enum Spelled {
    Path(String),
    Each(Vec<(String, String)>),
}

const BODY: [&str; 5] = ["pose", "velocity", "sigma", "velocity-sigma", "covariance"];
const COURSE: [&str; 1] = ["position"];
const SENSOR: [&str; 9] = [
    "specific-force",
    "rate",
    "attitude",
    "velocity",
    "position",
    "sigma",
    "pressure",
    "stamp",
    "valid",
];

impl Declaration {
    /// Reads a file.
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let text = cosim_base::files::read_input_text(file).map_err(|e| {
            Error::new(Code::File, "the declaration of roles cannot be read").at(file).why(e)
        })?;
        let document = Document::new(&text, file, Code::Roles);
        let parsed = document.parse()?;
        let root = document.root(&parsed);
        root.allow(&["axes", "truth", "estimates", "courses", "sensors"]);
        let axes = match root.text("axes") {
            None | Some("ned") => Axes::Ned,
            Some("enu") => Axes::Enu,
            Some(other) => {
                root.wrong(format!("axes are 'ned' or 'enu', and not '{other}'"));
                Axes::Ned
            }
        };
        let truth = root.table("truth").map(|table| described("truth", &table, &BODY));
        let all = |key: &str, known: &[&str]| -> Vec<Described> {
            let Some(tables) = root.table(key) else { return Vec::new() };
            let tables = tables.entries().filter_map(|(name, entry)| Some((name, entry.table()?)));
            tables.map(|(name, table)| described(name, &table, known)).collect()
        };
        let (estimates, sensors) = (all("estimates", &BODY), all("sensors", &SENSOR));
        let courses = all("courses", &COURSE);
        document.finish()?;
        Ok(Self { axes, truth, estimates, courses, sensors })
    }

    /// The positions of what it names.
    pub(super) fn resolve(&self, names: &Names<'_>, measures: &[Measure]) -> Result<Roles> {
        let found = Found { names, measures };
        let bodies = self.truth.iter().map(|truth| (truth, true));
        let bodies = bodies.chain(self.estimates.iter().map(|estimate| (estimate, false)));
        Ok(Roles {
            axes: self.axes,
            bodies: bodies
                .map(|(body, is_truth)| found.body(body, is_truth))
                .collect::<Result<_>>()?,
            courses: self.courses.iter().map(|c| found.course(c)).collect::<Result<_>>()?,
            sensors: self.sensors.iter().map(|s| found.sensor(s)).collect::<Result<_>>()?,
        })
    }
}

fn described(name: &str, table: &Table<'_>, known: &[&str]) -> Described {
    table.allow(known);
    let groups =
        table.entries().filter_map(|(key, entry)| Some((key.to_owned(), spelled(&entry)?)));
    Described { name: name.to_owned(), groups: groups.collect() }
}

fn spelled(entry: &Entry<'_>) -> Option<Spelled> {
    if !entry.is_table() {
        return entry.text().map(|text| Spelled::Path(text.to_owned()));
    }
    let table = entry.table()?;
    let each =
        table.entries().map(|(axis, entry)| Some((axis.to_owned(), entry.text()?.to_owned())));
    each.collect::<Option<_>>().map(Spelled::Each)
}

/// Looks up names.
struct Found<'a> {
    names: &'a Names<'a>,
    measures: &'a [Measure],
}

impl Found<'_> {
    fn body(&self, body: &Described, is_truth: bool) -> Result<Body> {
        let pose = self.group(body, "pose", POSE)?;
        if !pose.has([0, 1]) {
            let what = format!("'{}' has no pose with x and y", body.name);
            return Err(Error::new(Code::Roles, what));
        }
        let covariances = match body.get("covariance") {
            Some(Spelled::Path(path)) => covariances(self.names, path),
            Some(Spelled::Each(each)) => each
                .iter()
                .map(|(axes, name)| self.covariance(axes, name))
                .collect::<Result<_>>()?,
            None => Vec::new(),
        };
        Ok(Body {
            name: body.name.clone(),
            is_truth,
            pose,
            velocity: self.group(body, "velocity", VELOCITY)?,
            sigma: self.group(body, "sigma", POSE)?,
            velocity_sigma: self.group(body, "velocity-sigma", VELOCITY)?,
            covariances,
        })
    }

    fn course(&self, course: &Described) -> Result<Course> {
        let position = self.group(course, "position", PLACE)?;
        if position.has([0, 1]) {
            return Ok(Course { name: course.name.clone(), position });
        }
        let what = format!("the course '{}' has no position with x and y", course.name);
        Err(Error::new(Code::Roles, what))
    }

    fn covariance(&self, axes: &str, name: &str) -> Result<(usize, usize, Place)> {
        let place = |axis: &str| POSE.iter().position(|known| *known == axis);
        let pair = axes.split_once('_').and_then(|(one, other)| Some((place(one)?, place(other)?)));
        let (one, other) = pair.ok_or_else(|| {
            Error::new(Code::Roles, format!("'{axes}' is not a pair of axes, such as x_y"))
        })?;
        let measured = Place::needed(self.names, self.measures, name)?;
        Ok((one.min(other), one.max(other), measured))
    }

    fn sensor(&self, sensor: &Described) -> Result<Sensor> {
        let found = Sensor {
            name: sensor.name.clone(),
            specific_force: self.group(sensor, "specific-force", PLACE)?,
            rate: self.group(sensor, "rate", RATE)?,
            attitude: self.group(sensor, "attitude", ATTITUDE)?,
            velocity: self.group(sensor, "velocity", SPEED)?,
            position: self.group(sensor, "position", PLACE)?,
            sigma: self.variable(sensor, "sigma")?,
            pressure: self.variable(sensor, "pressure")?,
            stamp: self.variable(sensor, "stamp")?,
            valid: self.variable(sensor, "valid")?,
        };
        if found.measures() {
            return Ok(found);
        }
        Err(Error::new(Code::Roles, format!("the sensor '{}' measures nothing", sensor.name))
            .why("it has no pressure, no velocity with u, v and w, no position with x and y, no attitude and no specific force with a rate"))
    }

    fn variable(&self, of: &Described, key: &str) -> Result<Option<Place>> {
        match of.get(key) {
            None => Ok(None),
            Some(Spelled::Path(name)) => Place::needed(self.names, self.measures, name).map(Some),
            Some(Spelled::Each(_)) => Err(Error::new(
                Code::Roles,
                format!("'{key}' of '{}' is one variable, but a table is given", of.name),
            )),
        }
    }

    /// All named axes must be recorded; for a path only those that exist, at least one.
    fn group<const N: usize>(
        &self,
        of: &Described,
        key: &str,
        axes: [&str; N],
    ) -> Result<Group<N>> {
        match of.get(key) {
            None => Ok(Group::default()),
            Some(Spelled::Path(path)) => {
                let group = Group::within(self.names, self.measures, path, axes);
                if !group.is_there() {
                    Place::needed(self.names, self.measures, &format!("{path}.{}", axes[0]))?;
                }
                Ok(group)
            }
            Some(Spelled::Each(each)) => {
                let mut places = [None; N];
                for (axis, name) in each {
                    let at = axes.iter().position(|known| known == axis).ok_or_else(|| {
                        let what = format!("'{axis}' is not an axis of '{key}' of '{}'", of.name);
                        let help = did_you_mean(axis, axes).unwrap_or_else(|| axes.join(", "));
                        Error::new(Code::Roles, what).help(help)
                    })?;
                    places[at] = Some(Place::needed(self.names, self.measures, name)?);
                }
                Ok(Group::from_places(places))
            }
        }
    }
}

impl Described {
    fn get(&self, key: &str) -> Option<&Spelled> {
        self.groups.iter().find(|(known, _)| known == key).map(|(_, spelled)| spelled)
    }
}
