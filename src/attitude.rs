//! Attitude: unit quaternions `[w, x, y, z]` and Euler angles `[roll, pitch, yaw]` (rad).
//!
//! All of them describe the rotation from body (FRD) to NED, Euler angles in the z-y-x order of
//! Fossen (2011) ch. 2.2; eqs (3) and (4) of the paper hold once their misprints are corrected.

use crate::vector::Vec3;
use core::f64::consts::{PI, TAU};

/// Wraps an angle to (-pi, pi]. A value that is not finite gives NaN.
#[must_use]
pub fn wrap(angle: f64) -> f64 {
    let turned = angle - TAU * libm::ceil((angle - PI) / TAU);
    // One rounding can leave the result at -pi, which is the excluded end.
    if turned <= -PI { PI } else { turned }
}

/// Quaternion from roll, pitch and yaw.
#[must_use]
pub fn from_euler([roll, pitch, yaw]: [f64; 3]) -> [f64; 4] {
    let (sr, cr) = libm::sincos(0.5 * roll);
    let (sp, cp) = libm::sincos(0.5 * pitch);
    let (sy, cy) = libm::sincos(0.5 * yaw);
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
}

/// The change of [`from_euler`] as the angles change: they rotate the body about its own axes by
/// dtheta, and `dq = 1/2 q (0, dtheta)`; Fossen (2011) ch. 2.2, inverse of eq (4) of the paper.
#[must_use]
pub fn d_from_euler(euler: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> [f64; 4] {
    let (sr, cr) = libm::sincos(euler[0]);
    let (sp, cp) = libm::sincos(euler[1]);
    let turn = [roll - sp * yaw, cr * pitch + cp * sr * yaw, cp * cr * yaw - sr * pitch];
    half_product(from_euler(euler), turn)
}

/// `1/2 q (0, omega)`: how a quaternion changes as the body rotates about its own axes.
#[inline(always)]
pub(crate) fn half_product([w, x, y, z]: [f64; 4], [p, q, r]: Vec3) -> [f64; 4] {
    [
        0.5 * (-x * p - y * q - z * r),
        0.5 * (w * p + y * r - z * q),
        0.5 * (w * q + z * p - x * r),
        0.5 * (w * r + x * q - y * p),
    ]
}

/// Roll and yaw in (-pi, pi], pitch in [-pi/2, pi/2], of a quaternion of any non-zero length.
#[must_use]
pub fn to_euler(q: [f64; 4]) -> [f64; 3] {
    euler_of_rotation(&rotation(q))
}

/// Roll, pitch and yaw of a rotation matrix R (body to NED).
#[inline(always)]
pub(crate) fn euler_of_rotation(r: &[Vec3; 3]) -> [f64; 3] {
    [
        libm::atan2(r[2][1], r[2][2]),
        libm::asin((-r[2][0]).clamp(-1.0, 1.0)),
        libm::atan2(r[1][0], r[0][0]),
    ]
}

/// Rotation matrix R (body to NED) of a quaternion of any non-zero length.
///
/// Dividing by the squared norm keeps R orthonormal while an integrator lets the norm drift.
#[must_use]
#[inline(always)]
pub fn rotation(q: [f64; 4]) -> [Vec3; 3] {
    let [w, x, y, z] = q;
    rotation_by(2.0 / (w * w + x * x + y * y + z * z), q)
}

/// The same for a quaternion of unit length, without the latency of a division.
#[inline(always)]
pub(crate) fn rotation_of_unit(q: [f64; 4]) -> [Vec3; 3] {
    rotation_by(2.0, q)
}

#[inline(always)]
fn rotation_by(s: f64, [w, x, y, z]: [f64; 4]) -> [Vec3; 3] {
    let (sx, sy, sz) = (s * x, s * y, s * z);
    let (wx, wy, wz) = (w * sx, w * sy, w * sz);
    let (xx, xy, xz) = (x * sx, x * sy, x * sz);
    let (yy, yz, zz) = (y * sy, y * sz, z * sz);
    [
        [1.0 - (yy + zz), xy - wz, xz + wy],
        [xy + wz, 1.0 - (xx + zz), yz - wx],
        [xz - wy, yz + wx, 1.0 - (xx + yy)],
    ]
}

/// Rotation matrix R (body to NED) of Euler angles.
#[must_use]
pub fn rotation_euler(euler: [f64; 3]) -> [Vec3; 3] {
    rotation(from_euler(euler))
}

/// The quaternion divided by its length.
#[must_use]
pub fn normalised(q: [f64; 4]) -> [f64; 4] {
    let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    q.map(|c| c / norm)
}
