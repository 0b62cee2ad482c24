//! Velocity control, as in UUV Simulator: velocity error to thrust.
//!
//! A PID on the linear and the angular velocity error gives an acceleration, limited axis by axis.
//! Multiplied by rigid mass and inertia it is a wrench, which is allocated to the thrusters by what
//! each can give, and clipped thruster by thruster. Roll and pitch rate are commanded to zero.
//! Fossen (2011) ch. 12.

use crate::ParameterError;
use crate::allocation::{Allocation, Degraded};
use crate::axes;
use crate::error::declared;
use crate::sampling::Rate;
use crate::vector::{Vec3, mul};
use crate::vehicle::{Inertia, Parameters, Thruster};
use fmu_quantity::{Member, Variables};
use serde::{Deserialize, Serialize};

/// Gains of three axes of the same kind; the unit is that of their acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Pid {
    /// proportional gain
    #[var(unit = "1/s", min = 0.0)]
    pub p: f64,
    /// integral gain
    #[var(unit = "1/s2", min = 0.0)]
    pub i: f64,
    /// derivative gain
    ///
    /// On the measured velocity, so a step in the command causes no derivative kick.
    #[var(unit = "1", min = 0.0)]
    pub d: f64,
    /// limit of the demanded acceleration
    #[var(min = 1e-9)]
    pub saturation: f64,
}

/// Parameters of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct ControllerParameters {
    /// Cycles a second
    #[var(unit = "Hz", min = 0.001, max = 1e6, start = 50.0)]
    pub rate_hz: f64,
    /// Surge, sway and heave
    #[var(unit = "m/s2", start = Pid { p: 10.0, i: 2.0, d: 0.0, saturation: 20.0 })]
    pub linear: Pid,
    /// Roll, pitch and yaw
    #[var(unit = "rad/s2", start = Pid { p: 10.0, i: 2.0, d: 1.0, saturation: 5.0 })]
    pub angular: Pid,
    /// Rigid mass
    #[var(unit = "kg", min = 1e-9, nominal = 1000.0, start = Parameters::default().mass)]
    pub mass: f64,
    /// Rigid inertia about the centre of gravity, positive definite
    #[var(start = Parameters::default().inertia)]
    pub inertia: Inertia,
    /// Thruster
    #[var(rename = "thruster", start = Parameters::default().propulsion.thrusters)]
    pub thrusters: [Thruster; 8],
    /// Limit of each thruster, either sign
    #[var(
        unit = "N",
        min = 1e-9,
        nominal = 1000.0,
        start = Parameters::default().propulsion.thrust_limit
    )]
    pub thrust_limit: f64,
}

/// Integrals of the velocity error, the velocity at the previous cycle, and the allocation in use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ControllerMemory {
    integral: [f64; 6],
    previous: Option<[f64; 6]>,
    degraded: Option<Degraded>,
}

/// The force of one thruster.
const FORCE: Member = Member::new("force", "force").unit("N").nominal(1000.0);

/// Outputs of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct Demand {
    /// Thruster
    ///
    /// Forces to command, limited.
    #[var(rename = "thruster", each = FORCE)]
    pub force: [f64; 8],
    /// Force and moment demanded, before the limits of the thrusters
    #[var(elements = axes::WRENCH)]
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
        declared(p)?;
        p.inertia.check()?;
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
