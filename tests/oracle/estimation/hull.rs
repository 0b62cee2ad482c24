//! The vehicle's equations of motion as the filters use them.

use rexrov::estimation::interval::Interval;
use rexrov::vehicle::Parameters;

use super::*;

/// The vehicle in the filters' models.
pub struct Hull {
    m: [[f64; 6]; 6],
    linear: [f64; 6],
    quadratic: [f64; 6],
    excess: f64,
    gravity: f64,
    thrusters: [[f64; 6]; 8],
}

impl Hull {
    pub fn new(p: &Parameters) -> Self {
        Self {
            m: p.mass_matrix(),
            linear: p.linear_damping,
            quadratic: p.quadratic_damping,
            excess: p.mass * p.gravity - p.buoyancy_force(),
            gravity: p.gravity,
            thrusters: p.propulsion.thrusters.map(|t| t.unit_wrench()),
        }
    }

    fn wrench(&self, thrust: [f64; 8]) -> [f64; 6] {
        core::array::from_fn(|i| (0..8).map(|k| self.thrusters[k][i] * thrust[k]).sum())
    }

    fn damping<D: Number>(&self, axis: usize, speed: D) -> D {
        speed * self.linear[axis] + speed * speed.abs() * self.quadratic[axis]
    }

    /// x', y', z', psi', u', v', w', r' of the planar model; u over ground along body axes.
    pub fn planar_rates<D: Number, const N: usize>(
        &self,
        x: &[D; N],
        interval: &Interval,
    ) -> [D; 8] {
        let [roll, pitch] = roll_and_pitch(interval);
        let r = euler_matrix([D::from(roll), D::from(pitch), x[3]]);
        let (ground, turn) = (part(x, 4), x[7]);
        let [dx, dy, dz] = image(&r, ground);
        let heading = turn * (roll.cos() / pitch.cos());
        let Some(thrust) = &interval.thrust else {
            let still = D::zero();
            return [dx, dy, dz, heading, still, still, still, still];
        };
        let flow = image(&transposed(&r), [x[8], x[9], D::zero()]);
        let [u, v, w] = minus(ground, flow);
        let nu = [u, v, w, turn];
        let mut tau = self.wrench(thrust.mean);
        tau[2] += self.excess;
        let coupling = [
            v * turn * self.m[1][1],
            -u * turn * self.m[0][0],
            D::zero(),
            -u * v * (self.m[1][1] - self.m[0][0]),
        ];
        let [du, dv, dw, dr] = core::array::from_fn(|k| {
            let axis = [0, 1, 2, 5][k];
            let force = coupling[k] - self.damping(axis, nu[k]) + x[11 + k] + tau[axis];
            force / self.m[axis][axis]
        });
        // The current is constant while the body rotates.
        let [du, dv, dw] = minus([du, dv, dw], cross([D::zero(), D::zero(), turn], flow));
        [dx, dy, dz, heading, du, dv, dw, dr]
    }

    /// The midpoint step.
    pub fn planar<D: Number, const N: usize>(
        &self,
        p: &Point<D, N>,
        interval: &Interval,
        correlation_time: f64,
    ) -> Point<D, N> {
        let (dt, mut middle, mut next) = (interval.dt, p.x, *p);
        let first = self.planar_rates(&p.x, interval);
        (0..8).for_each(|i| middle[i] += first[i] * (0.5 * dt));
        let second = self.planar_rates(&middle, interval);
        (0..8).for_each(|i| next.x[i] += second[i] * dt);
        (11..15).for_each(|i| next.x[i] *= (-dt / correlation_time).exp());
        next
    }

    pub fn planar_motion<D: Number, const N: usize>(
        &self,
        p: &Point<D, N>,
        interval: &Interval,
    ) -> Motion<D> {
        let [roll, pitch] = roll_and_pitch(interval);
        let rotation = euler_matrix([D::from(roll), D::from(pitch), p.x[3]]);
        let [.., du, dv, dw, _] = self.planar_rates(&p.x, interval);
        Motion {
            position: part(&p.x, 0),
            rotation,
            velocity: part(&p.x, 4),
            rate: [D::zero(), D::zero(), p.x[7]],
            acceleration: [du, dv, dw],
            sensors: core::array::from_fn(|i| p.x[15 + i]),
        }
    }

    /// The yaw rate half an interval ago, as measured by the gyro.
    pub fn gyro<D: Number, const N: usize>(&self, p: &Point<D, N>, interval: &Interval) -> [D; 1] {
        let [.., dr] = self.planar_rates(&p.x, interval);
        [p.x[7] - dr * (0.5 * interval.dt) + p.x[10]]
    }

    /// Velocity through the water `t` before the end, and down along body axes there.
    fn water<D: Number, const N: usize>(
        &self,
        p: &Point<D, N>,
        interval: &Interval,
        t: f64,
    ) -> (V3<D>, V3<D>) {
        let (imu, dt) = (interval.inertial.unwrap(), interval.dt);
        let w = minus(lift(imu.rate), part(&p.x, B_G));
        let f = minus(minus(lift(imu.specific_force), part(&p.x, B_A)), part(&p.x, N_A));
        let middle = matrix(product(p.q, exp(times(w, -0.5 * dt))));
        let mut a = image(&middle, f);
        a[2] += self.gravity;
        let current = [p.x[CURRENT], p.x[CURRENT + 1], D::zero()];
        let ground = image(&matrix(p.q), part(&p.x, 3));
        let v = minus(minus(ground, times(a, t)), current);
        let there = transposed(&matrix(product(p.q, exp(times(w, -t)))));
        (image(&there, v), there.map(|row| row[2]))
    }

    /// Momentum along x, y, z.
    fn momentum<D: Number>(&self, nu: V3<D>, w: V3<D>) -> V3<D> {
        core::array::from_fn(|i| {
            (0..3).map(|j| nu[j] * self.m[i][j] + w[j] * self.m[i][3 + j]).sum()
        })
    }

    /// Mean specific force of an interval by the model.
    pub fn force<D: Number, const N: usize>(&self, p: &Point<D, N>, interval: &Interval) -> V3<D> {
        let (imu, thrust) = (interval.inertial.unwrap(), interval.thrust.unwrap());
        let (nu, down) = self.water(p, interval, 0.5 * interval.dt);
        let w = minus(lift(imu.rate), part(&p.x, B_G));
        let (pull, carried) = (cross(w, self.momentum(nu, w)), cross(w, nu));
        let tau = self.wrench(thrust.mean);
        core::array::from_fn(|i| {
            let force = -pull[i] - self.damping(i, nu[i])
                + down[i] * self.excess
                + p.x[FORCE + i]
                + p.x[SLOW + i]
                + tau[i];
            force / self.m[i][i] + carried[i] - down[i] * self.gravity + p.x[B_A + i] + p.x[N_A + i]
        })
    }

    /// Difference of two means of the yaw gyro over their distance, by the model.
    pub fn moment<D: Number, const N: usize>(
        &self,
        p: &Point<D, N>,
        before: &Interval,
        interval: &Interval,
    ) -> [D; 1] {
        let (old, new) = (before.thrust.unwrap(), interval.thrust.unwrap());
        let (a, b) = (before.dt, interval.dt);
        let spacing = 0.5 * (a + b);
        let falling = minus(new.mean, new.rising);
        let triangle = plus(times(old.rising, a / spacing), times(falling, b / spacing));
        let (w_old, w_new) = (before.inertial.unwrap().rate, interval.inertial.unwrap().rate);
        let raw = times(plus(times(w_new, a), times(w_old, b)), 1.0 / (a + b));
        let w = minus(lift(raw), part(&p.x, B_G));
        let (nu, _) = self.water(p, interval, b);
        let h = self.momentum(nu, w);
        let moment = h[0] * nu[1] - h[1] * nu[0] - self.damping(5, w[2])
            + p.x[MOMENT]
            + self.wrench(triangle)[5];
        [moment / self.m[5][5] + (p.x[N_G] - p.x[N_G_BEFORE]) / spacing]
    }
}

fn roll_and_pitch(interval: &Interval) -> [f64; 2] {
    let [x, y, z] = interval.tilt[2];
    [y.atan2(z), -x.asin()]
}
