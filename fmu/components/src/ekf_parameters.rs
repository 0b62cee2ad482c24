//! Parameters that both filters of the paper share: `rexrov::estimation::paper::EkfParameters` as
//! FMI variables.

use crate::groups::Pose4;
use crate::navigation_parameters::Mounting;
use fmu_kit::{Enumeration, Variables};
use rexrov::estimation::paper::{self, EkfParameters, Misprinted};

/// Transition matrix F of the covariance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum Transition {
    /// eqs (44) to (47), guarded where they are singular
    #[default]
    Paper,
    /// eqs (44) to (47) as printed, only kept finite
    PaperUnguarded,
    /// the Jacobian of the prediction
    Repaired,
}

/// Process noise covariance Q.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum ProcessNoise {
    /// the diagonal process_variance, each cycle
    #[default]
    Constant,
    /// the random walk of position that noise of the velocity log makes
    Dvl,
}

/// A variance for each state.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Variance {
    /// north
    #[var(unit = "m2", min = 0.0)]
    pub x: f64,
    /// east
    #[var(unit = "m2", min = 0.0)]
    pub y: f64,
    /// down
    #[var(unit = "m2", min = 0.0)]
    pub z: f64,
    /// yaw
    #[var(unit = "rad2", min = 0.0)]
    pub yaw: f64,
}

/// Assumptions at the start.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Start {
    /// pose
    pub pose: Pose4,
    /// standard deviation
    #[var(min = 0.0)]
    pub sigma: Pose4,
}

/// Parameters of both filters.
#[derive(Clone, Debug, Variables)]
pub struct FilterParameters {
    /// Cycles a second
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub rate_hz: f64,
    /// Transition matrix F of the covariance
    pub transition: Transition,
    /// Speed (m/s, rad/s) below which F of transition Paper is 1
    #[var(min = 0.0)]
    pub guard_speed: f64,
    /// Turn body displacements into NED; eq (36) as printed does not
    pub rotate_to_ned: bool,
    /// Process noise covariance Q
    pub process_noise: ProcessNoise,
    /// Diagonal of Q, each cycle
    pub process_variance: Variance,
    /// Standard deviation of the velocity log, for process_noise Dvl
    #[var(unit = "m/s", min = 0.0)]
    pub dvl_sigma: f64,
    /// Rate of the velocity log, for process_noise Dvl
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub dvl_rate_hz: f64,
    /// Standard deviation of the position fix
    #[var(unit = "m", min = 1e-9)]
    pub fix_sigma: f64,
    /// Standard deviation of the depth
    #[var(unit = "m", min = 1e-9)]
    pub depth_sigma: f64,
    /// Standard deviation of the compass
    #[var(unit = "rad", min = 1e-9)]
    pub heading_sigma: f64,
    /// Start
    pub initial: Start,
    /// Place in the body frame
    pub mounting: Mounting,
    /// Acceleration of gravity
    #[var(unit = "m/s2", min = 0.0)]
    pub gravity: f64,
}

impl Default for FilterParameters {
    fn default() -> Self {
        let p = EkfParameters::default();
        let [x, y, z, yaw] = p.process_variance;
        Self {
            rate_hz: p.rate_hz,
            transition: Transition::default(),
            guard_speed: Misprinted::default().guard_speed,
            rotate_to_ned: p.rotate_to_ned,
            process_noise: ProcessNoise::default(),
            process_variance: Variance { x, y, z, yaw },
            dvl_sigma: p.dvl_sigma,
            dvl_rate_hz: p.dvl_rate_hz,
            fix_sigma: p.fix_sigma,
            depth_sigma: p.depth_sigma,
            heading_sigma: p.heading_sigma,
            initial: Start { pose: p.initial_pose.into(), sigma: p.initial_sigma.into() },
            mounting: Mounting {
                imu: p.imu_position.into(),
                dvl: p.dvl_position.into(),
                fix: p.fix_position.into(),
                pressure: p.pressure_position.into(),
            },
            gravity: p.gravity,
        }
    }
}

impl From<&FilterParameters> for EkfParameters {
    fn from(p: &FilterParameters) -> Self {
        let Variance { x, y, z, yaw } = p.process_variance;
        let misprinted = |guard_speed| paper::Transition::Misprinted(Misprinted { guard_speed });
        Self {
            rate_hz: p.rate_hz,
            transition: match p.transition {
                Transition::Paper => misprinted(p.guard_speed),
                Transition::PaperUnguarded => misprinted(0.0),
                Transition::Repaired => paper::Transition::Jacobian,
            },
            rotate_to_ned: p.rotate_to_ned,
            process_noise: match p.process_noise {
                ProcessNoise::Constant => paper::ProcessNoise::Constant,
                ProcessNoise::Dvl => paper::ProcessNoise::Dvl,
            },
            process_variance: [x, y, z, yaw],
            dvl_sigma: p.dvl_sigma,
            dvl_rate_hz: p.dvl_rate_hz,
            fix_sigma: p.fix_sigma,
            depth_sigma: p.depth_sigma,
            heading_sigma: p.heading_sigma,
            initial_pose: p.initial.pose.into(),
            initial_sigma: p.initial.sigma.into(),
            imu_position: p.mounting.imu.into(),
            dvl_position: p.mounting.dvl.into(),
            fix_position: p.mounting.fix.into(),
            pressure_position: p.mounting.pressure.into(),
            gravity: p.gravity,
        }
    }
}
