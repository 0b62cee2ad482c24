//! Random vehicles, states and inputs.

use rexrov::vehicle::{Inertia, Inputs, Parameters, Propulsion, State, Thruster, ThrusterMode};

use super::flat::{IN, STATE, flat_inputs, flat_state};

/// Takes one number in (-1, 1) after another.
pub(crate) struct Draw<'a>(core::slice::Iter<'a, f64>);

impl<'a> Draw<'a> {
    pub(crate) fn new(numbers: &'a [f64]) -> Self {
        Self(numbers.iter())
    }

    pub(crate) fn array<const N: usize>(&mut self, size: f64) -> [f64; N] {
        core::array::from_fn(|_| size * self.0.next().unwrap())
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + 0.5 * (high - low) * (1.0 + self.0.next().unwrap())
    }

    /// A symmetric positive definite matrix with eigenvalues of at least `least`.
    fn definite<const N: usize>(&mut self, size: f64, least: f64) -> [[f64; N]; N] {
        let g: [[f64; N]; N] = core::array::from_fn(|_| self.array(size.sqrt()));
        core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let product: f64 = (0..N).map(|k| g[i][k] * g[j][k]).sum();
                product + if i == j { least } else { 0.0 }
            })
        })
    }

    pub(crate) fn parameters(&mut self, mode: ThrusterMode) -> Parameters {
        let i = self.definite::<3>(300.0, 200.0);
        let positive = |draw: &mut Self, high| core::array::from_fn(|_| draw.between(0.0, high));
        let inertia = Inertia {
            xx: i[0][0],
            yy: i[1][1],
            zz: i[2][2],
            xy: i[0][1],
            xz: i[0][2],
            yz: i[1][2],
        };
        Parameters {
            mass: self.between(500.0, 3000.0),
            inertia,
            volume: self.between(0.5, 3.0),
            density: self.between(990.0, 1030.0),
            gravity: self.between(9.0, 10.0),
            buoyancy: if self.between(0.0, 1.0) < 0.5 {
                None
            } else {
                Some(self.between(1e4, 3e4))
            },
            centre_of_buoyancy: self.array(0.4),
            added_mass: self.definite(800.0, 200.0),
            linear_damping: positive(self, 500.0),
            quadratic_damping: positive(self, 1500.0),
            propulsion: self.propulsion(mode),
        }
    }

    fn propulsion(&mut self, mode: ThrusterMode) -> Propulsion {
        let thrusters = core::array::from_fn(|_| {
            let [lx, ly, lz] = self.array(1.0);
            let [theta_deg, psi_deg] = self.array(180.0);
            Thruster { lx, ly, lz, theta_deg, psi_deg }
        });
        Propulsion {
            thrusters,
            mode,
            rotor_time_constant: self.between(0.02, 0.5),
            thrust_gain: self.between(1e-4, 1e-3),
            thrust_limit: self.between(500.0, 2500.0),
        }
    }

    /// Any attitude except steep pitch, where the Euler angles are ill conditioned; a quaternion
    /// that is not of unit length.
    pub(crate) fn state(&mut self) -> [f64; STATE] {
        let [roll, yaw] = self.array(3.1);
        let attitude = [roll, self.between(-1.2, 1.2), yaw];
        let length = self.between(0.8, 1.2);
        let x = State::at_rest(self.array(30.0), attitude);
        flat_state(&State {
            quaternion: x.quaternion.map(|c| c * length),
            nu: self.array(1.5),
            rotor_speed: self.array(900.0),
            ..x
        })
    }

    /// Commands within and beyond their limits, but near neither limits nor zero.
    pub(crate) fn inputs(&mut self, p: &Propulsion) -> [f64; IN] {
        let mut command = |limit: f64| {
            self.array(2.0).map(|c: f64| {
                let size = if c.abs() < 1.0 { 0.05 + 0.85 * c.abs() } else { c.abs() + 0.1 };
                limit * size.copysign(c)
            })
        };
        let (force, speed) = (command(p.thrust_limit), command(p.speed(p.thrust_limit)));
        flat_inputs(&Inputs {
            thruster_force: force,
            thruster_speed: speed,
            wrench: self.array(500.0),
            current_ned: self.array(1.0),
            thruster_loss: self.array(2.0),
        })
    }
}
