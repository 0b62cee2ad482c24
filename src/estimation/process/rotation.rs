//! The exponential map of rotations; Solà (2017) sections 4 and 10, Chirikjian (2012).

use nalgebra::{Matrix3, Vector3};

use crate::estimation::belief::Belief;
use crate::estimation::kinematics::skew;
use crate::estimation::transition::Transition;

/// `Exp(phi)`: the rotation by |phi| about phi (Rodrigues).
pub(crate) fn exp(phi: &Vector3<f64>) -> Matrix3<f64> {
    let angle = phi.norm();
    let k = skew(phi);
    let (a, b) = if angle < 1e-4 {
        let square = angle * angle;
        (1.0 - square / 6.0, 0.5 - square / 24.0)
    } else {
        let (sin, cos) = libm::sincos(angle);
        (sin / angle, (1.0 - cos) / (angle * angle))
    };
    Matrix3::identity() + k * a + k * k * b
}

/// The right Jacobian: `Exp(phi + d) = Exp(phi) Exp(Jr(phi) d)` to first order.
pub(crate) fn right_jacobian(phi: &Vector3<f64>) -> Matrix3<f64> {
    let angle = phi.norm();
    let k = skew(phi);
    let (a, b) = if angle < 1e-4 {
        let square = angle * angle;
        (0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0)
    } else {
        let (sin, cos) = libm::sincos(angle);
        ((1.0 - cos) / (angle * angle), (angle - sin) / (angle * angle * angle))
    };
    Matrix3::identity() - k * a + k * k * b
}

/// `Log` of a rotation matrix: the rotation vector, shorter than pi.
pub(crate) fn log(r: &Matrix3<f64>) -> Vector3<f64> {
    let axis = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let sin = 0.5 * axis.norm();
    let cos = 0.5 * (r.trace() - 1.0);
    let angle = libm::atan2(sin, cos);
    if sin < 1e-6 { axis * 0.5 } else { axis * (0.5 * angle / sin) }
}

/// Rotation matrix of a quaternion.
pub(crate) fn matrix(q: [f64; 4]) -> Matrix3<f64> {
    let r = crate::attitude::rotation(q);
    Matrix3::from_fn(|i, j| r[i][j])
}

/// `q Exp(phi)`, of unit length.
pub(crate) fn turned(q: [f64; 4], phi: &Vector3<f64>) -> [f64; 4] {
    let half = 0.5 * phi.norm();
    let scale = if half < 1e-4 { 0.5 - half * half / 12.0 } else { 0.5 * libm::sin(half) / half };
    let [a, x, y, z] = q;
    let (b, v) = (libm::cos(half), phi * scale);
    let product = [
        a * b - x * v.x - y * v.y - z * v.z,
        a * v.x + x * b + y * v.z - z * v.y,
        a * v.y + y * b + z * v.x - x * v.z,
        a * v.z + z * b + x * v.y - y * v.x,
    ];
    crate::attitude::normalised(product)
}

/// Corrections of the attitude (rad) below which the frame of its error may be taken for unchanged.
const SMALL_TURN: f64 = 0.01;

/// Moves an attitude error in the mean, at `state`, into the attitude.
///
/// The error is given along body axes, which turn with the correction; the covariance turns too, so
/// that what it says of the error about the vertical stays that (Solà 2017, section 7.2, with the
/// global error).
pub(crate) fn turn_attitude<const N: usize>(belief: &mut Belief<N>, state: usize) {
    let turn: Vector3<f64> = belief.mean.fixed_rows::<3>(state).into_owned();
    belief.mean.fixed_rows_mut::<3>(state).fill(0.0);
    belief.attitude = turned(belief.attitude, &turn);
    if turn.norm_squared() > SMALL_TURN * SMALL_TURN {
        let back = exp(&-turn);
        let mut f = Transition::identity();
        for i in 0..3 {
            f.set_row(state + i, [0, 1, 2].map(|j| (state + j, back[(i, j)])));
        }
        belief.propagate(&f);
    }
}
