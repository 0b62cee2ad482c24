//! Outputs of the navigation filters: the estimate and how far it can be trusted.

use fmu_kit::{Member, Variables};
use rexrov::axes;
use rexrov::estimation::{Estimate, Health};
use serde::{Deserialize, Serialize};

/// Elements of the covariance off its diagonal.
pub const COVARIANCE: [Member; 15] = [
    Member::new("x_y", "north and east").unit("m2"),
    Member::new("x_z", "north and down").unit("m2"),
    Member::new("x_roll", "north and roll").unit("m.rad"),
    Member::new("x_pitch", "north and pitch").unit("m.rad"),
    Member::new("x_yaw", "north and yaw").unit("m.rad"),
    Member::new("y_z", "east and down").unit("m2"),
    Member::new("y_roll", "east and roll").unit("m.rad"),
    Member::new("y_pitch", "east and pitch").unit("m.rad"),
    Member::new("y_yaw", "east and yaw").unit("m.rad"),
    Member::new("z_roll", "down and roll").unit("m.rad"),
    Member::new("z_pitch", "down and pitch").unit("m.rad"),
    Member::new("z_yaw", "down and yaw").unit("m.rad"),
    Member::new("roll_pitch", "roll and pitch").unit("rad2"),
    Member::new("roll_yaw", "roll and yaw").unit("rad2"),
    Member::new("pitch_yaw", "pitch and yaw").unit("rad2"),
];

/// A number for each sensor.
const CHANNELS: [Member; 5] = [
    Member::new("tilt", "roll and pitch of the attitude reference").unit("1").min(0.0),
    Member::new("heading", "heading").unit("1").min(0.0),
    Member::new("depth", "depth").unit("1").min(0.0),
    Member::new("dvl", "velocity log").unit("1").min(0.0),
    Member::new("fix", "position fix").unit("1").min(0.0),
];

/// What became of a sensor's measurements.
const COUNT: [Member; 3] = [
    Member::new("used", "used").unit("1").min(0.0),
    Member::new("rejected", "limited as outliers, or refused as not fit").unit("1").min(0.0),
    Member::new("late", "come late: put in their place, or lost where that is forgotten already")
        .unit("1")
        .min(0.0),
];

/// The estimated loss of a thruster.
const LOSS: Member = Member::new(
    "loss",
    "fraction of its thrust that is taken to be lost; 0 where the filter does not look for it",
)
.unit("1");

/// The comparison of a measurement with its prediction, for each sensor.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Innovation {
    /// roll and pitch of the attitude reference
    #[var(elements = axes::TILT)]
    pub tilt: [f64; 2],
    /// heading
    #[var(unit = "rad")]
    pub heading: f64,
    /// depth
    #[var(unit = "m")]
    pub depth: f64,
    /// velocity log
    #[var(elements = axes::LINEAR_VELOCITY)]
    pub dvl: [f64; 3],
    /// position fix
    #[var(elements = axes::HORIZONTAL)]
    pub fix: [f64; 2],
}

impl Innovation {
    fn of([tilt, heading, depth, dvl, fix]: [[f64; 3]; 5]) -> Self {
        let ([roll, pitch, _], [heading, ..], [depth, ..]) = (tilt, heading, depth);
        let [x, y, _] = fix;
        Self { tilt: [roll, pitch], heading, depth, dvl, fix: [x, y] }
    }
}

/// What happened to the measurements of each sensor.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Counts {
    /// roll and pitch of the attitude reference
    #[var(elements = COUNT)]
    pub tilt: [f64; 3],
    /// heading
    #[var(elements = COUNT)]
    pub heading: [f64; 3],
    /// depth
    #[var(elements = COUNT)]
    pub depth: [f64; 3],
    /// velocity log
    #[var(elements = COUNT)]
    pub dvl: [f64; 3],
    /// position fix
    #[var(elements = COUNT)]
    pub fix: [f64; 3],
}

/// Outputs of a filter.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Estimated pose
    #[var(elements = axes::POSE)]
    pub pose: [f64; 6],
    /// Estimated velocity over ground, body frame
    #[var(elements = axes::VELOCITY)]
    pub velocity: [f64; 6],
    /// Estimated acceleration, body frame
    #[var(elements = axes::LINEAR_ACCELERATION)]
    pub acceleration: [f64; 3],
    /// Estimated current; 0 where the filter has none
    #[var(elements = axes::HORIZONTAL_VELOCITY)]
    pub current: [f64; 2],
    /// Standard deviation of the pose
    #[var(min = 0.0, elements = axes::POSE)]
    pub sigma: [f64; 6],
    /// Standard deviation of the velocity
    #[var(min = 0.0, elements = axes::LINEAR_VELOCITY)]
    pub velocity_sigma: [f64; 3],
    /// Covariance of the pose
    #[var(elements = COVARIANCE)]
    pub covariance: [f64; 15],
    /// Newest measurement less its prediction
    pub innovation: Innovation,
    /// Standard deviation of the innovation
    #[var(min = 0.0)]
    pub innovation_sigma: Innovation,
    /// Normalised innovation squared
    #[var(elements = CHANNELS)]
    pub nis: [f64; 5],
    /// Measurements
    pub count: Counts,
    /// Thruster
    #[var(rename = "thruster", each = LOSS)]
    pub loss: [f64; 8],
    /// 0: good, 1: starved (neither velocity nor fix bounds the position), 2: inconsistent
    /// (measurements contradict the estimate), 3: diverged (lost and begun again)
    #[var(unit = "1", min = 0.0, max = 3.0)]
    pub health: f64,
}

/// The number of a state of health in an FMU.
pub fn number(health: Health) -> u8 {
    match health {
        Health::Good => 0,
        Health::Starved => 1,
        Health::Inconsistent => 2,
        Health::Diverged => 3,
    }
}

impl Outputs {
    /// An estimate as outputs.
    pub fn of(e: &Estimate) -> Self {
        let ([x, y, z], [roll, pitch, yaw]) = (e.position, e.euler);
        let ([u, v, w], [p, q, r]) = (e.velocity, e.rate);
        let element = |i: usize, j: usize| {
            e.covariance.get(i).and_then(|row| row.get(j)).copied().unwrap_or_default()
        };
        let mut pairs = (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j)));
        let counts = e.channels.map(|c| [c.used, c.rejected, c.late].map(f64::from));
        let [tilt, heading, depth, dvl, fix] = counts;
        Self {
            pose: [x, y, z, roll, pitch, yaw],
            velocity: [u, v, w, p, q, r],
            acceleration: e.acceleration,
            current: e.current,
            sigma: std::array::from_fn(|i| element(i, i).max(0.0).sqrt()),
            velocity_sigma: e.velocity_sigma,
            covariance: std::array::from_fn(|_| pairs.next().map_or(0.0, |(i, j)| element(i, j))),
            innovation: Innovation::of(e.channels.map(|c| c.innovation)),
            innovation_sigma: Innovation::of(e.channels.map(|c| c.sigma)),
            nis: e.channels.map(|c| c.nis.min(f64::MAX)),
            count: Counts { tilt, heading, depth, dvl, fix },
            loss: e.loss,
            health: f64::from(number(e.health)),
        }
    }
}
