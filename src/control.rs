//! Velocity control, as in UUV Simulator: velocity error to thrust.
//!
//! A PID on the linear and the angular velocity error gives an acceleration, limited axis by axis.
//! Multiplied by rigid mass and inertia it is a wrench, which is allocated to the thrusters by what
//! each can give, and clipped thruster by thruster. Roll and pitch rate are commanded to zero.
//! Fossen (2011) ch. 12.

use crate::ParameterError;
use crate::allocation::{Allocation, Degraded};
use crate::error::{non_negative, positive};
use crate::sampling::Rate;
use crate::vector::{Vec3, mul};
use crate::vehicle::{Inertia, Parameters, Thruster};
use serde::{Deserialize, Serialize};

/// Gains of three axes of the same kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pid {
    /// Proportional gain (1/s).
    pub p: f64,
    /// Integral gain (1/s2).
    pub i: f64,
    /// Derivative gain (1), on the measured velocity, so a step in the command causes no derivative
    /// kick.
    pub d: f64,
    /// Limit of the demanded acceleration (m/s2 or rad/s2).
    pub saturation: f64,
}

/// Parameters of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerParameters {
    /// Cycles a second (Hz).
    pub rate_hz: f64,
    /// Surge, sway, heave.
    pub linear: Pid,
    /// Roll, pitch, yaw.
    pub angular: Pid,
    /// Rigid mass (kg).
    pub mass: f64,
    /// Rigid inertia (kg.m2).
    pub inertia: Inertia,
    /// Geometry of the thrusters.
    pub thrusters: [Thruster; 8],
    /// Limit of each thruster, either sign (N).
    pub thrust_limit: f64,
}

impl Default for ControllerParameters {
    fn default() -> Self {
        let vehicle = Parameters::default();
        Self {
            rate_hz: 50.0,
            linear: Pid { p: 10.0, i: 2.0, d: 0.0, saturation: 20.0 },
            angular: Pid { p: 10.0, i: 2.0, d: 1.0, saturation: 5.0 },
            mass: vehicle.mass,
            inertia: vehicle.inertia,
            thrusters: vehicle.propulsion.thrusters,
            thrust_limit: vehicle.propulsion.thrust_limit,
        }
    }
}

impl Pid {
    fn check(&self, name: &str) -> Result<(), ParameterError> {
        non_negative(&format!("{name}.p"), self.p)?;
        non_negative(&format!("{name}.i"), self.i)?;
        non_negative(&format!("{name}.d"), self.d)?;
        positive(&format!("{name}.saturation"), self.saturation)
    }
}

/// Integrals of the velocity error, the velocity at the previous cycle, and the allocation in use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ControllerMemory {
    integral: [f64; 6],
    previous: Option<[f64; 6]>,
    degraded: Option<Degraded>,
}

/// Outputs of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Demand {
    /// Thruster forces to command, limited (N).
    pub force: [f64; 8],
    /// The demanded wrench `[X, Y, Z, K, M, N]`, before the limits of the thrusters (N, N.m).
    pub wrench: [f64; 6],
}

/// The controller, with its constants derived and checked.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityController {
    /// How often it runs.
    pub rate: Rate,
    /// Gains axis by axis.
    gains: [Pid; 6],
    mass: f64,
    inertia: [Vec3; 3],
    allocation: Allocation,
    thrust_limit: f64,
}

impl VelocityController {
    /// Checks the parameters and inverts the thruster geometry.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &ControllerParameters) -> Result<Self, ParameterError> {
        p.linear.check("linear")?;
        p.angular.check("angular")?;
        positive("mass", p.mass)?;
        p.inertia.check()?;
        positive("thrust_limit", p.thrust_limit)?;
        Ok(Self {
            rate: Rate::new(p.rate_hz)?,
            gains: core::array::from_fn(|i| if i < 3 { p.linear } else { p.angular }),
            mass: p.mass,
            inertia: p.inertia.matrix(),
            allocation: Allocation::new(&p.thrusters)?,
            thrust_limit: p.thrust_limit,
        })
    }

    /// One cycle: commanded `[u, v, w, r]` and the velocity `nu`, both in the body frame, and the
    /// fraction of its thrust that each thruster has lost, 0 to 1.
    pub fn update(
        &self,
        memory: &mut ControllerMemory,
        [u, v, w, r]: [f64; 4],
        nu: [f64; 6],
        loss: &[f64; 8],
    ) -> Demand {
        let period = self.rate.period();
        let target = [u, v, w, 0.0, 0.0, r];
        let previous = memory.previous.replace(nu).unwrap_or(nu);
        let mut integral = memory.integral;
        let acceleration: [f64; 6] = core::array::from_fn(|i| {
            let (gain, error) = (&self.gains[i], target[i] - nu[i]);
            integral[i] += error * period;
            let damping = gain.d * (nu[i] - previous[i]) / period;
            let demand = gain.p * error + gain.i * integral[i] - damping;
            let limited = demand.clamp(-gain.saturation, gain.saturation);
            if limited != demand {
                integral[i] = memory.integral[i];
            }
            limited
        });
        let wrench = self.wrench(&acceleration);
        let wanted = self.allocation.forces_with_loss(loss, &mut memory.degraded, &wrench);
        let force = wanted.map(|f| f.clamp(-self.thrust_limit, self.thrust_limit));
        // Anti-windup: an error that the thrusters cannot reduce any faster is not integrated.
        if force == wanted {
            memory.integral = integral;
        }
        Demand { force, wrench }
    }

    fn wrench(&self, a: &[f64; 6]) -> [f64; 6] {
        let moment = mul(&self.inertia, [a[3], a[4], a[5]]);
        let m = self.mass;
        [m * a[0], m * a[1], m * a[2], moment[0], moment[1], moment[2]]
    }
}
