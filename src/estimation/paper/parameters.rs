//! Parameters of the filters and their validation.

use super::Misprinted;
use crate::ParameterError;
use crate::error::{each, finite, non_negative, positive};

/// Transition matrix F of the covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transition {
    /// As the paper prints it.
    Misprinted(Misprinted),
    /// The Jacobian of eq (36) with rotation: identity and the column of psi.
    Jacobian,
}

impl Default for Transition {
    fn default() -> Self {
        Self::Misprinted(Misprinted::default())
    }
}

/// Process noise covariance Q, each cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProcessNoise {
    /// The diagonal `process_variance`.
    #[default]
    Constant,
    /// Position: `sigma_dvl^2 dt T_dvl`, the random walk caused by DVL noise; psi: as `Constant`.
    Dvl,
}

/// Parameters of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EkfParameters {
    /// Cycles a second (Hz).
    pub rate_hz: f64,
    /// Transition matrix of the covariance.
    pub transition: Transition,
    /// Whether body displacements are rotated into NED by psi; eq (36) as printed does not do this.
    pub rotate_to_ned: bool,
    /// Process noise covariance.
    pub process_noise: ProcessNoise,
    /// Diagonal of Q for x, y, z (m2) and psi (rad2), each cycle.
    pub process_variance: [f64; 4],
    /// Standard deviation of the DVL (m/s), for `ProcessNoise::Dvl`.
    pub dvl_sigma: f64,
    /// Rate of the DVL (Hz), for `ProcessNoise::Dvl`.
    pub dvl_rate_hz: f64,
    /// Standard deviation of the position fix (m).
    pub fix_sigma: f64,
    /// Standard deviation of the depth (m).
    pub depth_sigma: f64,
    /// Standard deviation of the compass (rad).
    pub heading_sigma: f64,
    /// Pose `[x, y, z, yaw]` at the start (m, rad).
    pub initial_pose: [f64; 4],
    /// Its standard deviation (m, rad).
    pub initial_sigma: [f64; 4],
    /// Position of the IMU, body (m).
    pub imu_position: [f64; 3],
    /// Position of the DVL, body (m).
    pub dvl_position: [f64; 3],
    /// Position of the antenna or transponder of the fix, body (m).
    pub fix_position: [f64; 3],
    /// Position of the pressure sensor, body (m).
    pub pressure_position: [f64; 3],
    /// Acceleration of gravity (m/s2), for the kinematic filter.
    pub gravity: f64,
}

impl Default for EkfParameters {
    fn default() -> Self {
        Self {
            rate_hz: 10.0,
            transition: Transition::default(),
            rotate_to_ned: true,
            process_noise: ProcessNoise::Constant,
            process_variance: [1e-4; 4],
            dvl_sigma: 0.001,
            dvl_rate_hz: 7.0,
            fix_sigma: 1.5,
            depth_sigma: 0.306,
            heading_sigma: 0.01,
            initial_pose: [0.0, 0.0, 20.0, 0.0],
            initial_sigma: [0.1, 0.1, 0.1, 0.01],
            imu_position: [0.0; 3],
            dvl_position: [-1.4, 0.0, 0.312],
            fix_position: [0.0; 3],
            pressure_position: [-1.32, -0.5, -0.85],
            gravity: 9.81,
        }
    }
}

impl EkfParameters {
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        if let Transition::Misprinted(f) = &self.transition {
            f.check()?;
        }
        each("process_variance", &self.process_variance, non_negative)?;
        non_negative("dvl_sigma", self.dvl_sigma)?;
        positive("dvl_rate_hz", self.dvl_rate_hz)?;
        positive("fix_sigma", self.fix_sigma)?;
        positive("depth_sigma", self.depth_sigma)?;
        positive("heading_sigma", self.heading_sigma)?;
        each("initial_pose", &self.initial_pose, finite)?;
        each("initial_sigma", &self.initial_sigma, non_negative)?;
        each("imu_position", &self.imu_position, finite)?;
        each("dvl_position", &self.dvl_position, finite)?;
        each("fix_position", &self.fix_position, finite)?;
        each("pressure_position", &self.pressure_position, finite)?;
        non_negative("gravity", self.gravity)
    }
}
