//! The paper's three measures (section 9), over one run until the course is finished.
//!
//! * Total: mean distance between the reference path and the path taken.
//! * X-Kalman: RMSE between the filter's x and the true x.
//! * Y-Kalman: the same along y. The paper's text says MSE, its tables use metres: both are here.

use cosim::report::{quantile, root_mean_square};
use rexrov::guidance::Course as Path;

use super::trace::Trace;
use crate::experiment::mean_distance;

/// The measures of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Metrics {
    /// Mean distance of the path taken from the reference path, m.
    pub(crate) total: f64,
    /// RMSE of the estimate along x (north), m.
    pub(crate) x_rmse: f64,
    /// RMSE of the estimate along y (east), m.
    pub(crate) y_rmse: f64,
    /// Mean square error of the estimate along y, m2.
    pub(crate) y_mse: f64,
    /// Time to finish the course, s; NaN if it was not finished.
    pub(crate) finish_time: f64,
}

impl Metrics {
    /// Measures a run against its reference path.
    pub(crate) fn of(trace: &Trace, reference: &Path) -> Self {
        let y_rmse = root_mean_square(&trace.error(1));
        let last = trace.time.last().copied().unwrap_or(f64::NAN);
        Metrics {
            total: mean_distance(reference, &trace.truth[0], &trace.truth[1]),
            x_rmse: root_mean_square(&trace.error(0)),
            y_rmse,
            y_mse: y_rmse * y_rmse,
            finish_time: if trace.finished { last } else { f64::NAN },
        }
    }
}

/// Median and 5 to 95 % over seeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// 95 % confidence interval of the median of all possible seeds.
    pub(crate) median_interval: [f64; 2],
}

impl Spread {
    /// The spread of one measure.
    pub(crate) fn of(runs: &[Metrics], measure: fn(&Metrics) -> f64) -> Self {
        let values: Vec<f64> = runs.iter().map(measure).collect();
        let [low, median, high] = [0.05, 0.5, 0.95].map(|p| quantile(&values, p));
        Spread { median, low, high, median_interval: median_interval(values) }
    }
}

/// Distribution-free 95 % interval of the median: order statistics `(n -+ 1.96 sqrt(n)) / 2`
/// (normal approximation of the binomial); with few values their whole range.
fn median_interval(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let below = (0.5 * (n - 1.96 * n.sqrt())).floor().max(0.0) as usize;
    let ends = [values.get(below), values.iter().rev().nth(below)];
    ends.map(|end| end.copied().unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along the first straight of BE1, 0.3 m to starboard, estimated 0.1 m behind, and y
    /// alternately 0.4 m too large and too small.
    fn trace() -> Trace {
        let n = 50;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) * 0.1).collect();
        let alternating = (0..n).map(|i| 0.3 + if i % 2 == 0 { 0.4 } else { -0.4 }).collect();
        Trace {
            time: (0..n).map(|i| f64::from(i) * 0.1).collect(),
            estimate: [x.iter().map(|x| x - 0.1).collect(), alternating, vec![], vec![]],
            truth: [x, vec![0.3; n as usize], vec![], vec![]],
            finished: true,
            ..Trace::default()
        }
    }

    #[test]
    fn measures_of_constant_errors_are_those_errors() {
        let path = Path::parse(Path::BE1).unwrap();
        let metrics = Metrics::of(&trace(), &path);
        assert!((metrics.total - 0.3).abs() < 1e-9, "{metrics:?}");
        assert!((metrics.x_rmse - 0.1).abs() < 1e-9);
        assert!((metrics.y_rmse - 0.4).abs() < 1e-9);
        assert!((metrics.y_mse - 0.16).abs() < 1e-9);
        assert!((metrics.finish_time - 4.9).abs() < 1e-9);
    }

    #[test]
    fn a_run_that_does_not_arrive_has_no_finish_time() {
        let path = Path::parse(Path::BE1).unwrap();
        let metrics = Metrics::of(&Trace { finished: false, ..trace() }, &path);
        assert!(metrics.finish_time.is_nan());
    }

    #[test]
    fn the_spread_is_taken_over_seeds() {
        let run = |total| Metrics { total, x_rmse: 0.0, y_rmse: 0.0, y_mse: 0.0, finish_time: 1.0 };
        let runs: Vec<Metrics> = (0..=100).map(|i| run(f64::from(i))).collect();
        let spread = Spread::of(&runs, |m| m.total);
        assert_eq!((spread.low, spread.median, spread.high), (5.0, 50.0, 95.0));
        // Of 101 values the 41st from either end.
        assert_eq!(spread.median_interval, [40.0, 60.0]);
        assert_eq!(Spread::of(&runs[..2], |m| m.total).median_interval, [0.0, 1.0]);
    }
}
