//! Inputs and outputs of the vehicle: names, units and order of the inputs and outputs of
//! `rexrov::vehicle`.
//!
//! The structs of variables here only declare; the component works on the structs of the
//! mathematics.

use crate::direct::{Numbers, numbers};
use crate::groups::{
    Acceleration, Ned, Pose, Position, Quaternion, Thrust, Vector, Velocity, Wrench,
};
use fmu_kit::{Reader, Variables};
use rexrov::vehicle::{self, State};
use serde::{Deserialize, Serialize};

/// Demand on one thruster.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Demand {
    /// force demanded (thruster_mode ForceWithLag or Force)
    #[var(unit = "N", nominal = 1000.0)]
    pub force: f64,
    /// rotor speed demanded (thruster_mode RotorSpeed)
    #[var(unit = "rad/s", nominal = 1000.0)]
    pub speed: f64,
    /// fraction of the thrust lost: 0 sound, 1 propeller lost, 2 turning the wrong way; the rotor
    /// turns as demanded
    #[var(unit = "1")]
    pub loss: f64,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// Thruster
    pub thruster: [Demand; 8],
    /// External force and moment about the centre of gravity, body frame
    pub wrench: Wrench,
    /// Current of the water, steady
    pub current: Ned,
}

impl From<vehicle::Inputs> for Inputs {
    fn from(u: vehicle::Inputs) -> Self {
        let mut thruster = [Demand::default(); 8];
        let demands = u.thruster_force.into_iter().zip(u.thruster_speed).zip(u.thruster_loss);
        for (place, ((force, speed), loss)) in thruster.iter_mut().zip(demands) {
            *place = Demand { force, speed, loss };
        }
        Self { thruster, wrench: u.wrench.into(), current: u.current_ned.into() }
    }
}

impl Numbers for vehicle::Inputs {
    type Names = Inputs;

    #[inline(always)]
    fn load(from: &mut Reader<'_>) -> Self {
        let thruster: [[f64; 3]; 8] = Variables::load(from);
        Self {
            thruster_force: thruster.map(|[force, ..]| force),
            thruster_speed: thruster.map(|[_, speed, _]| speed),
            thruster_loss: thruster.map(|[.., loss]| loss),
            wrench: Variables::load(from),
            current_ned: Variables::load(from),
        }
    }

    #[inline(always)]
    fn zip(&mut self, other: &Self, f: &mut impl FnMut(&mut f64, f64)) {
        let own = self.thruster_force.iter_mut().zip(&mut self.thruster_speed);
        let theirs = other.thruster_force.iter().zip(&other.thruster_speed);
        let losses = self.thruster_loss.iter_mut().zip(&other.thruster_loss);
        for (((force, speed), (other_force, other_speed)), (loss, other_loss)) in
            own.zip(theirs).zip(losses)
        {
            f(force, *other_force);
            f(speed, *other_speed);
            f(loss, *other_loss);
        }
        self.wrench.zip_reals(&other.wrench, f);
        self.current_ned.zip_reals(&other.current_ned, f);
    }
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Outputs {
    /// Pose of the centre of gravity
    pub pose: Pose,
    /// Attitude, body to NED
    pub quaternion: Quaternion,
    /// Velocity over ground, body frame
    pub velocity: Velocity,
    /// Velocity over ground
    pub velocity_ned: Ned,
    /// Time derivative of the body-frame velocity
    pub acceleration: Acceleration,
    /// Specific force at the centre of gravity, body frame
    #[var(unit = "m/s2", nominal = 10.0)]
    pub specific_force: Vector,
    /// Thruster
    pub thruster: [Thrust; 8],
    /// Rotor; where a force acts at once, with the speed of a sound propeller for it
    pub rotor: [Rotor; 8],
}

impl From<vehicle::Outputs> for Outputs {
    fn from(y: vehicle::Outputs) -> Self {
        let ([x, y_east, z], [roll, pitch, yaw]) = (y.p_ned, y.euler);
        Self {
            pose: Pose { x, y: y_east, z, roll, pitch, yaw },
            quaternion: y.quaternion.into(),
            velocity: y.nu.into(),
            velocity_ned: y.v_ned.into(),
            acceleration: y.nu_dot.into(),
            specific_force: y.specific_force.into(),
            thruster: y.thrust.map(|thrust| Thrust { thrust }),
            rotor: y.rotor_speed.map(|speed| Rotor { speed }),
        }
    }
}

numbers!(vehicle::Outputs, named by Outputs:
    p_ned, euler, quaternion, nu, v_ned, nu_dot, specific_force, thrust, rotor_speed);

/// Rotor of one thruster.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Rotor {
    /// speed
    #[var(unit = "rad/s", nominal = 100.0)]
    pub speed: f64,
}

/// Continuous states, separated from the outputs by their own name.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Motion {
    /// position
    pub position: Position,
    /// attitude, body to NED, not exactly of unit length
    pub quaternion: AttitudeState,
    /// velocity over ground, body frame
    pub velocity: Velocity,
    /// rotor
    pub rotor: [Rotor; 8],
}

crate::groups::group! {
    /// The attitude while it is integrated.
    AttitudeState = [
        /// scalar part
        w,
        /// x
        x,
        /// y
        y,
        /// z
        z; 4]
}

/// Continuous states.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct States {
    /// State
    pub state: Motion,
}

impl From<State> for States {
    fn from(s: State) -> Self {
        Self {
            state: Motion {
                position: s.p_ned.into(),
                quaternion: s.quaternion.into(),
                velocity: s.nu.into(),
                rotor: s.rotor_speed.map(|speed| Rotor { speed }),
            },
        }
    }
}

numbers!(State, named by States: p_ned, quaternion, nu, rotor_speed);

#[cfg(test)]
mod tests {
    use super::*;
    use fmu_kit::Writer;

    /// Distinct numbers in the order of a group, loaded by `M` and stored under its names.
    fn through_names<M: Numbers>() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let n = M::Names::COUNT.reals;
        let numbers: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
        let loaded = M::load(&mut Reader { reals: &numbers, ..Reader::default() });
        let (mut named, mut walked) = (vec![0.0; n], Vec::new());
        M::Names::from(loaded).store(&mut Writer { reals: &mut named, ..Writer::default() });
        let mut copy = loaded;
        copy.zip(&loaded, &mut |own, number| {
            assert_eq!(*own, number);
            walked.push(number);
        });
        (numbers, named, walked)
    }

    #[test]
    fn numbers_lie_in_the_order_of_their_names() {
        for (numbers, named, walked) in [
            through_names::<State>(),
            through_names::<vehicle::Inputs>(),
            through_names::<vehicle::Outputs>(),
        ] {
            assert_eq!(numbers, named);
            assert_eq!(numbers, walked);
        }
    }
}
