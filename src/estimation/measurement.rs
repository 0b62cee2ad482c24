//! What a filter is given each cycle, and what it refuses.

use crate::sensors::{DvlSample, GpsSample, ImuSample};

/// The latest value of an instrument, with the time it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<T> {
    /// The value.
    pub value: T,
    /// Time of measurement (s); negative: unknown, so the value counts as new in every cycle.
    pub stamp: f64,
    /// False while the instrument has not measured yet.
    pub valid: bool,
}

impl<T: Default> Default for Reading<T> {
    fn default() -> Self {
        Self { value: T::default(), stamp: -1.0, valid: true }
    }
}

impl<T> Reading<T> {
    /// Whether this is a measurement later than the one at `seen`, which it then replaces.
    pub(super) fn take_new(&self, seen: &mut f64) -> bool {
        let new = self.valid && (self.stamp < 0.0 || self.stamp > *seen);
        if new {
            *seen = self.stamp;
        }
        new
    }
}

/// Everything that a filter can use in a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurements {
    /// Specific force, turn rate and orientation.
    pub imu: Reading<ImuSample>,
    /// Velocity at the DVL.
    pub dvl: Reading<DvlSample>,
    /// Position fix.
    pub fix: Reading<GpsSample>,
    /// Depth of the pressure sensor (m).
    pub pressure: Reading<f64>,
    /// Thrusts (N), measured or from rotor speeds; the kinematic filter ignores them.
    pub thrust: [f64; 8],
}

/// A cycle that cannot be computed; the filter's memory is left as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{quantity} = {value}: {reason}")]
pub struct EstimationError {
    /// Which measurement or state it is.
    pub quantity: String,
    /// Its value.
    pub value: f64,
    /// What that means and what to do.
    pub reason: &'static str,
}

impl Measurements {
    /// Refuses measurements that are not numbers; those marked invalid are not looked at.
    pub(super) fn check(&self, with_thrust: bool) -> Result<(), EstimationError> {
        let imu = &self.imu.value;
        check("imu.specific_force", self.imu.valid, &imu.specific_force)?;
        check("imu.rate", self.imu.valid, &imu.rate)?;
        check("imu.attitude", self.imu.valid, &imu.euler)?;
        check("dvl.velocity", self.dvl.valid, &self.dvl.value.velocity)?;
        check("fix.position", self.fix.valid, &self.fix.value.position)?;
        check("pressure.depth", self.pressure.valid, &[self.pressure.value])?;
        let stamps = [self.imu.stamp, self.dvl.stamp, self.fix.stamp, self.pressure.stamp];
        check("stamp of imu, dvl, fix, pressure", true, &stamps)?;
        check("thrust", with_thrust, &self.thrust)
    }
}

fn check(name: &str, used: bool, values: &[f64]) -> Result<(), EstimationError> {
    let bad = values.iter().enumerate().find(|(_, v)| used && !v.is_finite());
    match bad {
        None => Ok(()),
        Some((i, &value)) => Err(EstimationError {
            quantity: format!("{name}[{i}]"),
            value,
            reason: "a measurement must be a finite number; mark it invalid while it is not",
        }),
    }
}
