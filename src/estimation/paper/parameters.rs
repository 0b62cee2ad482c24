//! Parameters of the filters.

use super::Misprinted;
use crate::axes;
use crate::estimation::Mounting;
use fmu_quantity::{Enumeration, Member, Variables};

/// Transition matrix F of the covariance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
pub enum Transition {
    /// eqs (44) to (47), guarded where they are singular
    #[default]
    Paper,
    /// eqs (44) to (47) as printed, only kept finite
    PaperUnguarded,
    /// the Jacobian of the prediction
    ///
    /// That of eq (36) with rotation: identity and the column of psi.
    Repaired,
}

/// Process noise covariance Q.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
pub enum ProcessNoise {
    /// the diagonal process_variance, each cycle
    #[default]
    Constant,
    /// the random walk of position that noise of the velocity log makes
    ///
    /// Position: `sigma_dvl^2 dt T_dvl`; psi: as `Constant`.
    Dvl,
}

/// A variance for each state.
const VARIANCE: [Member; 4] = [
    Member::new("x", "north").unit("m2").min(0.0),
    Member::new("y", "east").unit("m2").min(0.0),
    Member::new("z", "down").unit("m2").min(0.0),
    Member::new("yaw", "yaw").unit("rad2").min(0.0),
];

/// Parameters of a filter.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct EkfParameters {
    /// Cycles a second
    #[var(unit = "Hz", min = 0.001, max = 1e6, start = 10.0)]
    pub rate_hz: f64,
    /// Transition matrix F of the covariance
    pub transition: Transition,
    /// Speed (m/s, rad/s) below which F of transition Paper is 1
    ///
    /// The quotients of F become meaningless there. The paper has no such limit, which is 0. The
    /// start value is chosen, together with the sensors' noise, to match the levels of its Tables 7
    /// to 9.
    #[var(min = 0.0, start = 0.0029)]
    pub guard_speed: f64,
    /// Turn body displacements into NED; eq (36) as printed does not
    #[var(start = true)]
    pub rotate_to_ned: bool,
    /// Process noise covariance Q
    pub process_noise: ProcessNoise,
    /// Diagonal of Q, each cycle
    #[var(elements = VARIANCE, start = [1e-4; 4])]
    pub process_variance: [f64; 4],
    /// Standard deviation of the velocity log, for process_noise Dvl
    #[var(unit = "m/s", min = 0.0, start = 0.001)]
    pub dvl_sigma: f64,
    /// Rate of the velocity log, for process_noise Dvl
    #[var(unit = "Hz", min = 0.001, max = 1e6, start = 7.0)]
    pub dvl_rate_hz: f64,
    /// Standard deviation of the position fix
    #[var(unit = "m", min = 1e-9, start = 1.5)]
    pub fix_sigma: f64,
    /// Standard deviation of the depth
    #[var(unit = "m", min = 1e-9, start = 0.306)]
    pub depth_sigma: f64,
    /// Standard deviation of the compass
    #[var(unit = "rad", min = 1e-9, start = 0.01)]
    pub heading_sigma: f64,
    /// Start: pose
    #[var(rename = "initial.pose", elements = axes::POSE4, start = [0.0, 0.0, 20.0, 0.0])]
    pub initial_pose: [f64; 4],
    /// Start: standard deviation
    ///
    /// Of the pose.
    #[var(
        rename = "initial.sigma",
        min = 0.0,
        elements = axes::POSE4,
        start = [0.1, 0.1, 0.1, 0.01]
    )]
    pub initial_sigma: [f64; 4],
    /// Place in the body frame
    pub mounting: Mounting,
    /// Acceleration of gravity
    ///
    /// For the kinematic filter.
    #[var(unit = "m/s2", min = 0.0, start = 9.81)]
    pub gravity: f64,
}

impl EkfParameters {
    /// The printed F, if it is chosen.
    pub(super) fn misprinted(&self) -> Option<Misprinted> {
        match self.transition {
            Transition::Paper => Some(Misprinted { guard_speed: self.guard_speed }),
            Transition::PaperUnguarded => Some(Misprinted { guard_speed: 0.0 }),
            Transition::Repaired => None,
        }
    }
}
