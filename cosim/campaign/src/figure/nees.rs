//! The normalized estimation error squared.

use super::Poses;
use super::compute::axis_error;
use cosim_base::error::Result;
use cosim_core::observe::Recording;

/// The errors of a recorded estimate with their covariance, sample by sample.
pub(super) struct Nees<'r> {
    axes: Vec<Axis<'r>>,
    /// The lower triangle of the covariance, replaced by its Cholesky factor.
    factor: Vec<Vec<f64>>,
    /// The errors, normalized one after another.
    normalized: Vec<f64>,
}

struct Axis<'r> {
    name: &'r str,
    truth: &'r [f64],
    estimate: &'r [f64],
    deviation: &'r [f64],
    /// Covariances with the axes before this one, if they are known.
    covariances: Vec<&'r [f64]>,
}

impl<'r> Nees<'r> {
    /// Fails if a variable was not recorded.
    pub(super) fn new(
        poses: &'r Poses,
        sigma: &str,
        covariance: Option<&str>,
        recording: &'r Recording,
    ) -> Result<Self> {
        let column = |of: &str, element: &str| recording.column(&format!("{of}.{element}"));
        let axis = |(place, name): (usize, &'r String)| {
            let before = poses.axes[..place].iter().filter_map(|first| Some((first, covariance?)));
            let covariances = before.map(|(first, of)| column(of, &format!("{first}_{name}")));
            Ok(Axis {
                name,
                truth: column(&poses.truth, name)?,
                estimate: column(&poses.estimate, name)?,
                deviation: column(sigma, name)?,
                covariances: covariances.collect::<Result<_>>()?,
            })
        };
        let axes = poses.axes.iter().enumerate().map(axis).collect::<Result<Vec<_>>>()?;
        let factor = (0..axes.len()).map(|row| vec![0.0; row + 1]).collect();
        Ok(Self { normalized: vec![0.0; axes.len()], axes, factor })
    }

    /// Of one sample; NaN without a valid covariance.
    ///
    /// With P = L Lᵀ and L y = e, it is yᵀ y.
    pub(super) fn at(&mut self, sample: usize) -> f64 {
        for (i, axis) in self.axes.iter().enumerate() {
            let (above, rest) = self.factor.split_at_mut(i);
            let row = &mut rest[0];
            let mut error = axis_error(axis.name, axis.estimate[sample] - axis.truth[sample]);
            let mut variance = axis.deviation[sample] * axis.deviation[sample];
            for j in 0..i {
                let covariance = axis.covariances.get(j).map_or(0.0, |column| column[sample]);
                let known: f64 = (0..j).map(|k| row[k] * above[j][k]).sum();
                row[j] = (covariance - known) / above[j][j];
                variance -= row[j] * row[j];
                error -= row[j] * self.normalized[j];
            }
            if variance.is_nan() || variance <= 0.0 {
                return f64::NAN;
            }
            row[i] = variance.sqrt();
            self.normalized[i] = error / row[i];
        }
        self.normalized.iter().map(|error| error * error).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_weighted_by_the_inverse_of_their_covariance() {
        let axes = ["x", "y", "yaw"].map(str::to_owned).to_vec();
        let poses = Poses { truth: "t".into(), estimate: "e".into(), axes };
        let names = "t.x t.y t.yaw e.x e.y e.yaw s.x s.y s.yaw p.x_y p.x_yaw p.y_yaw";
        let columns: Vec<Vec<f64>> = [
            [1.0, 1.0, 1.0],
            [2.0, 2.0, 2.0],
            [-3.0, -3.0, -3.0],
            [2.0, 2.0, 2.0],
            [0.0, 0.0, 0.0],
            [3.0, 3.0, 3.0],
            [2.0, 2.0, 2.0],
            [1.0, 1.0, f64::NAN],
            [0.5, 0.5, 0.5],
            [0.8, 3.0, 0.8],
            [0.3, 0.3, 0.3],
            [-0.2, -0.2, -0.2],
        ]
        .map(Vec::from)
        .to_vec();
        let names = names.split(' ').map(str::to_owned).collect();
        let recording = Recording::from_columns(names, vec![0.0, 1.0, 2.0], columns);
        let of =
            |covariance, sample| Nees::new(&poses, "s", covariance, &recording).unwrap().at(sample);
        // For e = (1, -2, 6 - 2 pi), P solved by Gauss's elimination.
        assert!((of(Some("p"), 0) - 13.356_341_954_721_358).abs() < 1e-12);
        let yaw = 6.0 - std::f64::consts::TAU;
        let alone = 0.25 + 4.0 + 4.0 * yaw * yaw;
        assert!((of(None, 0) - alone).abs() < 1e-12);
        // Correlated by more than 1, and a deviation that is not a number.
        assert!(of(Some("p"), 1).is_nan() && of(Some("p"), 2).is_nan());
        assert!(Nees::new(&poses, "s", Some("q"), &recording).is_err());
    }
}
