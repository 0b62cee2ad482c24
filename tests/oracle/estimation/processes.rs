//! The processes without a vehicle model. The inertial one is formulated in NED: velocity over
//! ground along body axes before and after, Newton's law in between.

use rexrov::estimation::NavigationParameters;
use rexrov::estimation::interval::Interval;

use super::*;

/// The states of the inertial process.
const U: usize = 3;
pub const B_A: usize = 9;
pub const B_G: usize = 12;
pub const BASE: usize = 15;
pub const AID: usize = 14;
/// Those of the aid, starting at `BASE`.
pub(super) const CURRENT: usize = 15;
pub(super) const FORCE: usize = 17;
pub(super) const SLOW: usize = 20;
pub(super) const MOMENT: usize = 23;
pub(super) const N_A: usize = 24;
pub(super) const N_G: usize = 27;
pub(super) const N_G_BEFORE: usize = 28;

/// Noise states that are new in each interval.
pub fn renew<D: Number, const N: usize>(p: &Point<D, N>) -> Point<D, N> {
    let mut next = *p;
    next.x[N_G_BEFORE] = p.x[N_G];
    (0..3).for_each(|i| next.x[N_A + i] = D::zero());
    next.x[N_G] = D::zero();
    next
}

/// Inertial prediction, with the noise states of an aid if `times` gives the correlation times of
/// its fast and slow disturbances.
pub fn inertial<D: Number, const N: usize>(
    p: &Point<D, N>,
    interval: &Interval,
    gravity: f64,
    aid: Option<[f64; 2]>,
) -> Point<D, N> {
    let mut next = match &interval.inertial {
        Some(imu) => {
            let mut w = minus(lift(imu.rate), part(&p.x, B_G));
            let mut f = minus(lift(imu.specific_force), part(&p.x, B_A));
            if aid.is_some() {
                w[2] -= p.x[N_G];
                f = minus(f, part(&p.x, N_A));
            }
            newton(p, interval.dt, w, f, gravity)
        }
        None => coasting(p, interval.dt, lift(interval.turning.unwrap_or_default().mean)),
    };
    let dt = interval.dt;
    if let Some([quick, slow]) = aid {
        for i in [FORCE, FORCE + 1, FORCE + 2, MOMENT] {
            next.x[i] *= (-dt / quick).exp();
        }
        (SLOW..SLOW + 3).for_each(|i| next.x[i] *= (-dt / slow).exp());
    }
    next
}

/// Newton's law in NED: the force acts in the frame of the middle of the interval.
fn newton<D: Number, const N: usize>(
    p: &Point<D, N>,
    dt: f64,
    w: V3<D>,
    f: V3<D>,
    gravity: f64,
) -> Point<D, N> {
    let v = image(&matrix(p.q), part(&p.x, U));
    let mut a = image(&matrix(product(p.q, exp(times(w, 0.5 * dt)))), f);
    a[2] += gravity;
    let mut next = *p;
    next.q = product(p.q, exp(times(w, dt)));
    let u = image(&transposed(&matrix(next.q)), plus(v, times(a, dt)));
    for i in 0..3 {
        next.x[i] = p.x[i] + v[i] * dt + a[i] * (0.5 * dt * dt);
        next.x[U + i] = u[i];
    }
    next
}

/// A velocity that is constant along the body axes: the displacement uses the mean of both ends.
fn coasting<D: Number, const N: usize>(p: &Point<D, N>, dt: f64, w: V3<D>) -> Point<D, N> {
    let mut next = *p;
    next.q = product(p.q, exp(times(w, dt)));
    let u = part(&p.x, U);
    let way = plus(image(&matrix(p.q), u), image(&matrix(next.q), u));
    (0..3).for_each(|i| next.x[i] += way[i] * (0.5 * dt));
    next
}

/// Motion by the inertial process; `base` is the first state of the sensors.
pub fn inertial_motion<D: Number, const N: usize>(
    p: &Point<D, N>,
    interval: &Interval,
    gravity: f64,
    base: usize,
) -> Motion<D> {
    let rotation = matrix(p.q);
    let inverse = transposed(&rotation);
    let velocity = part(&p.x, U);
    let down = times(inverse.map(|row| row[2]), gravity);
    let (rate, acceleration) = match &interval.inertial {
        Some(imu) => {
            let rate = minus(lift(imu.rate_end), part(&p.x, B_G));
            let force = minus(lift(imu.specific_force), part(&p.x, B_A));
            (rate, minus(plus(force, down), cross(rate, velocity)))
        }
        None => (lift(interval.turning.unwrap_or_default().end), [D::zero(); 3]),
    };
    let sensors = core::array::from_fn(|i| p.x[base + i]);
    Motion { position: part(&p.x, 0), rotation, velocity, rate, acceleration, sensors }
}

pub fn constant_acceleration<D: Number, const N: usize>(p: &Point<D, N>, dt: f64) -> Point<D, N> {
    let (v, w, a): (V3<D>, V3<D>, V3<D>) = (part(&p.x, 6), part(&p.x, 9), part(&p.x, 12));
    let moved = image(&matrix(p.q), plus(times(v, dt), times(a, 0.5 * dt * dt)));
    let mut next = *p;
    for i in 0..3 {
        next.x[i] += moved[i];
        next.x[6 + i] += a[i] * dt;
    }
    next.q = product(p.q, exp(times(w, dt)));
    next
}

pub fn constant_acceleration_motion<D: Number, const N: usize>(p: &Point<D, N>) -> Motion<D> {
    Motion {
        position: part(&p.x, 0),
        rotation: matrix(p.q),
        velocity: part(&p.x, 6),
        rate: part(&p.x, 9),
        acceleration: part(&p.x, 12),
        sensors: core::array::from_fn(|i| p.x[15 + i]),
    }
}

/// Specific force by the constant-acceleration filter, as measured by the accelerometers.
pub fn constant_acceleration_force<D: Number, const N: usize>(
    p: &Point<D, N>,
    parameters: &NavigationParameters,
) -> V3<D> {
    let down = transposed(&matrix(p.q)).map(|row| row[2]);
    minus(part(&p.x, 12), times(down, parameters.gravity))
}
