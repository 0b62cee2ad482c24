//! The part of the page for each cell.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use serde::Serialize;

use super::outage::Outage;
use super::sample::{PART, Sample, Sampling};
use crate::judgement::{self, Compared, Judgement, Verdict};
use crate::statistics::Estimate;
use crate::{Answer, Campaign, Contents, Rows};
use cosim_base::error::Result;
use cosim_report::{Numbers, chi_square_quantile, mean, quantile_of_sorted};

/// A cell on the page.
#[derive(Serialize)]
pub(super) struct Cell<'a> {
    pub(super) name: &'a str,
    /// Run `n` belongs to it if `n` modulo the number of all cells is this.
    place: usize,
    /// Position in the matrix.
    row: String,
    column: String,
    scenario: &'a str,
    /// Values of the factors and the list.
    levels: Vec<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    outage: Option<Outage>,
    runs: usize,
    failed: usize,
    figures: Vec<Figure>,
    pub(super) verdicts: Vec<&'a Verdict>,
    compared: Vec<&'a Compared>,
    /// Means over the runs of normalised errors squared, over time.
    over_time: Vec<OverTime<'a>>,
    /// Errors over time.
    errors: Vec<Errors<'a>>,
    /// For each figure and input: Spearman's rank correlation; null if it is meaningless.
    sensitivity: Vec<Numbers>,
    failures: Vec<Failure>,
    sample: Sample,
    /// Runs that are shown in full.
    pub(super) shown: Vec<ShownRun>,
    /// Those that were chosen for it, and why.
    #[serde(skip)]
    pub(super) chosen: Vec<(u64, &'static str)>,
}

/// A figure over time, and its 95 % interval if the filter is consistent.
#[derive(Serialize)]
struct OverTime<'a> {
    figure: &'a str,
    t: Numbers,
    mean: Numbers,
    low: Numbers,
    high: Numbers,
}

/// An error over time: its quantiles over the runs (5, 25, 50, 75, 95 %), and three times the median
/// of the claimed standard deviations.
#[derive(Serialize)]
struct Errors<'a> {
    figure: &'a str,
    t: Numbers,
    quantiles: [Numbers; 5],
    three_sigma: Numbers,
}

/// A figure in a cell.
#[derive(Serialize)]
struct Figure {
    /// Runs that have it, and those in which it is not a finite number.
    runs: usize,
    infinite: usize,
    mean: f64,
    median: Estimate,
    percentile_95: Estimate,
    /// Its quantiles in 40 equal parts of all runs.
    quantiles: Numbers,
    #[serde(skip_serializing_if = "Option::is_none")]
    consistency: Option<Consistency>,
}

/// How a mean over runs compares with the chi-square interval.
#[derive(Serialize)]
struct Consistency {
    freedom: usize,
    low: f64,
    high: f64,
}

/// Runs that failed for the same reason.
#[derive(Serialize)]
struct Failure {
    status: &'static str,
    reason: String,
    count: usize,
    /// The first of them.
    runs: Vec<u64>,
}

/// A run that is shown, or why it is not.
#[derive(Serialize)]
pub(super) struct ShownRun {
    pub(super) run: u64,
    pub(super) why: &'static str,
    pub(super) digest: String,
    pub(super) problem: Option<String>,
}

/// The data from which all cells are made.
pub(super) struct Source<'a> {
    pub(super) campaign: &'a Campaign,
    pub(super) judgement: &'a Judgement,
    pub(super) contents: &'a Contents,
    /// For each cell: its rows in the order of their numbers.
    pub(super) rows: Vec<Vec<usize>>,
    /// For each figure.
    pub(super) freedom: Vec<Option<usize>>,
    /// The figure by which runs are ordered.
    pub(super) main: Main<'a>,
    /// How many runs of a cell are shown in full.
    pub(super) runs_per_cell: usize,
    /// Other runs that are shown in full.
    pub(super) also: &'a [u64],
}

impl<'a> Source<'a> {
    /// All cells, with some runs as points.
    pub(super) fn cells(&self, sampling: &Sampling) -> Result<Vec<Cell<'a>>> {
        let rows = &self.contents.rows;
        let mut cells: Vec<Cell<'a>> =
            (0..self.rows.len()).map(|cell| self.cell(cell, sampling)).collect::<Result<_>>()?;
        let good: Vec<Vec<usize>> = self.rows.iter().map(|rows| self.good(rows)).collect();
        let points: Vec<Vec<usize>> = cells
            .iter()
            .zip(&good)
            .map(|(cell, good)| {
                sampling.points(self.campaign, rows, good, &self.main, &cell.chosen)
            })
            .collect();
        let of = |column: &[f64], at: &[usize]| -> Vec<f64> {
            at.iter().map(|at| column[*at]).collect()
        };
        for figure in 0..self.campaign.summarized().len() {
            let column = rows.figure(figure)?;
            for (place, cell) in cells.iter_mut().enumerate() {
                cell.figures.push(self.figure(place, figure, &of(&column, &good[place])));
                cell.sample.figures.push(Numbers::values(of(&column, &points[place])));
            }
            let correlations = sampling.sensitivity(rows, &column, &good)?;
            for (cell, of_cell) in cells.iter_mut().zip(correlations) {
                cell.sensitivity.push(Numbers::values(of_cell));
            }
        }
        for input in 0..sampling.inputs.len() {
            let column = sampling.column(rows, input)?;
            for (cell, points) in cells.iter_mut().zip(&points) {
                cell.sample.inputs.push(Numbers::values(of(&column, points)));
            }
        }
        for (cell, points) in cells.iter_mut().zip(&points) {
            cell.sample.run = points.iter().map(|at| rows.runs()[*at]).collect();
        }
        Ok(cells)
    }

    fn good(&self, rows: &[usize]) -> Vec<usize> {
        rows.iter().copied().filter(|at| self.contents.rows.is_good(*at)).collect()
    }

    /// A cell without its figures and points.
    fn cell(&self, cell: usize, sampling: &Sampling) -> Result<Cell<'a>> {
        let campaign = self.campaign;
        let (own, name) = (&campaign.cells[cell], campaign.cell_name(cell));
        let (row, column) = self.place(cell);
        let levels = campaign.factors.iter().zip(&own.levels);
        let levels = levels.map(|((_, values), level)| values[*level].as_str());
        let listed = own.row.iter().flat_map(|row| campaign.list.rows[*row].iter());
        let rows = &self.rows[cell];
        let (good, mut failed) = (self.good(rows), rows.clone());
        failed.retain(|at| !self.contents.rows.is_good(*at));
        let also = self.also.iter().filter(|run| campaign.cell_of(**run) == cell);
        let also: Vec<u64> = also.copied().collect();
        let runs = rows.iter().map(|at| self.contents.rows.runs()[*at]);
        Ok(Cell {
            name,
            place: cell,
            row,
            column,
            scenario: &campaign.scenarios[own.scenario].0,
            levels: levels.chain(listed.map(String::as_str)).collect(),
            outage: sampling.outages.of_cell(cell, runs),
            runs: rows.len(),
            failed: failed.len(),
            figures: Vec::new(),
            verdicts: self.judgement.verdicts.iter().filter(|v| v.cell == name).collect(),
            compared: self.judgement.compared.iter().filter(|c| c.with == name).collect(),
            over_time: self.over_time(cell),
            errors: self.errors(cell),
            sensitivity: Vec::new(),
            failures: failures(self.contents, &failed)?,
            sample: Sample::default(),
            shown: Vec::new(),
            chosen: self.main.choose(&good, self.runs_per_cell, &also),
        })
    }

    /// Row and column of a cell in the matrix: columns are the alternatives that are compared, in
    /// most campaigns filters; rows are the conditions under which they are compared.
    fn place(&self, cell: usize) -> (String, String) {
        let (campaign, own) = (self.campaign, &self.campaign.cells[cell]);
        let mut column = campaign.replacements[own.replacement].name.clone();
        if campaign.systems.len() > 1 || column.is_empty() {
            let system = &campaign.systems[own.system].0;
            column =
                if column.is_empty() { system.clone() } else { format!("{system} / {column}") };
        }
        let row = campaign.conditions(own);
        let row = if row.is_empty() { "all runs".to_owned() } else { row.join(", ") };
        (row, column)
    }

    /// The entries of a cell in a list with the same number of entries for each.
    fn own<T>(&self, of: &'a [T], cell: usize) -> &'a [T] {
        let count = of.len() / self.campaign.cells();
        &of[cell * count..(cell + 1) * count]
    }

    fn over_time(&self, cell: usize) -> Vec<OverTime<'a>> {
        let own = self.own(&self.judgement.consistency, cell);
        let figures = own.chunk_by(|a, b| a.figure == b.figure).map(|over| OverTime {
            figure: &over[0].figure,
            t: Numbers::times(over.iter().map(|at| at.time)),
            mean: Numbers::values(over.iter().map(|at| at.mean)),
            low: Numbers::values(over.iter().map(|at| at.band[0])),
            high: Numbers::values(over.iter().map(|at| at.band[1])),
        });
        figures.collect()
    }

    fn errors(&self, cell: usize) -> Vec<Errors<'a>> {
        // After all runs have ended there is nothing.
        let own = self.own(&self.judgement.errors, cell).iter().filter(|at| at.runs > 0);
        let own: Vec<&judgement::Errors> = own.collect();
        let figures = own.chunk_by(|a, b| a.figure == b.figure).map(|over| Errors {
            figure: &over[0].figure,
            t: Numbers::times(over.iter().map(|at| at.time)),
            quantiles: [0, 1, 2, 3, 4]
                .map(|place| Numbers::values(over.iter().map(|at| at.quantiles[place]))),
            three_sigma: Numbers::values(over.iter().map(|at| 3.0 * at.sigma)),
        });
        figures.collect()
    }

    fn figure(&self, cell: usize, figure: usize, values: &[f64]) -> Figure {
        let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        finite.sort_by(f64::total_cmp);
        let judged = &self.judgement.figures[cell * self.campaign.summarized().len() + figure];
        let parts = if finite.is_empty() { 0 } else { 41 };
        let quantiles = (0..parts).map(|part| quantile_of_sorted(&finite, f64::from(part) / 40.0));
        let consistency = self.freedom[figure].filter(|_| !finite.is_empty()).map(|freedom| {
            // The mean over this many independent runs, times their number, is chi-square
            // distributed.
            let (count, all) = (finite.len() as f64, (finite.len() * freedom) as f64);
            let bound = |p| chi_square_quantile(p, all) / count;
            Consistency { freedom, low: bound(0.025), high: bound(0.975) }
        });
        Figure {
            runs: values.len(),
            infinite: values.len() - finite.len(),
            mean: mean(&finite),
            median: judged.median,
            percentile_95: judged.percentile_95,
            quantiles: Numbers::values(quantiles),
            consistency,
        }
    }
}

/// The figure by which runs are ordered.
pub(super) struct Main<'a> {
    pub(super) figure: usize,
    /// How bad each run is.
    badness: Vec<f64>,
    runs: &'a [u64],
}

impl<'a> Main<'a> {
    /// The figure of the first threshold, otherwise the first one.
    pub(super) fn of(campaign: &Campaign, rows: &'a Rows) -> Result<Self> {
        // A threshold may also be on a figure at an instant, which is not shown.
        let mut bounded = campaign.verdicts.iter().map(|threshold| threshold.figure);
        let figure = bounded.find(|place| *place < campaign.summarized().len()).unwrap_or(0);
        let mut badness = rows.figure(figure)?;
        let small_is_bad = small_is_bad(campaign, figure);
        for value in &mut badness {
            // What is not a number counts as the worst.
            *value = match *value {
                value if value.is_nan() => f64::INFINITY,
                value if small_is_bad => -value,
                value => value,
            };
        }
        Ok(Self { figure, badness, runs: rows.runs() })
    }

    /// The order from the worst run on.
    pub(super) fn worse(&self, a: usize, b: usize) -> Ordering {
        self.badness[b].total_cmp(&self.badness[a]).then(self.runs[a].cmp(&self.runs[b]))
    }

    /// Runs to show, of those that were simulated: the worst, the median, then others evenly spaced
    /// between them, and `also`.
    pub(super) fn choose(
        &self,
        good: &[usize],
        count: usize,
        also: &[u64],
    ) -> Vec<(u64, &'static str)> {
        let mut good = good.to_vec();
        good.sort_by(|a, b| self.worse(*a, *b));
        let last = match good.len() {
            0 => return Vec::new(),
            length => length - 1,
        };
        let mut chosen: Vec<(u64, &'static str)> = Vec::new();
        let even = (1..count).map(|i| (i * last / (count - 1), "between"));
        for (place, why) in [(0, "worst"), (last.div_ceil(2), "median")].into_iter().chain(even) {
            let run = self.runs[good[place]];
            if chosen.len() < count && chosen.iter().all(|(known, _)| *known != run) {
                chosen.push((run, why));
            }
        }
        let made = |run: &&u64| good.iter().any(|at| self.runs[*at] == **run);
        for run in also.iter().filter(made) {
            if chosen.iter().all(|(known, _)| known != run) {
                chosen.push((*run, "chosen"));
            }
        }
        chosen
    }
}

/// Whether the first threshold of a figure is a lower bound.
pub(super) fn small_is_bad(campaign: &Campaign, figure: usize) -> bool {
    let first = campaign.verdicts.iter().find(|threshold| threshold.figure == figure);
    first.is_some_and(|threshold| threshold.least.is_some())
}

fn failures(contents: &Contents, failed: &[usize]) -> Result<Vec<Failure>> {
    const KINDS: usize = 20;
    let mut kinds: BTreeMap<(&str, Box<str>), Failure> = BTreeMap::new();
    for part in failed.chunks(PART) {
        for row in contents.logged(part)? {
            let (status, count) = (row.status.word(), 0);
            let reason: String = row.reason.chars().take(300).collect();
            let new = || Failure { status, reason, count, runs: Vec::new() };
            let failure = kinds.entry((status, row.reason)).or_insert_with(new);
            failure.count += 1;
            if failure.runs.len() < 5 {
                failure.runs.push(row.run);
            }
        }
    }
    let mut failures: Vec<Failure> = kinds.into_values().collect();
    failures.sort_by_key(|failure| std::cmp::Reverse(failure.count));
    failures.truncate(KINDS);
    Ok(failures)
}

/// The worst come first if there is not enough space for all cells.
pub(super) fn urgency(cell: &Cell<'_>) -> u8 {
    let has = |wanted: fn(&Answer) -> bool| cell.verdicts.iter().any(|v| wanted(&v.answer));
    if has(|answer| *answer == Answer::Fail) {
        0
    } else if has(|answer| matches!(answer, Answer::Undecided(_))) {
        1
    } else {
        2
    }
}
