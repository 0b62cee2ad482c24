//! Errors of estimated trajectories, as defined by Sturm et al. 2012.

use crate::rotation::{Rotation, Vector, minus, norm};

/// A trajectory: positions, and headings where they are known.
pub(super) struct Trajectory {
    pub(super) positions: Vec<Vector>,
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
    pairs.map(|(t, e)| norm(minus(minus(*t, rotation.of(*e)), shift))).collect()
}

/// The rotation and translation that bring `from` closest to `to` in the least-squares sense.
fn alignment(to: &[Vector], from: &[Vector], align: Alignment) -> (Rotation, Vector) {
    if align == Alignment::None || to.is_empty() {
        return (Rotation::NONE, [0.0; 3]);
    }
    let mean = |points: &[Vector]| {
        std::array::from_fn(|axis| {
            points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64
        })
    };
    let (to_mean, from_mean): (Vector, Vector) = (mean(to), mean(from));
    let mut products = [[0.0; 3]; 3];
    for (t, f) in to.iter().zip(from) {
        let (t, f) = (minus(*t, to_mean), minus(*f, from_mean));
        products.iter_mut().zip(t).for_each(|(row, t)| {
            row.iter_mut().zip(f).for_each(|(product, f)| *product += t * f);
        });
    }
    let rotation = if align == Alignment::Se2 {
        let (sine, cosine) = (products[1][0] - products[0][1], products[0][0] + products[1][1]);
        Rotation::about_third(libm::atan2(sine, cosine))
    } else {
        Rotation::closest(products)
    };
    (rotation, minus(to_mean, rotation.of(from_mean)))
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
                way += norm(minus(truth.positions[i], truth.positions[i - 1]));
                if way >= delta {
                    ends.push(i);
                    way = 0.0;
                }
            }
            ends.windows(2).map(|pair| (pair[0], pair[1])).collect()
        }
    };
    let moved = |of: &Trajectory, (i, j): (usize, usize)| {
        Rotation::about_third(-of.headings[i]).of(minus(of.positions[j], of.positions[i]))
    };
    ids.into_iter().map(|pair| norm(minus(moved(truth, pair), moved(estimate, pair)))).collect()
}

/// How far an estimate is from the line along which the truth moves, in the horizontal plane.
pub(super) fn across(truth: &Trajectory, estimate: &Trajectory) -> Vec<f64> {
    let mut along = [0.0; 2];
    let pairs = truth.positions.iter().zip(&estimate.positions).enumerate();
    let beside = pairs.map(|(row, (t, e))| {
        // The direction of the step that starts here; the previous one while it stands still.
        let [x, y, _] = truth.positions.get(row + 1).map_or([0.0; 3], |next| minus(*next, *t));
        let length = norm([x, y, 0.0]);
        if length > 0.0 {
            along = [x / length, y / length];
        }
        let apart = minus(*e, *t);
        (along[0] * apart[1] - along[1] * apart[0]).abs()
    });
    beside.collect()
}

/// The length of a path.
pub(super) fn length(of: &Trajectory) -> f64 {
    of.positions.windows(2).map(|pair| norm(minus(pair[1], pair[0]))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosim_report::root_mean_square as rmse;

    /// A helix, and an estimate of it with errors in position, scale and heading.
    fn helix(planar: bool) -> (Trajectory, Trajectory) {
        let times: Vec<f64> = (0..40).map(f64::from).collect();
        let height = |z: f64| if planar { 0.0 } else { z };
        let truth =
            times.iter().map(|t| [5.0 * (0.1 * t).cos(), 5.0 * (0.1 * t).sin(), height(0.3 * t)]);
        let truth: Vec<_> = truth.collect();
        let estimate = times.iter().zip(&truth).map(|(t, [x, y, z])| {
            let (x, y) = (1.01 * x + 0.2 * t.sin(), y + 0.1 * (2.0 * t).cos() + 0.05 * t);
            [x, y, height(0.98 * z + 1.0)]
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
