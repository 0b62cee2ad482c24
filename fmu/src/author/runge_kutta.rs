//! The default step of the fixed-step integrator, for components that do not provide their own.

use super::Ports;

/// Adds `factor * k` to `x`.
#[inline]
pub(crate) fn add<X: Ports>(x: &mut X, k: &X, factor: f64) {
    x.zip_reals(k, &mut |x, k| *x += factor * k);
}

#[inline]
fn moved<X: Ports>(x: &X, k: &X, h: f64) -> X {
    let mut there = *x;
    add(&mut there, k, h);
    there
}

/// One step of the classical Runge-Kutta method, from `x`, where the derivatives are `k1`.
#[inline]
pub(crate) fn runge_kutta<X: Ports>(f: &impl Fn(f64, &X) -> X, k1: X, x: &mut X, t: f64, h: f64) {
    let half = 0.5 * h;
    let k2 = f(t + half, &moved(x, &k1, half));
    let k3 = f(t + half, &moved(x, &k2, half));
    let k4 = f(t + h, &moved(x, &k3, h));
    let mut slope = k1;
    add(&mut slope, &k2, 2.0);
    add(&mut slope, &k3, 2.0);
    add(&mut slope, &k4, 1.0);
    add(x, &slope, h / 6.0);
}
