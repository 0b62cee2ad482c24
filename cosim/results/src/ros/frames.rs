//! From the axes of marine and flight mechanics to those of ROS (REP 103), with attitudes as
//! quaternions.

use std::f64::consts::FRAC_PI_2;

use crate::roles::{Axes, Body};

/// The pose of a body in the axes of ROS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    /// East, north, up (m).
    pub(crate) position: [f64; 3],
    /// From body axes to world axes: x, y, z, w.
    pub(crate) orientation: [f64; 4],
}

impl Pose {
    /// The matrix of the orientation, row by row.
    pub(crate) fn rotation(&self) -> [[f64; 3]; 3] {
        let [x, y, z, w] = self.orientation;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}

/// From a row of recorded data; `None` if a value is not finite.
pub(crate) fn pose(axes: Axes, body: &Body, row: &[f64]) -> Option<Pose> {
    let [x, y, z, roll, pitch, yaw] = body.pose.values(row);
    let finite = [x, y, z, roll, pitch, yaw].iter().all(|value| value.is_finite());
    finite.then(|| Pose {
        position: place(axes, [x, y, z]),
        orientation: orientation(axes, [roll, pitch, yaw]),
    })
}

/// A position in the world.
pub(super) fn place(axes: Axes, [x, y, z]: [f64; 3]) -> [f64; 3] {
    match axes {
        Axes::Ned => [y, x, -z],
        Axes::Enu => [x, y, z],
    }
}

/// A vector in body axes.
pub(super) fn of_body(axes: Axes, [x, y, z]: [f64; 3]) -> [f64; 3] {
    match axes {
        Axes::Ned => [x, -y, -z],
        Axes::Enu => [x, y, z],
    }
}

/// Roll, pitch and yaw, rotated in the order yaw, pitch, roll (Fossen 2011, 2.2.1).
pub(super) fn orientation(axes: Axes, [roll, pitch, yaw]: [f64; 3]) -> [f64; 4] {
    let (pitch, yaw) = match axes {
        Axes::Ned => (-pitch, FRAC_PI_2 - yaw),
        Axes::Enu => (pitch, yaw),
    };
    let half = |angle: f64| (libm::sin(angle / 2.0), libm::cos(angle / 2.0));
    let ((sr, cr), (sp, cp), (sy, cy)) = (half(roll), half(pitch), half(yaw));
    [
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    ]
}

/// The index of an axis of a pose in ROS, and its sign.
fn turned(axes: Axes, axis: usize) -> (usize, f64) {
    match (axes, axis) {
        (Axes::Enu, axis) => (axis, 1.0),
        (Axes::Ned, 0) => (1, 1.0),
        (Axes::Ned, 1) => (0, 1.0),
        (Axes::Ned, 3) => (3, 1.0),
        (Axes::Ned, axis) => (axis, -1.0),
    }
}

/// The variance for an axis of which nothing is known, beside others that are known.
const UNKNOWN: f64 = 1e6;

/// The covariance of the pose of a body, row by row; all zeros if none is recorded, which means
/// unknown in ROS.
pub(super) fn pose_covariance(axes: Axes, body: &Body, row: &[f64]) -> [f64; 36] {
    let mut covariance = [0.0; 36];
    if !body.sigma.is_there() {
        return covariance;
    }
    let sigmas = body.sigma.values(row);
    for (axis, sigma) in sigmas.into_iter().enumerate() {
        let (at, _) = turned(axes, axis);
        covariance[at * 7] = if body.sigma.has([axis]) { sigma * sigma } else { UNKNOWN };
    }
    for &(one, other, place) in &body.covariances {
        let ((first, sign), (second, other_sign)) = (turned(axes, one), turned(axes, other));
        let value = sign * other_sign * place.value(row);
        covariance[first * 6 + second] = value;
        covariance[second * 6 + first] = value;
    }
    covariance
}

/// A diagonal of variances; 0 if none is recorded.
pub(super) fn variances(sigmas: [Option<f64>; 6]) -> [f64; 36] {
    let mut covariance = [0.0; 36];
    if sigmas.iter().any(Option::is_some) {
        for (axis, sigma) in sigmas.into_iter().enumerate() {
            covariance[axis * 7] = sigma.map_or(UNKNOWN, |sigma| sigma * sigma);
        }
    }
    covariance
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// A body vector in the world.
    fn rotate(orientation: [f64; 4], vector: [f64; 3]) -> [f64; 3] {
        let matrix = Pose { position: [0.0; 3], orientation }.rotation();
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
    }

    #[test]
    fn the_attitude_of_ros_shows_the_same_directions() {
        for angles in [[0.0; 3], [0.3, -0.2, 0.7], [-1.0, 1.2, 3.0], [PI, 0.1, -2.5]] {
            for vector in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, -0.4, 0.8]] {
                // In north, east, down, and then in the axes of ROS ...
                let down = rotate(orientation(Axes::Enu, angles), vector);
                let wanted = place(Axes::Ned, down);
                // ... equals the attitude in the axes of ROS applied to the body vector.
                let found = rotate(orientation(Axes::Ned, angles), of_body(Axes::Ned, vector));
                for (found, wanted) in found.iter().zip(wanted) {
                    assert!((found - wanted).abs() < 1e-12, "{found} {wanted} {angles:?}");
                }
            }
        }
    }
}
