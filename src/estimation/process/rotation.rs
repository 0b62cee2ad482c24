//! The exponential map of rotations; Solà (2017) sections 4 and 10, Chirikjian (2012).

use nalgebra::{Matrix3, Vector3};

use crate::estimation::belief::Belief;
use crate::estimation::kinematics::skew;
use crate::estimation::transition::Transition;

/// `sin x / x`, `(1 - cos x) / x^2` and `(x - sin x) / x^3` of `square` = x^2.
///
/// For x < 1/4 it is the series, truncated below the last digit: a rotation within a filter
/// interval is hardly ever larger, and most corrections are below 1/100.
#[inline]
fn quotients(square: f64) -> [f64; 3] {
    if square < 1e-4 {
        // Without nesting, because the next steps wait for this.
        let fourth = square * square;
        let b = 0.5 - square * (1.0 / 24.0) + fourth * (1.0 / 720.0);
        let c = 1.0 / 6.0 - square * (1.0 / 120.0) + fourth * (1.0 / 5040.0);
        return [1.0 - square * c, b, c];
    }
    if square < 0.0625 {
        let c = series(square, [6.0, 20.0, 42.0, 72.0, 110.0, 156.0]);
        return [1.0 - square * c, series(square, [2.0, 12.0, 30.0, 56.0, 90.0, 132.0]), c];
    }
    let angle = square.sqrt();
    let (sin, cos) = libm::sincos(angle);
    [sin / angle, (1.0 - cos) / square, (angle - sin) / (square * angle)]
}

/// `1/a - x/(a b) + x^2/(a b c) - ...`
fn series(x: f64, divisors: [f64; 6]) -> f64 {
    divisors.iter().rev().fold(0.0, |rest, divisor| (1.0 - x * rest) * (1.0 / divisor))
}

/// `1 + a [phi]x + b [phi]x^2`.
#[inline]
fn polynomial(phi: &Vector3<f64>, a: f64, b: f64) -> Matrix3<f64> {
    // [phi]x^2 = phi phi^T - phi^T phi 1.
    skew(&(phi * a))
        + phi * (phi * b).transpose()
        + Matrix3::from_diagonal_element(1.0 - phi.norm_squared() * b)
}

/// `Exp(phi)`: the rotation by |phi| about phi (Rodrigues).
#[inline]
pub(crate) fn exp(phi: &Vector3<f64>) -> Matrix3<f64> {
    let [a, b, _] = quotients(phi.norm_squared());
    polynomial(phi, a, b)
}

/// The right Jacobian: `Exp(phi + d) = Exp(phi) Exp(Jr(phi) d)` to first order.
#[inline]
pub(crate) fn right_jacobian(phi: &Vector3<f64>) -> Matrix3<f64> {
    let [_, a, b] = quotients(phi.norm_squared());
    polynomial(phi, -a, b)
}

/// `Log` of a rotation matrix: the rotation vector, shorter than pi.
pub(crate) fn log(r: &Matrix3<f64>) -> Vector3<f64> {
    let axis = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let sin = 0.5 * axis.norm();
    let cos = 0.5 * (r.trace() - 1.0);
    let angle = libm::atan2(sin, cos);
    if sin < 1e-6 { axis * 0.5 } else { axis * (0.5 * angle / sin) }
}

/// Rotation matrix of a quaternion of unit length.
pub(crate) fn matrix(q: [f64; 4]) -> Matrix3<f64> {
    let r = crate::attitude::rotation_of_unit(q);
    Matrix3::from_fn(|i, j| r[i][j])
}

/// `q Exp(phi)` of a quaternion of unit length.
pub(crate) fn turned(q: [f64; 4], phi: &Vector3<f64>) -> [f64; 4] {
    let half = phi * 0.5;
    let square = half.norm_squared();
    let [sine, versine, _] = quotients(square);
    let [a, x, y, z] = q;
    let (b, v) = (1.0 - versine * square, half * sine);
    let product = [
        a * b - x * v.x - y * v.y - z * v.z,
        a * v.x + x * b + y * v.z - z * v.y,
        a * v.y + y * b + z * v.x - x * v.z,
        a * v.z + z * b + x * v.y - y * v.x,
    ];
    // Of unit length except for rounding, which one Newton step for 1/sqrt removes.
    let scale = 1.5 - 0.5 * product.iter().map(|c| c * c).sum::<f64>();
    product.map(|c| c * scale)
}

/// Corrections of the attitude (rad) below which the frame of its error may be treated as
/// unchanged.
const SMALL_TURN: f64 = 0.01;

/// Moves an attitude error in the mean, at `state`, into the attitude.
///
/// The error is given along body axes, which rotate with the correction; the covariance rotates
/// too, so that its information about the error around the vertical is kept (Solà 2017, section
/// 7.2, with the global error).
pub(crate) fn turn_attitude<const N: usize>(belief: &mut Belief<N>, state: usize) {
    let turn: Vector3<f64> = belief.mean.fixed_rows::<3>(state).into_owned();
    belief.mean.fixed_rows_mut::<3>(state).fill(0.0);
    belief.attitude = turned(belief.attitude, &turn);
    if turn.norm_squared() > SMALL_TURN * SMALL_TURN {
        let back = exp(&-turn);
        let mut f = Transition::identity();
        f.set_rows(state, &[(state, back)]);
        belief.propagate(&f);
    }
}

#[cfg(test)]
mod tests {
    use super::quotients;

    #[test]
    fn series_and_functions_agree() {
        for angle in [0.00999, 0.01001, 0.1, 0.2, 0.2499, 0.2501] {
            let [a, b, c] = quotients(angle * angle);
            let (sin, half) = (libm::sin(angle), libm::sin(0.5 * angle));
            let close = |got: f64, want: f64, error: f64| {
                assert!((got - want).abs() <= error, "{angle}: {got}, not {want}");
            };
            close(a, sin / angle, 1e-15);
            close(b, 2.0 * (half / angle) * (half / angle), 1e-15 / angle);
            // The difference has lost digits.
            close(c, (angle - sin) / (angle * angle * angle), 1e-16 / (angle * angle));
        }
    }
}
