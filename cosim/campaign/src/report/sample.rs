//! Runs as points, and the parameters that figures depend on.

use std::collections::HashSet;
use std::path::Path;

use serde::Serialize;

use super::Main;
use super::outage::Outages;
use crate::columns::Columns;
use crate::rows::unkept;
use crate::{Campaign, Contents, Rows};
use cosim_base::error::Result;
use cosim_report::Numbers;

/// Some runs of a cell, column by column: the first replicates, which are the same in all cells,
/// the worst, and those that are shown in full.
#[derive(Default, Serialize)]
pub(super) struct Sample {
    pub(super) run: Vec<u64>,
    /// For each figure.
    pub(super) figures: Vec<Numbers>,
    /// For each input.
    pub(super) inputs: Vec<Numbers>,
}

/// A parameter that differs from run to run or from cell to cell.
#[derive(Serialize)]
pub(super) struct Input {
    name: String,
    unit: String,
    /// If it is not a number: its texts; the values are their positions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    texts: Vec<String>,
    /// It is the outage, which is not in the rows.
    #[serde(skip)]
    is_outage: bool,
}

/// The name of the outages among the inputs.
const OUTAGE: &str = "outage length";

/// How runs become points.
pub(super) struct Sampling {
    pub(super) inputs: Vec<Input>,
    /// Two columns for each input of the rows: its value as a number, and its position among the
    /// texts. Where it is the other of both, it is NaN.
    pub(super) values: Columns,
    /// The values of the last input, if they are one.
    pub(super) outages: Outages,
    pub(super) figures: usize,
    /// Number of replicates of each cell.
    pub(super) replicates: usize,
}

/// How many of the worst runs are always points.
const WORST: usize = 20;
/// Other texts of an input are not values.
const TEXTS: usize = 50;

/// Rows that are read from the log together.
pub(super) const PART: usize = 1 << 12;

impl Input {
    fn new(name: &str, unit: String, is_outage: bool) -> Self {
        Self { name: name.to_owned(), unit, texts: Vec::new(), is_outage }
    }

    /// A value as a number, and its position among the texts, which it may become one of.
    fn value(&mut self, text: &str) -> [f64; 2] {
        if let Ok(number) = text.parse() {
            return [number, f64::NAN];
        }
        let known = self.texts.iter().position(|known| known == text);
        let place = known.or_else(|| {
            (self.texts.len() < TEXTS).then(|| self.texts.push(text.to_owned()))?;
            Some(self.texts.len() - 1)
        });
        [f64::NAN, place.map_or(f64::NAN, |place| place as f64)]
    }
}

impl Sampling {
    /// Of the inputs of a campaign as in the rows, then of the outages; all replicates are points.
    pub(super) fn new(
        campaign: &Campaign,
        contents: &Contents,
        folder: &Path,
        outages: Outages,
        unit: impl Fn(&str) -> String,
    ) -> Result<Self> {
        let inputs = campaign.inputs().map(|name| Input::new(name, unit(name), false));
        let mut inputs: Vec<Input> = inputs.collect();
        let mut values = Columns::new(2 * inputs.len(), folder);
        let all: Vec<usize> = (0..contents.rows.runs().len()).collect();
        let parts = if inputs.is_empty() { all[..0].chunks(PART) } else { all.chunks(PART) };
        for part in parts {
            for row in contents.logged(part)? {
                let value = |(place, input): (usize, &mut Input)| {
                    row.inputs.get(place).map_or([f64::NAN; 2], |text| input.value(text))
                };
                let row: Vec<[f64; 2]> = inputs.iter_mut().enumerate().map(value).collect();
                values.push(row.into_flattened()).map_err(unkept)?;
            }
        }
        inputs.extend(outages.differ().then(|| Input::new(OUTAGE, "s".to_owned(), true)));
        let figures = campaign.summarized().len();
        Ok(Self { inputs, values, outages, figures, replicates: usize::MAX })
    }

    /// The values of an input in all rows: numbers, or positions of texts if any is no number.
    pub(super) fn column(&self, rows: &Rows, place: usize) -> Result<Vec<f64>> {
        let input = &self.inputs[place];
        if input.is_outage {
            return Ok(rows.runs().iter().map(|run| self.outages.length(*run)).collect());
        }
        self.values.column(2 * place + usize::from(!input.texts.is_empty())).map_err(unkept)
    }

    /// Those of a cell's simulated runs that are points.
    pub(super) fn points(
        &self,
        campaign: &Campaign,
        rows: &Rows,
        good: &[usize],
        main: &Main<'_>,
        shown: &[(u64, &str)],
    ) -> Vec<usize> {
        let mut wanted: HashSet<u64> = shown.iter().map(|(run, _)| *run).collect();
        if self.replicates > 0 {
            let mut worst = good.to_vec();
            let count = WORST.min(worst.len());
            if count < worst.len() {
                worst.select_nth_unstable_by(count, |a, b| main.worse(*a, *b));
            }
            wanted.extend(worst[..count].iter().map(|at| rows.runs()[*at]));
        }
        let is_point = |at: &usize| {
            let run = rows.runs()[*at];
            campaign.replicate_of(run) < self.replicates || wanted.contains(&run)
        };
        good.iter().copied().filter(is_point).collect()
    }

    /// For each cell: Spearman's rank correlation of a figure with each input, over all simulated
    /// runs.
    pub(super) fn sensitivity(
        &self,
        rows: &Rows,
        figure: &[f64],
        good: &[Vec<usize>],
    ) -> Result<Vec<Vec<f64>>> {
        let mut correlations = vec![Vec::new(); good.len()];
        for (place, input) in self.inputs.iter().enumerate() {
            let column = match input.texts.is_empty() {
                true => self.column(rows, place)?,
                false => vec![f64::NAN; figure.len()],
            };
            for (of_cell, good) in correlations.iter_mut().zip(good) {
                let pairs = good.iter().map(|at| (column[*at], figure[*at]));
                of_cell.push(rank_correlation(pairs));
            }
        }
        Ok(correlations)
    }
}

/// NaN for fewer than five pairs of numbers, or if either is constant.
fn rank_correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let known = |(a, b): &(f64, f64)| !a.is_nan() && !b.is_nan();
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.filter(known).unzip();
    if a.len() < 5 {
        return f64::NAN;
    }
    let (a, b) = (ranks(&a), ranks(&b));
    let middle = (a.len() - 1) as f64 / 2.0;
    let sum = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - middle) * (b - middle)).sum()
    };
    let spread = (sum(&a, &a) * sum(&b, &b)).sqrt();
    if spread > 0.0 { sum(&a, &b) / spread } else { f64::NAN }
}

/// Equal values share the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let (mut ranks, mut start) = (vec![0.0; values.len()], 0);
    for group in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let rank = start as f64 + (group.len() - 1) as f64 / 2.0;
        group.iter().for_each(|place| ranks[*place] = rank);
        start += group.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rank_correlations_are_those_of_scipy() {
        // scipy.stats.spearmanr
        let of =
            |a: &[f64; 6], b: &[f64; 6]| rank_correlation(a.iter().copied().zip(b.iter().copied()));
        let (a, b) = ([1.0, 2.0, 2.0, 4.0, 9.0, 7.0], [3.0, 1.0, 2.0, 8.0, 7.0, 7.0]);
        assert!((of(&a, &b) - 0.617_647_058_823_529_4).abs() < 1e-12);
        assert_eq!(of(&[1.0; 6], &b).to_string(), "NaN");
        let gaps = [f64::NAN, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(of(&gaps, &gaps), 1.0);
    }
}
