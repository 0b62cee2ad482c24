//! Three-vectors as plain arrays: the few operations that the models need.

pub(crate) type Vec3 = [f64; 3];

#[inline(always)]
pub(crate) fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scale(a: Vec3, s: f64) -> Vec3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline(always)]
pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `m a`.
#[inline(always)]
pub(crate) fn mul(m: &[Vec3; 3], a: Vec3) -> Vec3 {
    [
        m[0][0] * a[0] + m[0][1] * a[1] + m[0][2] * a[2],
        m[1][0] * a[0] + m[1][1] * a[1] + m[1][2] * a[2],
        m[2][0] * a[0] + m[2][1] * a[1] + m[2][2] * a[2],
    ]
}

/// `mᵀ a`.
#[inline(always)]
pub(crate) fn mul_transposed(m: &[Vec3; 3], a: Vec3) -> Vec3 {
    [
        m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2],
        m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2],
        m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2],
    ]
}

/// The linear (0..3) half of a six-vector.
#[inline(always)]
pub(crate) fn linear(a: &[f64; 6]) -> Vec3 {
    [a[0], a[1], a[2]]
}

/// The angular (3..6) half of a six-vector.
#[inline(always)]
pub(crate) fn angular(a: &[f64; 6]) -> Vec3 {
    [a[3], a[4], a[5]]
}
