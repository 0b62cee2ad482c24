//! Computes figures of a recording.

use super::nees::Nees;
use super::{Figure, Over, Poses, Take, What, Window};
use crate::trajectory::{self, Alignment, Pairs, Trajectory};
use cosim_base::error::Result;
use cosim_core::observe::Recording;
use cosim_report::{mean, quantile, root_mean_square};

impl Poses {
    fn trajectory(
        &self,
        of: &str,
        heading: Option<&str>,
        from: &Recording,
        rows: &[usize],
    ) -> Result<Trajectory> {
        let mut positions = vec![[0.0; 3]; rows.len()];
        for (axis, place) in self.axes.iter().zip(0..3) {
            let column = from.column(&format!("{of}.{axis}"))?;
            rows.iter().zip(&mut positions).for_each(|(row, p)| p[place] = column[*row]);
        }
        let headings = match heading {
            Some(heading) => {
                let column = from.column(&format!("{of}.{heading}"))?;
                rows.iter().map(|row| column[*row]).collect()
            }
            None => vec![0.0; rows.len()],
        };
        Ok(Trajectory { positions, headings })
    }

    fn both(
        &self,
        heading: Option<&str>,
        from: &Recording,
        rows: &[usize],
    ) -> Result<(Trajectory, Trajectory)> {
        let of = |of| self.trajectory(of, heading, from, rows);
        Ok((of(&self.truth)?, of(&self.estimate)?))
    }
}

impl Figure {
    /// The number; NaN if the run has none.
    ///
    /// `faults` contains when the first fault of the run began and when the last one ended (s).
    pub(crate) fn compute(&self, recording: &Recording, faults: Option<[f64; 2]>) -> Result<f64> {
        let time = recording.time();
        let (from, until) = match (self.window, faults) {
            (Window::All, _) => (f64::NEG_INFINITY, f64::INFINITY),
            (Window::Before, Some([begin, _])) => (f64::NEG_INFINITY, begin),
            (Window::During, Some([begin, end])) => (begin, end),
            (Window::After, Some([_, end])) => (end, f64::INFINITY),
            (_, None) => return Ok(f64::NAN),
        };
        let (from, until) = (self.from.max(from), self.until.min(until));
        let counts = |row: &usize| time[*row] >= from && time[*row] <= until;
        let rows: Vec<usize> = (0..time.len()).filter(counts).collect();
        if rows.is_empty() {
            return Ok(f64::NAN);
        }
        Ok(match &self.what {
            What::Of { of, minus, absolute, angle, take } => {
                let column = of.values(recording)?;
                let minus = minus.as_ref().map(|minus| minus.values(recording)).transpose()?;
                let value = |row: &usize| {
                    let value = column[*row] - minus.as_ref().map_or(0.0, |minus| minus[*row]);
                    let value = if *angle { wrapped(value) } else { value };
                    if *absolute { value.abs() } else { value }
                };
                let values: Vec<f64> = rows.iter().map(value).collect();
                let times: Vec<f64> = rows.iter().map(|row| time[*row]).collect();
                take.of(&times, &values)
            }
            What::Ate { poses, align, greatest } => {
                let (truth, estimate) = poses.both(None, recording, &rows)?;
                let apart = trajectory::distances(&truth, &estimate, *align);
                if *greatest { extreme(&apart, f64::max) } else { root_mean_square(&apart) }
            }
            What::Rpe { poses, heading, over } => {
                let (truth, estimate) = poses.both(Some(heading), recording, &rows)?;
                let pairs = match over {
                    Over::Metres(metres) => Pairs::Metres(*metres),
                    Over::Seconds(seconds) => {
                        let interval = time.get(1).map_or(f64::NAN, |next| next - time[0]);
                        Pairs::Samples(((seconds / interval).round() as usize).max(1))
                    }
                };
                root_mean_square(&trajectory::relative(&truth, &estimate, pairs))
            }
            What::Drift(poses) => {
                let (truth, estimate) = poses.both(None, recording, &rows)?;
                let apart = trajectory::distances(&truth, &estimate, Alignment::None);
                100.0 * apart.last().copied().unwrap_or(f64::NAN) / trajectory::length(&truth)
            }
            What::CrossTrack { poses, greatest } => {
                let (truth, estimate) = poses.both(None, recording, &rows)?;
                let apart = trajectory::across(&truth, &estimate);
                if *greatest { extreme(&apart, f64::max) } else { root_mean_square(&apart) }
            }
            What::Beyond { poses, sigma, sigmas } => {
                let (mut beyond, mut all) = (0, 0);
                for axis in &poses.axes {
                    let column = |of: &str| recording.column(&format!("{of}.{axis}"));
                    let (truth, estimate) = (column(&poses.truth)?, column(&poses.estimate)?);
                    let deviation = column(sigma)?;
                    let far = |row: &&usize| {
                        let error = axis_error(axis, estimate[**row] - truth[**row]);
                        error.is_nan() || error.abs() > sigmas * deviation[**row]
                    };
                    beyond += rows.iter().filter(far).count();
                    all += rows.len();
                }
                beyond as f64 / all as f64
            }
            What::Nees { poses, sigma, covariance, at } => {
                let mut nees = Nees::new(poses, sigma, covariance.as_deref(), recording)?;
                match at {
                    Some(at) => last_until(time, &rows, *at).map_or(f64::NAN, |row| nees.at(*row)),
                    None => mean(&rows.iter().map(|row| nees.at(*row)).collect::<Vec<_>>()),
                }
            }
            What::Nis { nis, count, at } => {
                let rows = grown(recording.column(count)?, &rows);
                let nis = recording.column(nis)?;
                match at {
                    Some(at) => last_until(time, &rows, *at).map_or(f64::NAN, |row| nis[*row]),
                    None => mean(&rows.iter().map(|row| nis[*row]).collect::<Vec<_>>()),
                }
            }
            What::Whiteness { innovation, count } => {
                let rows = grown(recording.column(count)?, &rows);
                let innovation = recording.column(innovation)?;
                let values: Vec<f64> = rows.iter().map(|row| innovation[*row]).collect();
                let (before, after) = (&values[..values.len().saturating_sub(1)], &values[..]);
                let pairs = before.iter().zip(after.iter().skip(1));
                let product: f64 = pairs.map(|(one, next)| one * next).sum();
                let square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
                let size = square(before) * square(after.get(1..).unwrap_or_default());
                product / size.sqrt() * (before.len() as f64).sqrt()
            }
        })
    }
}

impl Take {
    fn of(&self, times: &[f64], values: &[f64]) -> f64 {
        match *self {
            Take::Final => values.last().copied().unwrap_or(f64::NAN),
            Take::Min => extreme(values, f64::min),
            Take::Max => extreme(values, f64::max),
            Take::Mean => mean(values),
            Take::Rms | Take::Error(_) => root_mean_square(values),
            Take::Percentile(p) if values.iter().all(|v| v.is_finite()) => {
                quantile(values, p / 100.0)
            }
            Take::Percentile(_) => f64::NAN,
            // A sample is valid until the next one.
            Take::TimeAbove(bound) => {
                let spans = times.windows(2).zip(values);
                spans.filter(|(_, v)| **v > bound).map(|(pair, _)| pair[1] - pair[0]).sum()
            }
            Take::FirstAbove(bound) => {
                let first = values.iter().position(|value| *value > bound);
                first.map_or(f64::INFINITY, |place| times[place])
            }
            Take::SettledBelow(bound) => {
                let last = values.iter().rposition(|value| value.is_nan() || *value >= bound);
                let settled = last.map_or(Some(&times[0]), |last| times.get(last + 1));
                settled.map_or(f64::INFINITY, |settled| settled - times[0])
            }
            Take::At(instant) => {
                // The instants of a file are multiples of an interval, with rounding errors.
                let reached = times.last().is_some_and(|last| *last >= instant - 1e-9);
                let until = times.partition_point(|time| *time <= instant + 1e-9);
                let last = until.checked_sub(1).filter(|_| reached);
                last.map_or(f64::NAN, |place| values[place])
            }
        }
    }
}

/// The minimum or maximum; NaN if any value is NaN.
fn extreme(values: &[f64], of: fn(f64, f64) -> f64) -> f64 {
    let both = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { of(a, b) };
    values.iter().copied().reduce(both).unwrap_or(f64::NAN)
}

/// For axes called `yaw` the smallest rotation counts.
pub(super) fn axis_error(axis: &str, error: f64) -> f64 {
    if axis == "yaw" { wrapped(error) } else { error }
}

fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle + PI).rem_euclid(TAU) - PI
}

/// The rows at which a count has increased.
fn grown(count: &[f64], rows: &[usize]) -> Vec<usize> {
    rows.iter().copied().filter(|&row| row > 0 && count[row] > count[row - 1]).collect()
}

/// The last of these rows that is not after an instant.
fn last_until<'r>(time: &[f64], rows: &'r [usize], instant: f64) -> Option<&'r usize> {
    rows.iter().rev().find(|row| time[**row] <= instant)
}
