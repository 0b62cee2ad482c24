//! The roles of recorded variables: the truth, its estimates, the course, and measurements of
//! sensors.
//!
//! Used by reports, ROS messages, trajectories and the live page. A file declares them
//! ([`Declaration`]); by default the names determine them, as in components of marine vehicles:
//!
//! | what | is a component with |
//! |---|---|
//! | the truth, an estimate | `pose.x`, `pose.y`, ...; an estimate has standard deviations, `sigma.x` ... |
//! | the course | `target.x`, `.y`; also `reference` or `setpoint` |
//! | an inertial unit | `specific_force.x`, `.y`, `.z` and `rate.p`, `.q`, `.r` |
//! | an attitude reference | `attitude.roll`, `.pitch`, `.yaw` |
//! | a velocity log | `velocity.u`, `.v`, `.w` |
//! | a position fix | `position.x`, `.y` |
//! | a pressure gauge | `pressure` |
//!
//! A sensor's `stamp` is the time of its newest sample, `valid` is 0 while there is none.

mod declaration;
mod names;
mod paths;
mod row;

pub use declaration::Declaration;
pub use names::Names;
pub use paths::Paths;
pub use paths::{Choice, Estimate};
pub use row::{Group, Measure, Place, base_factor};

use cosim_base::error::Result;

/// Axes of a pose.
pub const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
/// Axes of a velocity, in body axes.
pub const VELOCITY: [&str; 6] = ["u", "v", "w", "p", "q", "r"];
const PLACE: [&str; 3] = ["x", "y", "z"];
const SPEED: [&str; 3] = ["u", "v", "w"];
const RATE: [&str; 3] = ["p", "q", "r"];
const ATTITUDE: [&str; 3] = ["roll", "pitch", "yaw"];

/// Directions of the axes of positions, velocities and forces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Axes {
    /// North, east, down; for the vehicle forward, starboard, down.
    #[default]
    Ned,
    /// East, north, up; for the vehicle forward, port, up: the convention of ROS.
    Enu,
}

/// The roles of columns.
#[derive(Debug, Clone, Default)]
pub struct Roles {
    /// The axes of all positions and velocities.
    pub axes: Axes,
    /// The truth and the estimates.
    pub bodies: Vec<Body>,
    /// Where bodies are to go.
    pub courses: Vec<Course>,
    /// What measures.
    pub sensors: Vec<Sensor>,
}

/// The truth, or an estimate of it.
#[derive(Debug, Clone, Default)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// It is the truth, not an estimate.
    pub is_truth: bool,
    /// Position and attitude.
    pub pose: Group<6>,
    /// Linear and angular velocity.
    pub velocity: Group<6>,
    /// Standard deviations of the pose.
    pub sigma: Group<6>,
    /// Standard deviations of the velocity.
    pub velocity_sigma: Group<6>,
    /// Covariances of two axes of the pose, the lower axis first.
    pub covariances: Vec<(usize, usize, Place)>,
}

/// The point that a guidance system follows.
#[derive(Debug, Clone, Default)]
pub struct Course {
    /// Its name.
    pub name: String,
    /// The point that is steered for.
    pub position: Group<3>,
}

/// The measurement of a sensor.
#[derive(Debug, Clone, Default)]
pub struct Sensor {
    /// Its name.
    pub name: String,
    pub(crate) specific_force: Group<3>,
    pub(crate) rate: Group<3>,
    pub(crate) attitude: Group<3>,
    pub(crate) velocity: Group<3>,
    /// A measured position.
    pub position: Group<3>,
    /// Of the position, the same for north and east.
    pub(crate) sigma: Option<Place>,
    pub(crate) pressure: Option<Place>,
    pub(crate) stamp: Option<Place>,
    pub(crate) valid: Option<Place>,
}

impl Roles {
    /// The declared roles, otherwise those given by the names.
    pub fn find(
        names: &Names<'_>,
        measures: &[Measure],
        declared: Option<&Declaration>,
    ) -> Result<Self> {
        match declared {
            Some(declared) => declared.resolve(names, measures),
            None => Self::by_names(names, measures),
        }
    }

    fn by_names(names: &Names<'_>, measures: &[Measure]) -> Result<Self> {
        let paths = Paths::find(names, &Choice::default())?;
        let truth = paths.truth.iter().map(|path| (path.clone(), None, true));
        let estimates = paths.estimates.iter().map(|e| (e.path.clone(), Some(e), false));
        let bodies = truth.chain(estimates).map(|(path, estimate, is_truth)| {
            let owner = owner(&path);
            let beside = |group: &str| {
                if owner.is_empty() { group.to_owned() } else { format!("{owner}.{group}") }
            };
            let sigma = estimate.and_then(|estimate| estimate.sigma.clone()).unwrap_or_default();
            let covariance = estimate.and_then(|estimate| estimate.covariance.clone());
            Body {
                name: if owner.is_empty() { path.clone() } else { owner.to_owned() },
                is_truth,
                pose: Group::within(names, measures, &path, POSE),
                velocity: Group::within(names, measures, &beside("velocity"), VELOCITY),
                sigma: Group::within(names, measures, &sigma, POSE),
                velocity_sigma: Group::within(names, measures, &beside("velocity_sigma"), VELOCITY),
                covariances: covariance.map_or(Vec::new(), |path| covariances(names, &path)),
            }
        });
        let bodies: Vec<Body> = bodies.collect();
        let courses = paths.courses.iter().map(|path| Course {
            name: path.clone(),
            position: Group::within(names, measures, path, PLACE),
        });
        let owners = || bodies.iter().map(|body| body.name.as_str());
        let mut sensors: Vec<Sensor> = Vec::new();
        for component in components(names).into_iter().filter(|c| owners().all(|o| o != *c)) {
            let sensor = Sensor::within(names, measures, component);
            if sensor.measures() {
                sensors.push(sensor);
            }
        }
        Ok(Self { axes: Axes::Ned, bodies, courses: courses.collect(), sensors })
    }

    /// The body whose frame sensors are in: the truth, or the first estimate.
    pub(crate) fn main(&self) -> Option<usize> {
        let truth = self.bodies.iter().position(|body| body.is_truth);
        truth.or((!self.bodies.is_empty()).then_some(0))
    }
}

impl Sensor {
    /// The outputs of a component that a sensor may have.
    fn within(names: &Names<'_>, measures: &[Measure], component: &str) -> Self {
        let path = |group: &str| format!("{component}.{group}");
        let place = |leaf: &str| Place::of(names, measures, &path(leaf));
        Self {
            name: component.to_owned(),
            specific_force: Group::whole(names, measures, &path("specific_force"), PLACE),
            rate: Group::whole(names, measures, &path("rate"), RATE),
            attitude: Group::whole(names, measures, &path("attitude"), ATTITUDE),
            velocity: Group::whole(names, measures, &path("velocity"), SPEED),
            position: Group::within(names, measures, &path("position"), PLACE),
            sigma: place("position.sigma").or(place("sigma")),
            pressure: place("pressure"),
            stamp: place("stamp"),
            valid: place("valid"),
        }
    }

    fn measures(&self) -> bool {
        let inertial = self.specific_force.is_there() && self.rate.is_there();
        let others = [&self.attitude, &self.velocity].into_iter().any(Group::is_there);
        inertial || others || self.position.has([0, 1]) || self.pressure.is_some()
    }
}

/// The part before the last dot of a path.
pub(crate) fn owner(path: &str) -> &str {
    path.rsplit_once('.').map_or("", |(owner, _)| owner)
}

/// Prefixes of sensor groups, in the order of the names.
fn components<'a>(names: &Names<'a>) -> Vec<&'a str> {
    const LAST: [&str; 5] =
        [".specific_force.x", ".attitude.roll", ".velocity.u", ".position.x", ".pressure"];
    let mut found: Vec<&str> = Vec::new();
    for name in &names.ordered {
        let component = LAST.iter().find_map(|last| name.strip_suffix(last));
        found.extend(component.filter(|component| !found.contains(component)));
    }
    found
}

/// All pairs of axes of a pose: `x_y`, `x_z`, ...
fn covariances(names: &Names<'_>, path: &str) -> Vec<(usize, usize, Place)> {
    let mut found = Vec::new();
    for (first, one) in POSE.iter().enumerate() {
        for (second, other) in POSE.iter().enumerate().skip(first + 1) {
            let place = names.place(&format!("{path}.{one}_{other}"));
            found.extend(place.map(|place| (first, second, Place::plain(place))));
        }
    }
    found
}
