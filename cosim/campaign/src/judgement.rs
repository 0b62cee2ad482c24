//! Evaluates the rows of a campaign: figures of each cell, verdicts, differences between cells.

use std::collections::HashMap;

use serde::Serialize;

use super::file::OverTime;
use super::statistics::{Answer, Estimate, decide, quantile};
use super::{Campaign, Row, Status};
use cosim_base::names;
use cosim_report::{self as report, chi_square_quantile};

/// The result of the evaluation.
#[derive(Debug, Serialize)]
pub struct Judgement {
    /// Finished runs, and those among them that failed.
    pub runs: u64,
    /// How many of these have no figures.
    pub failed: u64,
    /// Figures of each cell.
    pub figures: Vec<FigureOfCell>,
    /// Thresholds in each cell.
    pub verdicts: Vec<Verdict>,
    /// Differences between the first replacement and the others, in pairs of runs with the same
    /// seeds.
    pub compared: Vec<Compared>,
    /// Normalised errors squared over time, averaged over the runs of a cell.
    pub consistency: Vec<Consistency>,
    /// Errors over time, with their claimed standard deviations.
    pub errors: Vec<Errors>,
}

/// The errors of the runs of a cell at an instant.
#[derive(Debug, Serialize)]
pub struct Errors {
    /// The cell.
    pub cell: String,
    /// The figure.
    pub figure: String,
    /// The instant (s).
    pub time: f64,
    /// Runs that reach it.
    pub runs: usize,
    /// The quantiles 5, 25, 50, 75 and 95 %.
    pub quantiles: [f64; 5],
    /// The median of the claimed standard deviations.
    pub sigma: f64,
}

/// The mean of a normalised error or innovation squared over the runs of a cell at an instant
/// (Bar-Shalom et al. 2001, section 5.4.2).
#[derive(Debug, Serialize)]
pub struct Consistency {
    /// The cell.
    pub cell: String,
    /// The figure.
    pub figure: String,
    /// The instant (s).
    pub time: f64,
    /// Runs that have it.
    pub runs: usize,
    /// The mean, which equals the number of axes if the filter is consistent.
    pub mean: f64,
    /// The interval that contains it with 95 % probability in that case: two-sided chi-square.
    pub band: [f64; 2],
}

/// A figure in a cell, with 95 % confidence.
#[derive(Debug, Serialize)]
pub struct FigureOfCell {
    /// The cell.
    pub cell: String,
    /// The figure.
    pub figure: String,
    /// Runs that have it.
    pub runs: usize,
    /// Its median.
    pub median: Estimate,
    /// Its 95th percentile.
    pub percentile_95: Estimate,
}

/// A threshold in a cell.
#[derive(Debug, Serialize)]
pub struct Verdict {
    /// The cell.
    pub cell: String,
    /// The figure.
    pub figure: String,
    /// The threshold as text.
    pub threshold: String,
    /// The verdict.
    pub answer: Answer,
    /// The quantile that is bounded, with its interval.
    pub quantile: Estimate,
    /// Finished runs of the cell, and how many of them meet the bound; a run without figures does
    /// not.
    pub runs: u64,
    /// How many meet the bound.
    pub kept: u64,
}

/// A figure of two replacements, run by run.
#[derive(Debug, Serialize)]
pub struct Compared {
    /// The cell of the first replacement.
    pub cell: String,
    /// The cell of the other one.
    pub with: String,
    /// The figure.
    pub figure: String,
    /// Pairs of runs.
    pub pairs: usize,
    /// The median of the other value minus the first.
    pub difference: Estimate,
}

const CONFIDENCE: f64 = 0.95;

impl Judgement {
    /// Evaluates all existing rows of a campaign; their order of arrival does not matter.
    pub fn new(campaign: &Campaign, rows: &[Row]) -> Self {
        let mut cells: Vec<Vec<&Row>> = vec![Vec::new(); campaign.cells()];
        let rows = rows.iter().filter(|row| row.run < campaign.runs());
        rows.clone().for_each(|row| cells[campaign.cell_of(row.run)].push(row));
        let mut judgement = Self {
            runs: rows.clone().count() as u64,
            failed: rows.filter(|row| row.status != Status::Ok).count() as u64,
            figures: Vec::new(),
            verdicts: Vec::new(),
            compared: Vec::new(),
            consistency: Vec::new(),
            errors: Vec::new(),
        };
        for (cell, rows) in cells.iter().enumerate() {
            let columns = columns(campaign, rows);
            let good: Vec<bool> = rows.iter().map(|row| row.status == Status::Ok).collect();
            for ((figure, _), column) in campaign.summarized().iter().zip(&columns) {
                let values = column.iter().zip(&good).filter(|(_, good)| **good);
                let values: Vec<f64> = values.map(|(value, _)| *value).collect();
                judgement.figures.push(FigureOfCell {
                    cell: campaign.cell_name(cell).to_owned(),
                    figure: figure.clone(),
                    runs: values.len(),
                    median: quantile(&values, 0.5, CONFIDENCE),
                    percentile_95: quantile(&values, 0.95, CONFIDENCE),
                });
            }
            judgement.verdicts.extend(verdicts(campaign, cell, &columns));
            judgement.compared.extend(compared(campaign, cell, &cells));
            judgement.consistency.extend(consistency(campaign, cell, &columns));
            judgement.errors.extend(errors(campaign, cell, &columns));
        }
        judgement
    }

    /// The cells with an undecided threshold, or without any threshold.
    pub fn open_cells(&self, campaign: &Campaign) -> Vec<usize> {
        let open = |cell: &usize| {
            let name = campaign.cell_name(*cell);
            let own: Vec<&Verdict> = self.verdicts.iter().filter(|v| v.cell == name).collect();
            own.is_empty() || own.iter().any(|v| matches!(v.answer, Answer::Undecided(_)))
        };
        (0..campaign.cells()).filter(open).collect()
    }

    /// Whether any verdict is this one.
    pub fn has(&self, wanted: impl Fn(&Answer) -> bool) -> bool {
        self.verdicts.iter().any(|verdict| wanted(&verdict.answer))
    }
}

/// For each figure, its values in these rows. Each row is visited once: rows are in different places
/// in memory.
fn columns(campaign: &Campaign, rows: &[&Row]) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::with_capacity(rows.len()); campaign.figures.len()];
    for row in rows {
        for (place, column) in columns.iter_mut().enumerate() {
            column.push(row.figure(place));
        }
    }
    columns
}

fn verdicts(campaign: &Campaign, cell: usize, columns: &[Vec<f64>]) -> Vec<Verdict> {
    let name = campaign.cell_name(cell);
    let own = campaign.verdicts.iter().filter(|t| names::matches(&t.cells, name));
    let verdict = |threshold: &super::file::Threshold| {
        let (least, most) = (threshold.least, threshold.most);
        let lowest = least.unwrap_or(f64::NEG_INFINITY);
        let keeps = |value: &f64| *value >= lowest && most.is_none_or(|most| *value <= most);
        // A run without figures counts as the worst possible.
        let worst = if most.is_some() { f64::INFINITY } else { f64::NEG_INFINITY };
        let values = columns[threshold.figure].iter();
        let values: Vec<f64> =
            values.map(|value| if value.is_nan() { worst } else { *value }).collect();
        let kept = values.iter().filter(|value| keeps(value)).count() as u64;
        // The quantile p is at most a bound if a share p of all is; at least, if 1 - p is.
        let p = threshold.quantile;
        let wanted = if most.is_some() { p } else { 1.0 - p };
        let sign = if most.is_some() { "at most" } else { "at least" };
        let bound = most.or(least).unwrap_or(f64::NAN);
        // Each check of the rows gets its share of the error probability (Bonferroni).
        let confidence = 1.0 - (1.0 - threshold.confidence) / campaign.looks().len() as f64;
        let what = if p == 0.5 { "median".to_owned() } else { format!("quantile {p}") };
        Verdict {
            cell: name.to_owned(),
            figure: campaign.figures[threshold.figure].0.clone(),
            threshold: format!("{what} {sign} {bound}"),
            answer: decide(kept, values.len() as u64, wanted, confidence),
            quantile: quantile(&values, p, confidence),
            runs: values.len() as u64,
            kept,
        }
    };
    own.map(verdict).collect()
}

/// The differences of a cell from the one with the first replacement and otherwise the same
/// factors.
fn compared(campaign: &Campaign, cell: usize, cells: &[Vec<&Row>]) -> Vec<Compared> {
    let own = &campaign.cells[cell];
    if own.replacement == 0 {
        return Vec::new();
    }
    let alike = |other: &&super::file::Cell| {
        let all = |c: &super::file::Cell| (c.system, c.scenario, c.levels.clone(), c.row);
        other.replacement == 0 && all(other) == all(own)
    };
    let Some(first) = campaign.cells.iter().find(alike) else { return Vec::new() };
    let Some(place) = campaign.cells.iter().position(|c| c == first) else { return Vec::new() };
    let others: HashMap<usize, &Row> =
        cells[place].iter().map(|row| (campaign.replicate_of(row.run), *row)).collect();
    let pairs = cells[cell]
        .iter()
        .filter_map(|row| Some((*row, *others.get(&campaign.replicate_of(row.run))?)));
    let (own_rows, other_rows): (Vec<&Row>, Vec<&Row>) = pairs.unzip();
    let (ours, theirs) = (columns(campaign, &own_rows), columns(campaign, &other_rows));
    let figures = campaign.summarized().iter().zip(ours.iter().zip(&theirs));
    let figures = figures.map(|((name, _), (ours, theirs))| {
        let differences = ours.iter().zip(theirs).map(|(own, other)| own - other);
        let differences: Vec<f64> = differences.filter(|value| !value.is_nan()).collect();
        Compared {
            cell: first.name.clone(),
            with: own.name.clone(),
            figure: name.clone(),
            pairs: differences.len(),
            difference: quantile(&differences, 0.5, CONFIDENCE),
        }
    });
    figures.collect()
}

/// Each instant of the figures over time: the figure, the time (s), and its position in the rows.
fn instants(campaign: &Campaign) -> impl Iterator<Item = (&OverTime, f64, usize)> {
    campaign.over_time.iter().flat_map(move |over| {
        let at = over.instants.iter();
        at.filter_map(move |place| Some((over, campaign.figures[*place].1.instant()?, *place)))
    })
}

/// The values of a figure in the runs that have it.
fn known(column: &[f64]) -> Vec<f64> {
    column.iter().copied().filter(|value| !value.is_nan()).collect()
}

fn consistency(campaign: &Campaign, cell: usize, columns: &[Vec<f64>]) -> Vec<Consistency> {
    let of = |(over, time, place): (&OverTime, f64, usize)| {
        let (axes, values) = (over.axes?, known(&columns[place]));
        let count = values.len() as f64;
        let freedom = count * axes as f64;
        let band = [0.025, 0.975].map(|p| chi_square_quantile(p, freedom) / count);
        let mean = values.iter().sum::<f64>() / count;
        let (cell, figure) = (campaign.cell_name(cell).to_owned(), over.figure.clone());
        Some(Consistency { cell, figure, time, runs: values.len(), mean, band })
    };
    instants(campaign).filter_map(of).collect()
}

fn errors(campaign: &Campaign, cell: usize, columns: &[Vec<f64>]) -> Vec<Errors> {
    let of = |(over, time, place): (&OverTime, f64, usize)| {
        let mut values = known(&columns[place]);
        values.sort_by(f64::total_cmp);
        Errors {
            cell: campaign.cell_name(cell).to_owned(),
            figure: over.figure.clone(),
            time,
            runs: values.len(),
            quantiles: [0.05, 0.25, 0.5, 0.75, 0.95]
                .map(|p| report::quantile_of_sorted(&values, p)),
            sigma: report::quantile(&known(&columns[place + 1]), 0.5),
        }
    };
    instants(campaign).filter(|(over, ..)| over.axes.is_none()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::row::Number;
    use super::*;

    /// Two replacements of 40 runs each: the second is worse by 1, and one of its runs fails.
    fn judged(thresholds: &str) -> Judgement {
        let text = format!(
            "seeds = 40\n[systems]\na = 'a.ssd'\n[replacements]\none = {{}}\n\
             two = {{ c = 'c.fmu' }}\n[figures.f]\nkind = 'max'\nof = 'x'\n{thresholds}"
        );
        let campaign = Campaign::parse(&text, Path::new("/c/c.toml")).unwrap();
        let mut rows: Vec<Row> = (0..campaign.runs())
            .map(|run| {
                let value = campaign.replicate_of(run) as f64 + campaign.cell_of(run) as f64;
                let mut row = Row::without_figures(run, Status::Ok, "");
                row.figures = [Number(value)].into();
                row
            })
            .collect();
        rows[1] = Row::without_figures(1, Status::Crashed, "ended by signal 11");
        rows.reverse();
        Judgement::new(&campaign, &rows)
    }

    #[test]
    fn verdicts_pass_fail_or_stay_open_and_a_failed_run_keeps_no_bound() {
        let judgement = judged(
            "[[verdict]]\nfigure = 'f'\nat-most = 35\n[[verdict]]\nfigure = 'f'\nat-most = 5\n\
             cells = '*two'\n[[verdict]]\nfigure = 'f'\nat-most = 22\ncells = '*/one'\n\
             [[verdict]]\nfigure = 'f'\nat-least = 40\nquantile = 0.9\ncells = '*two'\n",
        );
        let verdicts: Vec<(&str, Answer, u64)> =
            judgement.verdicts.iter().map(|v| (v.cell.as_str(), v.answer, v.kept)).collect();
        assert_eq!(verdicts[0], ("a/one", Answer::Pass, 36));
        assert!(
            matches!(verdicts[1], ("a/one", Answer::Undecided(Some(_)), 23)),
            "{:?}",
            verdicts[1]
        );
        assert_eq!(verdicts[2], ("a/two", Answer::Pass, 34));
        assert_eq!(verdicts[3], ("a/two", Answer::Fail, 4));
        assert!(matches!(verdicts[4], ("a/two", Answer::Undecided(_), 1)), "{:?}", verdicts[4]);
        assert_eq!((judgement.runs, judgement.failed), (80, 1));
    }

    #[test]
    fn errors_over_time_are_quantiles_of_the_runs_that_reach_an_instant() {
        let text = "seeds = 101\nstop-time = 2\n[systems]\na = 'a.ssd'\n[figures.f]\nkind = 'error'\n\
                    of = 'x'\nsigma = 's'\nevery = 1\n[figures.g]\nkind = 'max'\nof = 'x'\n";
        let campaign = Campaign::parse(text, Path::new("/c/c.toml")).unwrap();
        let names: Vec<&str> = campaign.figures().collect();
        assert_eq!(names, ["f", "g", "f@1", "f.sigma@1", "f@2", "f.sigma@2"]);
        let row = |run: u64| {
            let mut row = Row::without_figures(run, Status::Ok, "");
            let late = if run < 100 { f64::NAN } else { 7.0 };
            let values = [0.0, 0.0, run as f64 - 50.0, 0.1 * run as f64, late, late];
            row.figures = values.map(Number).into();
            row
        };
        let rows: Vec<Row> = (0..101).map(row).collect();
        let judgement = Judgement::new(&campaign, &rows);
        let [first, second] = &judgement.errors[..] else { panic!() };
        assert_eq!((first.time, first.runs, first.sigma), (1.0, 101, 5.0));
        assert_eq!(first.quantiles, [-45.0, -25.0, 0.0, 25.0, 45.0]);
        assert_eq!((second.time, second.runs, second.quantiles), (2.0, 1, [7.0; 5]));
        assert!(judgement.consistency.is_empty());
        assert_eq!(judgement.figures.len(), 2);
    }

    #[test]
    fn replacements_are_compared_run_by_run() {
        let judgement = judged("");
        let [compared] = &judgement.compared[..] else { panic!() };
        assert_eq!((compared.pairs, compared.difference.value), (39, 1.0));
        assert_eq!(compared.difference.interval, [1.0, 1.0]);
        assert_eq!(judgement.figures[0].median.value, 19.5);
    }
}
