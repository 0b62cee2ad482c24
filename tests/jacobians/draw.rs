//! Random vehicles, intervals and means.

use super::oracle::Point;
use nalgebra::SVector;
use rexrov::attitude::{from_euler, rotation_euler};
use rexrov::estimation::belief::{Belief, Column};
use rexrov::estimation::interval::{Inertial, Interval, Thrusts};
use rexrov::estimation::{NavigationParameters, Turning};
use rexrov::vehicle::Parameters;

/// Takes one number in (-1, 1) after another.
pub(super) struct Draw<'a>(pub(super) core::slice::Iter<'a, f64>);

impl Draw<'_> {
    pub(super) fn array<const K: usize>(&mut self, size: f64) -> [f64; K] {
        core::array::from_fn(|_| size * self.0.next().unwrap())
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + 0.5 * (high - low) * (1.0 + self.0.next().unwrap())
    }

    /// Any attitude but a pitch steeper than 80 degrees.
    pub(super) fn euler(&mut self) -> [f64; 3] {
        let [roll, yaw] = self.array(core::f64::consts::PI);
        [roll, self.between(-1.39, 1.39), yaw]
    }

    pub(super) fn inertial(&mut self) -> Inertial {
        Inertial {
            specific_force: self.array(12.0),
            rate: self.array(1.0),
            rate_end: self.array(1.0),
        }
    }

    pub(super) fn interval(&mut self) -> Interval {
        let mean = self.array(500.0);
        let share: [f64; 8] = self.array(0.3);
        let rising = core::array::from_fn(|i| mean[i] * (0.5 + share[i]));
        let [roll, _, _] = self.euler();
        Interval {
            end: 1.0,
            dt: self.between(0.01, 0.2),
            inertial: Some(self.inertial()),
            thrust: Some(Thrusts { mean, rising }),
            turning: Some(Turning { mean: self.array(1.0), end: self.array(1.0), variance: 0.01 }),
            tilt: rotation_euler([roll, self.between(-1.39, 1.39), 0.0]),
        }
    }

    /// A vehicle without symmetry.
    pub(super) fn vehicle(&mut self) -> Parameters {
        let mut p = Parameters::default();
        for i in 0..6 {
            for j in 0..i {
                let [coupling] = self.array(0.2);
                p.added_mass[i][j] += coupling * p.added_mass[i][i].min(p.added_mass[j][j]);
                p.added_mass[j][i] = p.added_mass[i][j];
            }
        }
        for thruster in &mut p.propulsion.thrusters {
            let [theta, psi, lx, ly, lz] = self.array(0.5);
            thruster.theta_deg += 20.0 * theta;
            thruster.psi_deg += 20.0 * psi;
            (thruster.lx, thruster.ly, thruster.lz) =
                (thruster.lx + lx, thruster.ly + ly, thruster.lz + lz);
        }
        p
    }

    /// Standard deviations of all sensor states, so that they exist.
    pub(super) fn parameters(&mut self) -> NavigationParameters {
        let mut p = NavigationParameters::default();
        p.sensors.heading_bias_sigma = 0.02;
        p.sensors.dvl_scale_sigma = 0.01;
        p.sensors.dvl_misalignment_sigma = 0.02;
        p.sensors.dvl_delay_sigma = 0.05;
        p.gravity = self.between(9.7, 9.9);
        p.mounting.dvl = self.array(2.0);
        p.mounting.fix = self.array(2.0);
        p.mounting.pressure = self.array(2.0);
        p
    }

    /// A mean with numbers of the given sizes, and the belief that has it.
    pub(super) fn belief<const N: usize>(
        &mut self,
        order: usize,
        sizes: &[(usize, f64)],
    ) -> Belief<N> {
        let mut mean: Column<N> = Column::zeros();
        let mut from = 0;
        for &(count, size) in sizes {
            (from..from + count).for_each(|i| mean[i] = self.array::<1>(size)[0]);
            from += count;
        }
        let attitude = from_euler(self.euler());
        Belief::new(order, mean, &SVector::repeat(0.1), attitude)
    }
}

/// Sizes of the means of the sensor states.
pub(super) const OF_SENSORS: (usize, f64) = (4, 0.1);

pub(super) fn point<const N: usize>(belief: &Belief<N>, theta: Option<usize>) -> Point<f64, N> {
    Point { x: core::array::from_fn(|i| belief.mean[i]), q: belief.attitude, theta }
}
