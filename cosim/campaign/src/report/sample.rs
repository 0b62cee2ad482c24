//! Runs as points, and the parameters that figures depend on.

use std::collections::HashSet;

use serde::Serialize;

use super::Main;
use super::outage::Outages;
use crate::{Campaign, Row, Status};
use cosim_report::Numbers;

/// Some runs of a cell, column by column: the first replicates, which are the same in all cells,
/// the worst, and those that are shown in full.
#[derive(Serialize)]
pub(super) struct Sample {
    run: Vec<u64>,
    /// For each figure.
    figures: Vec<Numbers>,
    /// For each input.
    inputs: Vec<Numbers>,
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

impl Input {
    /// The inputs of a campaign as in the rows, then the outages.
    pub(super) fn of_all(
        campaign: &Campaign,
        rows: &[Row],
        outages: &Outages,
        unit: impl Fn(&str) -> String,
    ) -> Vec<Self> {
        let input = |(place, name): (usize, &str)| {
            let mut texts: Vec<String> = Vec::new();
            for text in rows.iter().filter_map(|row| row.inputs.get(place)) {
                if text.parse::<f64>().is_err()
                    && !texts.iter().any(|known| **known == **text)
                    && texts.len() < TEXTS
                {
                    texts.push(text.to_string());
                }
            }
            Self { name: name.to_owned(), unit: unit(name), texts, is_outage: false }
        };
        let outage = || Self {
            name: OUTAGE.to_owned(),
            unit: "s".to_owned(),
            texts: Vec::new(),
            is_outage: true,
        };
        let inputs = campaign.inputs().enumerate().map(input);
        inputs.chain(outages.differ().then(outage)).collect()
    }

    fn value(&self, place: usize, row: &Row, outages: &Outages) -> f64 {
        if self.is_outage {
            return outages.length(row.run);
        }
        let Some(text) = row.inputs.get(place) else { return f64::NAN };
        if self.texts.is_empty() {
            return text.parse().unwrap_or(f64::NAN);
        }
        self.texts.iter().position(|known| **known == **text).map_or(f64::NAN, |place| place as f64)
    }
}

impl Sampling {
    pub(super) fn sample(
        &self,
        campaign: &Campaign,
        rows: &[&Row],
        main: &Main,
        shown: &[(u64, &str)],
    ) -> Sample {
        let good = || rows.iter().copied().filter(|row| row.status == Status::Ok);
        let mut wanted: HashSet<u64> = shown.iter().map(|(run, _)| *run).collect();
        if self.replicates > 0 {
            let mut worst: Vec<&Row> = good().collect();
            let count = WORST.min(worst.len());
            if count < worst.len() {
                worst.select_nth_unstable_by(count, |a, b| main.worse(a, b));
            }
            wanted.extend(worst[..count].iter().map(|row| row.run));
        }
        let first = |row: &Row| campaign.replicate_of(row.run) < self.replicates;
        let chosen = good().filter(|row| first(row) || wanted.contains(&row.run));
        let chosen: Vec<&Row> = chosen.collect();
        let column =
            |value: &dyn Fn(&Row) -> f64| Numbers::values(chosen.iter().map(|row| value(row)));
        let inputs = self.inputs.iter().enumerate();
        Sample {
            run: chosen.iter().map(|row| row.run).collect(),
            figures: (0..self.figures).map(|f| column(&|row| row.figure(f))).collect(),
            inputs: inputs
                .map(|(place, input)| column(&|row| input.value(place, row, &self.outages)))
                .collect(),
        }
    }

    /// Spearman's rank correlation of each figure with each input, over all runs.
    pub(super) fn sensitivity(&self, rows: &[&Row]) -> Vec<Numbers> {
        let good: Vec<&Row> = rows.iter().copied().filter(|row| row.status == Status::Ok).collect();
        let inputs: Vec<Vec<f64>> = self
            .inputs
            .iter()
            .enumerate()
            .filter(|(_, input)| input.texts.is_empty())
            .map(|(place, input)| {
                good.iter().map(|row| input.value(place, row, &self.outages)).collect()
            })
            .collect();
        let numeric: Vec<bool> = self.inputs.iter().map(|input| input.texts.is_empty()).collect();
        let figure = |figure: usize| {
            let values: Vec<f64> = good.iter().map(|row| row.figure(figure)).collect();
            let mut of = inputs.iter();
            let correlations = numeric.iter().map(|numeric| {
                let input = if *numeric { of.next() } else { None };
                input.map_or(f64::NAN, |input| rank_correlation(input, &values))
            });
            Numbers::values(correlations.collect::<Vec<_>>())
        };
        (0..self.figures).map(figure).collect()
    }
}

/// NaN for fewer than five pairs of numbers, or if either is constant.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let known = |(a, b): &(&f64, &f64)| !a.is_nan() && !b.is_nan();
    let (a, b): (Vec<f64>, Vec<f64>) = a.iter().zip(b).filter(known).unzip();
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
        let (a, b) = ([1.0, 2.0, 2.0, 4.0, 9.0, 7.0], [3.0, 1.0, 2.0, 8.0, 7.0, 7.0]);
        assert!((rank_correlation(&a, &b) - 0.617_647_058_823_529_4).abs() < 1e-12);
        assert_eq!(rank_correlation(&[1.0; 6], &b).to_string(), "NaN");
        let gaps = [f64::NAN, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(rank_correlation(&gaps, &gaps), 1.0);
    }
}
