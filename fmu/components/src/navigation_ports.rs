//! Inputs of the navigation filters: the measurements of the sensors. All filters have the same
//! inputs and outputs, so that one can replace another; a filter ignores inputs that it does not
//! use.

use fmu_kit::Variables;
use rexrov::axes;
use rexrov::estimation::{Measurements, Reading};

/// Whether and when a measurement was taken. An unconnected measurement is absent.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Stamp {
    /// time of the measurement; -1 if unknown, then it counts as new in every cycle
    #[var(unit = "s", min = -1.0, start = -1.0)]
    pub stamp: f64,
    /// 1 once there is a measurement; at 0 it is never used
    #[var(min = 0.0, max = 1.0)]
    pub valid: f64,
}

impl Stamp {
    fn on<const K: usize>(self, value: [f64; K]) -> Reading<K> {
        Reading { value, stamp: self.stamp, valid: self.valid >= 0.5 }
    }
}

/// Measurements of the inertial unit.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Imu {
    /// specific force
    #[var(unit = "m/s2", elements = axes::BODY)]
    pub specific_force: [f64; 3],
    /// angular velocity
    #[var(elements = axes::ANGULAR_VELOCITY)]
    pub rate: [f64; 3],
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// Measurements of the attitude and heading reference.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Ahrs {
    /// attitude
    #[var(elements = axes::EULER)]
    pub attitude: [f64; 3],
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// Measurements of the velocity log.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Dvl {
    /// velocity over ground at the instrument
    #[var(elements = axes::LINEAR_VELOCITY)]
    pub velocity: [f64; 3],
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// Measurements of the position fix.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Fix {
    /// place
    #[var(elements = axes::HORIZONTAL)]
    pub position: [f64; 2],
    /// standard deviation of each axis as the instrument reports it; 0: fix_sigma holds
    #[var(unit = "m", min = 0.0)]
    pub sigma: f64,
    /// When.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// Measurements of the pressure sensor.
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
    /// Attitude and heading reference
    pub ahrs: Ahrs,
    /// Velocity log
    pub dvl: Dvl,
    /// Position fix
    pub fix: Fix,
    /// Pressure sensor
    pub pressure: Pressure,
    /// Thruster, from its measured speed
    #[var(rename = "thruster", each = axes::THRUST)]
    pub thrust: [f64; 8],
    /// Thrusts of all thrusters
    pub propulsion: Stamp,
}

impl Inputs {
    /// The measurements in the terms of the filters.
    pub fn measurements(&self) -> Measurements {
        let u = self;
        let ([x, y, z], [p, q, r]) = (u.imu.specific_force, u.imu.rate);
        let [north, east] = u.fix.position;
        Measurements {
            imu: u.imu.stamp.on([x, y, z, p, q, r]),
            ahrs: u.ahrs.stamp.on(u.ahrs.attitude),
            dvl: u.dvl.stamp.on(u.dvl.velocity),
            fix: u.fix.stamp.on([north, east, u.fix.sigma]),
            depth: u.pressure.stamp.on([u.pressure.depth]),
            thrust: u.propulsion.on(u.thrust),
        }
    }
}
