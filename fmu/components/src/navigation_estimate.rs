//! Outputs of the navigation filters: the estimate and how far it can be trusted.

use crate::groups::{Horizontal, LinearAcceleration, LinearVelocity, Pose, Velocity};
use fmu_kit::Variables;
use rexrov::estimation::{ChannelReport, Estimate, Health};
use serde::{Deserialize, Serialize};

/// Current of the water.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Current {
    /// north
    #[var(unit = "m/s")]
    pub north: f64,
    /// east
    #[var(unit = "m/s")]
    pub east: f64,
}

crate::groups::group! {
    /// Elements of the covariance off its diagonal.
    Covariance = [
        /// north and east
        #[var(unit = "m2")] x_y,
        /// north and down
        #[var(unit = "m2")] x_z,
        /// north and roll
        #[var(unit = "m.rad")] x_roll,
        /// north and pitch
        #[var(unit = "m.rad")] x_pitch,
        /// north and yaw
        #[var(unit = "m.rad")] x_yaw,
        /// east and down
        #[var(unit = "m2")] y_z,
        /// east and roll
        #[var(unit = "m.rad")] y_roll,
        /// east and pitch
        #[var(unit = "m.rad")] y_pitch,
        /// east and yaw
        #[var(unit = "m.rad")] y_yaw,
        /// down and roll
        #[var(unit = "m.rad")] z_roll,
        /// down and pitch
        #[var(unit = "m.rad")] z_pitch,
        /// down and yaw
        #[var(unit = "m.rad")] z_yaw,
        /// roll and pitch
        #[var(unit = "rad2")] roll_pitch,
        /// roll and yaw
        #[var(unit = "rad2")] roll_yaw,
        /// pitch and yaw
        #[var(unit = "rad2")] pitch_yaw; 15]
}

/// Roll and pitch.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Tilt {
    /// roll
    #[var(unit = "rad")]
    pub roll: f64,
    /// pitch
    #[var(unit = "rad")]
    pub pitch: f64,
}

/// The comparison of a measurement with its prediction, for each sensor.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Innovation {
    /// roll and pitch of the attitude reference
    pub tilt: Tilt,
    /// heading
    #[var(unit = "rad")]
    pub heading: f64,
    /// depth
    #[var(unit = "m")]
    pub depth: f64,
    /// velocity log
    pub dvl: LinearVelocity,
    /// position fix
    pub fix: Horizontal,
}

impl Innovation {
    fn of([tilt, heading, depth, dvl, fix]: [[f64; 3]; 5]) -> Self {
        let ([roll, pitch, _], [heading, ..], [depth, ..]) = (tilt, heading, depth);
        let [x, y, _] = fix;
        Self { tilt: Tilt { roll, pitch }, heading, depth, dvl: dvl.into(), fix: [x, y].into() }
    }
}

crate::groups::group! {
    /// A number for each sensor.
    Channels = [
        /// roll and pitch of the attitude reference
        #[var(unit = "1", min = 0.0)] tilt,
        /// heading
        #[var(unit = "1", min = 0.0)] heading,
        /// depth
        #[var(unit = "1", min = 0.0)] depth,
        /// velocity log
        #[var(unit = "1", min = 0.0)] dvl,
        /// position fix
        #[var(unit = "1", min = 0.0)] fix; 5]
}

crate::groups::group! {
    /// What became of a sensor's measurements.
    Count = [
        /// used
        #[var(unit = "1", min = 0.0)] used,
        /// limited as outliers, or refused as not fit
        #[var(unit = "1", min = 0.0)] rejected,
        /// come late: put in their place, or lost where that is forgotten already
        #[var(unit = "1", min = 0.0)] late; 3]
}

/// What happened to the measurements of each sensor.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Counts {
    /// roll and pitch of the attitude reference
    pub tilt: Count,
    /// heading
    pub heading: Count,
    /// depth
    pub depth: Count,
    /// velocity log
    pub dvl: Count,
    /// position fix
    pub fix: Count,
}

/// The estimated loss of a thruster.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Loss {
    /// fraction of its thrust that is taken to be lost; 0 where the filter does not look for it
    #[var(unit = "1")]
    pub loss: f64,
}

/// Outputs of a filter.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Estimated pose
    pub pose: Pose,
    /// Estimated velocity over ground, body frame
    pub velocity: Velocity,
    /// Estimated acceleration, body frame
    pub acceleration: LinearAcceleration,
    /// Estimated current; 0 where the filter has none
    pub current: Current,
    /// Standard deviation of the pose
    #[var(min = 0.0)]
    pub sigma: Pose,
    /// Standard deviation of the velocity
    #[var(min = 0.0)]
    pub velocity_sigma: LinearVelocity,
    /// Covariance of the pose
    pub covariance: Covariance,
    /// Newest measurement less its prediction
    pub innovation: Innovation,
    /// Standard deviation of the innovation
    #[var(min = 0.0)]
    pub innovation_sigma: Innovation,
    /// Normalised innovation squared
    pub nis: Channels,
    /// Measurements
    pub count: Counts,
    /// Thruster
    pub thruster: [Loss; 8],
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

impl From<&ChannelReport> for Count {
    fn from(c: &ChannelReport) -> Self {
        [c.used, c.rejected, c.late].map(f64::from).into()
    }
}

impl From<&Estimate> for Outputs {
    fn from(e: &Estimate) -> Self {
        let ([x, y, z], [roll, pitch, yaw]) = (e.position, e.euler);
        let ([u, v, w], [p, q, r]) = (e.velocity, e.rate);
        let ([north, east], [tilt, heading, depth, dvl, fix]) = (e.current, &e.channels);
        let element = |i: usize, j: usize| {
            e.covariance.get(i).and_then(|row| row.get(j)).copied().unwrap_or_default()
        };
        let mut pairs = (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j)));
        let covariance: [f64; 15] =
            std::array::from_fn(|_| pairs.next().map_or(0.0, |(i, j)| element(i, j)));
        let sigma: [f64; 6] = std::array::from_fn(|i| element(i, i).max(0.0).sqrt());
        Self {
            pose: [x, y, z, roll, pitch, yaw].into(),
            velocity: [u, v, w, p, q, r].into(),
            acceleration: e.acceleration.into(),
            current: Current { north, east },
            sigma: sigma.into(),
            velocity_sigma: e.velocity_sigma.into(),
            covariance: covariance.into(),
            innovation: Innovation::of(e.channels.map(|c| c.innovation)),
            innovation_sigma: Innovation::of(e.channels.map(|c| c.sigma)),
            nis: e.channels.map(|c| c.nis.min(f64::MAX)).into(),
            count: Counts {
                tilt: tilt.into(),
                heading: heading.into(),
                depth: depth.into(),
                dvl: dvl.into(),
                fix: fix.into(),
            },
            thruster: e.loss.map(|loss| Loss { loss }),
            health: f64::from(number(e.health)),
        }
    }
}
