//! The result of one filter in one mission.

use cosim::report::{mean, root_mean_square};
use cosim::{Recording, Summary};
use nalgebra::{Matrix4, Vector4};
use rexrov::attitude::wrap;

use super::cell::{Cell, LOST};
use super::filter::Filter;
use super::mission::{Flight, INTERVAL, column, course, row};
use super::smoother::Smoothed;
use crate::experiment::mean_distance;

/// After this time filters have settled (s).
pub(crate) const SETTLED: f64 = 30.0;
/// Sensors with an innovation, with their dimensions.
pub(crate) const CHANNELS: [(&str, f64); 5] =
    [("tilt", 2.0), ("heading", 1.0), ("depth", 1.0), ("dvl", 3.0), ("fix", 2.0)];
/// Rows between the instants for which the normalised errors are kept.
const STRIDE: usize = 10;
/// Fraction of lost thrust above which a thruster counts as lost.
const LOSS: f64 = 0.1;

/// Measures of one filter in one mission. RMSE are of the horizontal position (m).
#[derive(Clone, Debug, Default)]
pub(crate) struct Score {
    /// RMSE of the whole mission.
    pub(crate) rmse: f64,
    /// Errors of x and y (m).
    pub(crate) axes: [f64; 2],
    /// After settling: RMSE, depth (m), heading (rad), mean variance of the position (m2).
    pub(crate) settled: f64,
    pub(crate) depth: f64,
    pub(crate) heading: f64,
    pub(crate) variance: f64,
    /// NEES of x, y and of x, y, z, heading, once a second after settling.
    pub(crate) nees: [Vec<f64>; 2],
    /// Sum and number of the NIS of each channel, after settling.
    pub(crate) nis: [[f64; 2]; CHANNELS.len()],
    /// RMSE within the window of the cell.
    pub(crate) window: f64,
    /// Error at the end of the window (m), and its NEES.
    pub(crate) last: f64,
    pub(crate) last_nees: f64,
    /// When the loss of the propeller was detected, after it happened (s), and whether it was the
    /// right one.
    pub(crate) detected: f64,
    pub(crate) right: bool,
    /// False alarms, and the time in which they could occur (h).
    pub(crate) false_alarms: f64,
    pub(crate) hours: f64,
    /// Mean distance of the vehicle from its course, horizontally and in depth (m).
    pub(crate) total: f64,
    pub(crate) vertical: f64,
    /// Whether the end of the course was reached.
    pub(crate) finished: bool,
    /// The result of the smoother, in cells that are smoothed.
    pub(crate) smoothed: Option<Smoothed>,
    /// Processor time of the filter's FMU over simulated time.
    pub(crate) load: f64,
}

impl Score {
    /// Measures a filter.
    pub(crate) fn of(
        Flight { recording, summary, .. }: &Flight,
        cell: &Cell,
        filter: Filter,
    ) -> anyhow::Result<Self> {
        let errors = Errors::of(recording, filter)?;
        let end = recording.time().len();
        let settled = row(SETTLED)..end;
        let [from, to] = cell.window.unwrap_or([0.0, f64::MAX]);
        let (from, last) = (row(from).min(end - 1), row(to).min(end - 1));
        let mut score = Score {
            rmse: errors.rmse(0..end),
            axes: [0, 1].map(|axis| root_mean_square(&errors.errors[axis])),
            settled: errors.rmse(settled.clone()),
            depth: root_mean_square(&errors.errors[2][settled.clone()]),
            heading: root_mean_square(&errors.errors[3][settled.clone()]),
            variance: mean(&errors.variance()[settled.clone()]),
            nees: [2, 4]
                .map(|n| settled.clone().step_by(STRIDE).map(|i| errors.nees(i, n)).collect()),
            nis: nis(recording, filter)?,
            window: errors.rmse(from..last + 1),
            last: errors.horizontal(last),
            last_nees: errors.nees(last, 2),
            finished: recording.column("pursuit.finished")?.last().is_some_and(|f| *f >= 0.5),
            vertical: mean_size(recording.column("pursuit.vertical_track")?),
            load: load(summary, filter),
            ..Score::default()
        };
        score.losses(recording, cell, filter)?;
        let [x, y] = ["x", "y"].map(|axis| recording.column(&format!("vehicle.pose.{axis}")));
        score.total = mean_distance(&course(cell.course)?, x?, y?);
        Ok(score)
    }

    fn losses(&mut self, recording: &Recording, cell: &Cell, filter: Filter) -> anyhow::Result<()> {
        self.detected = f64::INFINITY;
        if filter.is_paper() {
            return Ok(());
        }
        let time = recording.time();
        let lost = cell.propeller_lost.unwrap_or(f64::INFINITY);
        let sound = time.iter().take_while(|t| **t <= lost).count();
        self.hours = sound as f64 * INTERVAL / 3600.0;
        for thruster in 0..8 {
            let loss = column(recording, filter, &format!("thruster[{thruster}].loss"))?;
            let rises = |i: &usize| loss[*i] > LOSS && (*i == 0 || loss[*i - 1] <= LOSS);
            self.false_alarms += (0..sound).filter(rises).count() as f64;
            if let Some(first) = (sound..time.len()).find(rises) {
                let after = time[first] - lost;
                if after < self.detected {
                    (self.detected, self.right) = (after, thruster == LOST);
                }
            }
        }
        Ok(())
    }
}

fn load(summary: &Summary, filter: Filter) -> f64 {
    let component = summary.components.iter().find(|c| c.name == filter.component());
    component.map_or(f64::NAN, |c| c.seconds_per_step * c.steps as f64 / summary.simulated)
}

fn mean_size(values: &[f64]) -> f64 {
    values.iter().map(|v| v.abs()).sum::<f64>() / values.len() as f64
}

/// Names of the components of a pose.
const AXES: [&str; 4] = ["x", "y", "z", "yaw"];

/// Errors of a pose with their covariance.
struct Errors<'a> {
    errors: [Vec<f64>; 4],
    sigma: [&'a [f64]; 4],
    /// Elements above the diagonal, row by row.
    covariance: [&'a [f64]; 6],
}

impl<'a> Errors<'a> {
    fn of(recording: &'a Recording, filter: Filter) -> anyhow::Result<Self> {
        let mut errors: [Vec<f64>; 4] = Default::default();
        let (mut sigma, mut covariance): ([&[f64]; 4], [&[f64]; 6]) = Default::default();
        for (i, axis) in AXES.into_iter().enumerate() {
            let truth = recording.column(&format!("vehicle.pose.{axis}"))?;
            let estimate = column(recording, filter, &format!("pose.{axis}"))?;
            let difference = estimate.iter().zip(truth).map(|(e, t)| e - t);
            errors[i] = difference.map(|e| if axis == "yaw" { wrap(e) } else { e }).collect();
            sigma[i] = column(recording, filter, &format!("sigma.{axis}"))?;
        }
        for (place, pair) in
            ["x_y", "x_z", "x_yaw", "y_z", "y_yaw", "z_yaw"].into_iter().enumerate()
        {
            covariance[place] = column(recording, filter, &format!("covariance.{pair}"))?;
        }
        Ok(Self { errors, sigma, covariance })
    }

    fn horizontal(&self, row: usize) -> f64 {
        self.errors[0][row].hypot(self.errors[1][row])
    }

    fn rmse(&self, rows: std::ops::Range<usize>) -> f64 {
        root_mean_square(&rows.map(|row| self.horizontal(row)).collect::<Vec<_>>())
    }

    /// Variance of x and y together.
    fn variance(&self) -> Vec<f64> {
        self.sigma[0].iter().zip(self.sigma[1]).map(|(x, y)| x * x + y * y).collect()
    }

    /// Normalised estimation error squared of the first `n` components; NaN without a covariance.
    fn nees(&self, row: usize, n: usize) -> f64 {
        let c = self.covariance.map(|element| element[row]);
        let d = self.sigma.map(|sigma| sigma[row] * sigma[row]);
        #[rustfmt::skip]
        let mut p = Matrix4::new(
            d[0], c[0], c[1], c[2],
            c[0], d[1], c[3], c[4],
            c[1], c[3], d[2], c[5],
            c[2], c[4], c[5], d[3],
        );
        let mut e = Vector4::from_fn(|i, _| self.errors[i][row]);
        for i in n..4 {
            p.row_mut(i).fill(0.0);
            p.column_mut(i).fill(0.0);
            (p[(i, i)], e[i]) = (1.0, 0.0);
        }
        p.cholesky().map_or(f64::NAN, |factor| e.dot(&factor.solve(&e)))
    }
}

/// Sum and number of the NIS of each channel, for the measurements between two rows.
fn nis(recording: &Recording, filter: Filter) -> anyhow::Result<[[f64; 2]; CHANNELS.len()]> {
    let mut sums = [[0.0; 2]; CHANNELS.len()];
    for (sum, (channel, _)) in sums.iter_mut().zip(CHANNELS) {
        let nis = column(recording, filter, &format!("nis.{channel}"))?;
        let used = column(recording, filter, &format!("count.{channel}.used"))?;
        for i in row(SETTLED)..nis.len() {
            if used[i] > used[i - 1] {
                *sum = [sum[0] + nis[i], sum[1] + 1.0];
            }
        }
    }
    Ok(sums)
}
