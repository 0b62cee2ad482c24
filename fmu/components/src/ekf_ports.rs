//! Ports of the filters: what the sensors say, and the estimate.

use crate::groups::{
    Acceleration4, AngularVelocity, Attitude, Horizontal, LinearVelocity, Pose4, Thrust, Vector,
    Velocity4,
};
use fmu_kit::Variables;
use rexrov::estimation::{Estimate, Measurements, Reading};
use rexrov::sensors::{DvlSample, GpsSample, ImuSample};
use serde::{Deserialize, Serialize};

/// When a measurement was taken.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Stamp {
    /// time of the measurement; -1 if unknown, then it counts as new in every cycle
    #[var(unit = "s", min = -1.0)]
    pub stamp: f64,
    /// 1 once there is a measurement, 0 before
    #[var(min = 0.0, max = 1.0)]
    pub valid: f64,
}

impl Default for Stamp {
    fn default() -> Self {
        Self { stamp: -1.0, valid: 1.0 }
    }
}

impl Stamp {
    fn on<T>(self, value: T) -> Reading<T> {
        Reading { value, stamp: self.stamp, valid: self.valid >= 0.5 }
    }
}

/// What the inertial unit measured.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Imu {
    /// specific force
    #[var(unit = "m/s2")]
    pub specific_force: Vector,
    /// angular velocity
    pub rate: AngularVelocity,
    /// attitude
    pub attitude: Attitude,
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// What the velocity log measured.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Dvl {
    /// velocity over ground at the instrument
    pub velocity: LinearVelocity,
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// What the position fix measured.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Fix {
    /// place
    pub position: Horizontal,
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// What the pressure sensor measured.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Pressure {
    /// depth of the sensor
    #[var(unit = "m")]
    pub depth: f64,
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// Inputs of a filter.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// Inertial unit
    pub imu: Imu,
    /// Velocity log
    pub dvl: Dvl,
    /// Position fix
    pub fix: Fix,
    /// Pressure sensor
    pub pressure: Pressure,
    /// Thruster
    pub thruster: [Thrust; 8],
}

impl From<&Inputs> for Measurements {
    fn from(u: &Inputs) -> Self {
        let imu = ImuSample {
            specific_force: u.imu.specific_force.into(),
            rate: u.imu.rate.into(),
            euler: u.imu.attitude.into(),
        };
        let dvl = DvlSample { velocity: u.dvl.velocity.into() };
        let fix = GpsSample { position: u.fix.position.into() };
        Self {
            imu: u.imu.stamp.on(imu),
            dvl: u.dvl.stamp.on(dvl),
            fix: u.fix.stamp.on(fix),
            pressure: u.pressure.stamp.on(u.pressure.depth),
            thrust: u.thruster.map(|thruster| thruster.thrust),
        }
    }
}

/// Outputs of a filter.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Estimated pose
    pub pose: Pose4,
    /// Velocity over ground used in the prediction, body frame
    pub velocity: Velocity4,
    /// Acceleration used in the prediction, body frame
    pub acceleration: Acceleration4,
    /// Standard deviation of the estimate
    #[var(min = 0.0)]
    pub sigma: Pose4,
    /// Covariance of the estimate
    pub covariance: Covariance,
}

/// Elements of the covariance off its diagonal.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Covariance {
    /// north and east
    #[var(unit = "m2")]
    pub x_y: f64,
}

impl From<Estimate> for Outputs {
    fn from(e: Estimate) -> Self {
        Self {
            pose: e.pose.into(),
            velocity: e.velocity.into(),
            acceleration: e.acceleration.into(),
            sigma: e.sigma.into(),
            covariance: Covariance { x_y: e.covariance_xy },
        }
    }
}
