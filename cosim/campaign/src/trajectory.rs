//! Errors of estimated trajectories, as defined by Sturm et al. 2012.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// A trajectory: positions, and headings where they are known.
pub(super) struct Trajectory {
    pub(super) positions: Vec<Vector3<f64>>,
    /// Rotation about the third axis (rad).
    pub(super) headings: Vec<f64>,
}

/// How an estimate is aligned with the truth before it is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Alignment {
    /// Not aligned.
    None,
    /// Translated, and rotated about the third axis.
    Se2,
    /// Translated and rotated.
    Se3,
}

pub(super) const ALIGNMENTS: [(&str, Alignment); 3] =
    [("none", Alignment::None), ("se2", Alignment::Se2), ("se3", Alignment::Se3)];

/// The distances of an estimate from the truth at each instant.
pub(super) fn distances(truth: &Trajectory, estimate: &Trajectory, align: Alignment) -> Vec<f64> {
    let (rotation, shift) = alignment(&truth.positions, &estimate.positions, align);
    let pairs = truth.positions.iter().zip(&estimate.positions);
    pairs.map(|(t, e)| (t - (rotation * e + shift)).norm()).collect()
}

/// The rotation and translation that bring `from` closest to `to` in the least-squares sense
/// (Umeyama 1991, without a scale).
fn alignment(
    to: &[Vector3<f64>],
    from: &[Vector3<f64>],
    align: Alignment,
) -> (Rotation3<f64>, Vector3<f64>) {
    if align == Alignment::None || to.is_empty() {
        return (Rotation3::identity(), Vector3::zeros());
    }
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (to_mean, from_mean) = (mean(to), mean(from));
    let pairs = to.iter().zip(from);
    let covariance: Matrix3<f64> =
        pairs.map(|(t, f)| (t - to_mean) * (f - from_mean).transpose()).sum();
    let rotation = if align == Alignment::Se2 {
        let sine = covariance[(1, 0)] - covariance[(0, 1)];
        let cosine = covariance[(0, 0)] + covariance[(1, 1)];
        Rotation3::from_axis_angle(&Vector3::z_axis(), libm::atan2(sine, cosine))
    } else {
        let parts = covariance.svd(true, true);
        let (Some(u), Some(v)) = (parts.u, parts.v_t) else {
            return (Rotation3::identity(), Vector3::zeros());
        };
        let mut flip = Matrix3::identity();
        flip[(2, 2)] = (u.determinant() * v.determinant()).signum();
        Rotation3::from_matrix_unchecked(u * flip * v)
    };
    (rotation, to_mean - rotation * from_mean)
}

/// The distance between two instants that are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pairs {
    /// In samples: each with the one this much later.
    Samples(usize),
    /// In metres along the true path: one stretch after another.
    Metres(f64),
}

/// The errors of the movement between pairs of instants, as translations.
pub(super) fn relative(truth: &Trajectory, estimate: &Trajectory, pairs: Pairs) -> Vec<f64> {
    let count = truth.positions.len();
    let ids: Vec<(usize, usize)> = match pairs {
        Pairs::Samples(delta) => (0..count.saturating_sub(delta)).map(|i| (i, i + delta)).collect(),
        Pairs::Metres(delta) => {
            let (mut ends, mut way) = (vec![0], 0.0);
            for i in 1..count {
                way += (truth.positions[i] - truth.positions[i - 1]).norm();
                if way >= delta {
                    ends.push(i);
                    way = 0.0;
                }
            }
            ends.windows(2).map(|pair| (pair[0], pair[1])).collect()
        }
    };
    let moved = |of: &Trajectory, (i, j): (usize, usize)| {
        let back = Rotation3::from_axis_angle(&Vector3::z_axis(), -of.headings[i]);
        back * (of.positions[j] - of.positions[i])
    };
    ids.into_iter().map(|pair| (moved(truth, pair) - moved(estimate, pair)).norm()).collect()
}

/// How far an estimate is from the line along which the truth moves, in the horizontal plane.
pub(super) fn across(truth: &Trajectory, estimate: &Trajectory) -> Vec<f64> {
    let mut along = Vector3::zeros();
    let pairs = truth.positions.iter().zip(&estimate.positions).enumerate();
    let beside = pairs.map(|(row, (t, e))| {
        // The direction of the step that starts here; the previous one while it stands still.
        let next = truth.positions.get(row + 1).map_or(Vector3::zeros(), |next| next - t);
        let step = Vector3::new(next.x, next.y, 0.0);
        if step.norm() > 0.0 {
            along = step.normalize();
        }
        let apart = e - t;
        (along.x * apart.y - along.y * apart.x).abs()
    });
    beside.collect()
}

/// The length of a path.
pub(super) fn length(of: &Trajectory) -> f64 {
    of.positions.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosim_report::root_mean_square as rmse;

    /// A helix, and an estimate of it with errors in position, scale and heading.
    fn helix(planar: bool) -> (Trajectory, Trajectory) {
        let times: Vec<f64> = (0..40).map(f64::from).collect();
        let height = |z: f64| if planar { 0.0 } else { z };
        let truth = times
            .iter()
            .map(|t| Vector3::new(5.0 * (0.1 * t).cos(), 5.0 * (0.1 * t).sin(), height(0.3 * t)));
        let truth: Vec<_> = truth.collect();
        let estimate = times.iter().zip(&truth).map(|(t, p)| {
            let (x, y) = (1.01 * p.x + 0.2 * t.sin(), p.y + 0.1 * (2.0 * t).cos() + 0.05 * t);
            Vector3::new(x, y, height(0.98 * p.z + 1.0))
        });
        let estimate: Vec<_> = estimate.collect();
        let headings: Vec<f64> = times.iter().map(|t| 0.1 * t).collect();
        let wrong = times.iter().map(|t| 0.1 * t + 0.02 * (3.0 * t).sin()).collect();
        (
            Trajectory { positions: truth, headings },
            Trajectory { positions: estimate, headings: wrong },
        )
    }

    fn max(values: &[f64]) -> f64 {
        values.iter().copied().fold(0.0, f64::max)
    }

    #[test]
    fn errors_are_those_of_evo() {
        // evo 1.38.1: metrics.APE and RPE of the translation part, PoseTrajectory3D.align, pairs
        // from the reference.
        let (truth, estimate) = helix(false);
        let near =
            |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        let apart = |align| distances(&truth, &estimate, align);
        near(rmse(&apart(Alignment::None)), 1.446_490_190_867_457);
        near(max(&apart(Alignment::None)), 2.127_537_124_448_056);
        near(rmse(&apart(Alignment::Se3)), 0.322_888_510_607_062_86);
        near(max(&apart(Alignment::Se3)), 0.763_626_616_203_709_1);
        let moved = |pairs| rmse(&relative(&truth, &estimate, pairs));
        near(moved(Pairs::Samples(1)), 0.187_204_750_034_358_63);
        near(moved(Pairs::Samples(10)), 0.579_257_626_731_884_5);
        near(moved(Pairs::Metres(2.0)), 0.324_770_821_589_240_8);
        let (truth, estimate) = helix(true);
        let apart = |align| distances(&truth, &estimate, align);
        near(rmse(&apart(Alignment::None)), 1.143_611_766_411_911_4);
        near(rmse(&apart(Alignment::Se2)), 0.376_809_243_217_548_83);
        near(max(&apart(Alignment::Se2)), 0.920_976_943_702_296_2);
        near(rmse(&apart(Alignment::Se3)), 0.376_809_243_217_548_83);
    }
}
