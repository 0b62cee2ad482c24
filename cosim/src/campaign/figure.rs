//! Figures of merit: a number from what was recorded in a run.

use nalgebra::{DMatrix, DVector, Vector3};

use super::trajectory::{self, ALIGNMENTS, Alignment, Pairs, Trajectory};
use crate::error::Result;
use crate::names;
use crate::observe::Recording;
use crate::report::{mean, quantile, root_mean_square};
use crate::table::Table;

/// A figure of merit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    what: What,
    /// The part of the run that counts (s).
    from: f64,
    until: f64,
}

/// What is computed.
#[derive(Debug, Clone, PartialEq)]
enum What {
    /// Of a variable, or of how far it is above another one.
    Of { variable: String, minus: Option<String>, absolute: bool, take: Take },
    /// Absolute trajectory error.
    Ate { poses: Poses, align: Alignment, greatest: bool },
    /// Relative pose error, root mean square.
    Rpe { poses: Poses, heading: String, over: Over },
    /// The distance in the end, in % of the way.
    Drift(Poses),
    /// Mean normalised estimation error squared.
    Nees { poses: Poses, sigma: String, covariance: Option<String> },
    /// Mean normalised innovation squared, over the samples at which `count` grew.
    Nis { nis: String, count: String },
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Take {
    Final,
    Min,
    Max,
    Mean,
    Rms,
    Percentile(f64),
    TimeAbove(f64),
    FirstAbove(f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Over {
    Seconds(f64),
    Metres(f64),
}

/// The variables of a truth and an estimate, axis by axis.
#[derive(Debug, Clone, PartialEq)]
struct Poses {
    truth: String,
    estimate: String,
    axes: Vec<String>,
}

pub(super) const KINDS: [&str; 13] = [
    "final",
    "min",
    "max",
    "mean",
    "rms",
    "percentile",
    "time-above",
    "first-above",
    "ate",
    "rpe",
    "drift",
    "nees",
    "nis",
];

impl Poses {
    fn read(table: &Table<'_>) -> Option<Self> {
        let (truth, estimate) = (table.needed_text("truth"), table.needed_text("estimate"));
        let mut axes: Vec<String> = table.texts("axes").into_iter().map(str::to_owned).collect();
        if axes.is_empty() {
            axes = ["x", "y", "z"].map(str::to_owned).to_vec();
        }
        Some(Self { truth: truth?.to_owned(), estimate: estimate?.to_owned(), axes })
    }

    fn columns(&self) -> Vec<String> {
        let both = [&self.truth, &self.estimate].into_iter();
        both.flat_map(|of| self.axes.iter().map(move |axis| format!("{of}.{axis}"))).collect()
    }

    fn trajectory(
        &self,
        of: &str,
        heading: Option<&str>,
        from: &Recording,
        rows: &[usize],
    ) -> Result<Trajectory> {
        let mut positions = vec![Vector3::zeros(); rows.len()];
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
    /// From a table of the file; nothing if that is wrong.
    pub(super) fn read(table: &Table<'_>) -> Option<Self> {
        let kind = table.needed_text("kind")?;
        const POSES: [&str; 6] = ["kind", "from", "until", "truth", "estimate", "axes"];
        let allow = |own: &[&str]| table.allow(&[&POSES, own].concat());
        let what = match kind {
            "ate" => {
                allow(&["align", "take"]);
                let align = table.text("align").unwrap_or("none");
                let found = ALIGNMENTS.iter().find(|(name, _)| *name == align);
                if found.is_none() {
                    table.get("align")?.wrong(format!("'{align}' is none of none, se2, se3"));
                }
                let greatest = match table.text("take") {
                    None | Some("rmse") => false,
                    Some("max") => true,
                    Some(other) => {
                        table.get("take")?.wrong(format!("'{other}' is none of rmse, max"));
                        return None;
                    }
                };
                What::Ate { poses: Poses::read(table)?, align: found?.1, greatest }
            }
            "rpe" => {
                allow(&["heading", "seconds", "metres"]);
                let over = match (table.get("seconds"), table.get("metres")) {
                    (Some(_), None) => Over::Seconds(table.positive("seconds")?),
                    (None, Some(_)) => Over::Metres(table.positive("metres")?),
                    _ => {
                        table.wrong("one of 'seconds' and 'metres' must say over what");
                        return None;
                    }
                };
                let heading = table.text("heading").unwrap_or("yaw").to_owned();
                What::Rpe { poses: Poses::read(table)?, heading, over }
            }
            "drift" => {
                allow(&[]);
                What::Drift(Poses::read(table)?)
            }
            "nees" => {
                allow(&["sigma", "covariance"]);
                let (poses, sigma) = (Poses::read(table), table.needed_text("sigma"));
                let covariance = table.text("covariance").map(str::to_owned);
                What::Nees { poses: poses?, sigma: sigma?.to_owned(), covariance }
            }
            "nis" => {
                table.allow(&["kind", "from", "until", "nis", "count"]);
                let (nis, count) = (table.needed_text("nis"), table.needed_text("count"));
                What::Nis { nis: nis?.to_owned(), count: count?.to_owned() }
            }
            _ => Self::read_of(table, kind)?,
        };
        let bound = |key: &str, none| table.get(key).map_or(Some(none), |bound| bound.number());
        let (from, until) = (bound("from", f64::NEG_INFINITY)?, bound("until", f64::INFINITY)?);
        if until <= from {
            table.wrong(format!("'until' {until} is not after 'from' {from}"));
        }
        Some(Self { what, from, until })
    }

    fn read_of(table: &Table<'_>, kind: &str) -> Option<What> {
        let number = |key: &str| table.needed_number(key);
        let (take, own) = match kind {
            "final" => (Some(Take::Final), None),
            "min" => (Some(Take::Min), None),
            "max" => (Some(Take::Max), None),
            "mean" => (Some(Take::Mean), None),
            "rms" => (Some(Take::Rms), None),
            "percentile" => (number("p").map(Take::Percentile), Some("p")),
            "time-above" => (number("above").map(Take::TimeAbove), Some("above")),
            "first-above" => (number("above").map(Take::FirstAbove), Some("above")),
            other => {
                let help = names::did_you_mean(other, KINDS)
                    .unwrap_or_else(|| format!("known are {}", KINDS.join(", ")));
                table.get("kind")?.wrong(format!("there is no figure '{other}'; {help}"));
                return None;
            }
        };
        let known = ["kind", "from", "until", "of", "minus", "absolute"];
        table.allow(&known.into_iter().chain(own).collect::<Vec<_>>());
        if let Some(Take::Percentile(p)) = take
            && !(0.0..=100.0).contains(&p)
        {
            table.get("p")?.wrong(format!("{p} is not between 0 and 100"));
        }
        let variable = table.needed_text("of").map(str::to_owned);
        let minus = table.text("minus").map(str::to_owned);
        let absolute = table.number("absolute").is_some_and(|absolute| absolute != 0.0);
        Some(What::Of { variable: variable?, minus, absolute, take: take? })
    }

    /// The variables that it needs.
    pub(super) fn columns(&self) -> Vec<String> {
        match &self.what {
            What::Of { variable, minus, .. } => {
                [variable.clone()].into_iter().chain(minus.clone()).collect()
            }
            What::Ate { poses, .. } | What::Drift(poses) => poses.columns(),
            What::Rpe { poses, heading, .. } => {
                let mut columns = poses.columns();
                columns.extend([&poses.truth, &poses.estimate].map(|of| format!("{of}.{heading}")));
                columns
            }
            What::Nees { poses, sigma, covariance } => {
                let mut columns = poses.columns();
                columns.extend(poses.axes.iter().map(|axis| format!("{sigma}.{axis}")));
                if let Some(covariance) = covariance {
                    for (place, first) in poses.axes.iter().enumerate() {
                        let others = poses.axes[place + 1..].iter();
                        columns.extend(others.map(|other| format!("{covariance}.{first}_{other}")));
                    }
                }
                columns
            }
            What::Nis { nis, count } => vec![nis.clone(), count.clone()],
        }
    }

    /// The number; NaN if the run has none.
    pub(super) fn compute(&self, recording: &Recording) -> Result<f64> {
        let time = recording.time();
        let counts = |row: &usize| time[*row] >= self.from && time[*row] <= self.until;
        let rows: Vec<usize> = (0..time.len()).filter(counts).collect();
        if rows.is_empty() {
            return Ok(f64::NAN);
        }
        Ok(match &self.what {
            What::Of { variable, minus, absolute, take } => {
                let column = recording.column(variable)?;
                let minus = minus.as_ref().map(|minus| recording.column(minus)).transpose()?;
                let value = |row: &usize| {
                    let value = column[*row] - minus.map_or(0.0, |minus| minus[*row]);
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
            What::Nees { poses, sigma, covariance } => {
                let all: Result<Vec<f64>> = rows
                    .iter()
                    .map(|row| nees(poses, sigma, covariance.as_deref(), recording, *row))
                    .collect();
                mean(&all?)
            }
            What::Nis { nis, count } => {
                let (nis, count) = (recording.column(nis)?, recording.column(count)?);
                let came = |row: &&usize| **row > 0 && count[**row] > count[**row - 1];
                mean(&rows.iter().filter(came).map(|row| nis[*row]).collect::<Vec<_>>())
            }
        })
    }
}

impl Take {
    fn of(self, times: &[f64], values: &[f64]) -> f64 {
        match self {
            Take::Final => values.last().copied().unwrap_or(f64::NAN),
            Take::Min => extreme(values, f64::min),
            Take::Max => extreme(values, f64::max),
            Take::Mean => mean(values),
            Take::Rms => root_mean_square(values),
            Take::Percentile(p) if values.iter().all(|v| v.is_finite()) => {
                quantile(values, p / 100.0)
            }
            Take::Percentile(_) => f64::NAN,
            // A sample stands for the time until the next one.
            Take::TimeAbove(bound) => {
                let spans = times.windows(2).zip(values);
                spans.filter(|(_, v)| **v > bound).map(|(pair, _)| pair[1] - pair[0]).sum()
            }
            Take::FirstAbove(bound) => {
                let first = values.iter().position(|value| *value > bound);
                first.map_or(f64::INFINITY, |place| times[place])
            }
        }
    }
}

/// The least or the greatest; NaN if one is.
fn extreme(values: &[f64], of: fn(f64, f64) -> f64) -> f64 {
    let both = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { of(a, b) };
    values.iter().copied().reduce(both).unwrap_or(f64::NAN)
}

/// Of one sample; NaN without a covariance that is one. Of axes called `yaw` the nearest turn counts.
fn nees(
    poses: &Poses,
    sigma: &str,
    covariance: Option<&str>,
    recording: &Recording,
    row: usize,
) -> Result<f64> {
    use std::f64::consts::{PI, TAU};
    let value = |name: String| recording.column(&name).map(|column| column[row]);
    let count = poses.axes.len();
    let mut errors = DVector::zeros(count);
    let mut matrix = DMatrix::zeros(count, count);
    for (place, axis) in poses.axes.iter().enumerate() {
        let truth = value(format!("{}.{axis}", poses.truth))?;
        let error = value(format!("{}.{axis}", poses.estimate))? - truth;
        errors[place] = if axis == "yaw" { (error + PI).rem_euclid(TAU) - PI } else { error };
        let deviation = value(format!("{sigma}.{axis}"))?;
        matrix[(place, place)] = deviation * deviation;
        for (other, second) in poses.axes.iter().enumerate().skip(place + 1) {
            if let Some(covariance) = covariance {
                let element = value(format!("{covariance}.{axis}_{second}"))?;
                (matrix[(place, other)], matrix[(other, place)]) = (element, element);
            }
        }
    }
    Ok(matrix.cholesky().map_or(f64::NAN, |factor| errors.dot(&factor.solve(&errors))))
}

mod words;

#[cfg(test)]
mod tests;
