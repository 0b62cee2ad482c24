//! Evaluates the rows of a campaign: figures of each cell, verdicts, differences between cells.

use serde::Serialize;

use super::Campaign;
use super::file::{Cell, Threshold};
use super::rows::{Rows, ordered, pairs};
use super::statistics::{Answer, Estimate, decide, quantile};
use cosim_base::error::Result;
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
    pub fn new(campaign: &Campaign, rows: &Rows) -> Result<Self> {
        Self::until(campaign, rows, campaign.runs())
    }

    /// Evaluates the existing rows of the first runs: those below this number.
    pub fn until(campaign: &Campaign, rows: &Rows, until: u64) -> Result<Self> {
        let cells = rows.by_cell(campaign, until);
        let runs: usize = cells.iter().map(Vec::len).sum();
        let failed = cells.iter().flatten().filter(|at| !rows.is_good(**at)).count();
        let (figures, compared) = figures(campaign, rows, &cells)?;
        let (consistency, errors) = over_time(campaign, rows, &cells)?;
        Ok(Self {
            runs: runs as u64,
            failed: failed as u64,
            figures,
            verdicts: verdicts(campaign, rows, &cells)?,
            compared,
            consistency,
            errors,
        })
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

/// The values of these rows in a column.
fn of(column: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|at| column[*at]).collect()
}

/// All figures, and their differences between replacements.
fn figures(
    campaign: &Campaign,
    rows: &Rows,
    cells: &[Vec<usize>],
) -> Result<(Vec<FigureOfCell>, Vec<Compared>)> {
    let pairs: Vec<_> = (0..cells.len()).map(|cell| paired(campaign, rows, cell, cells)).collect();
    let (mut figures, mut compared) = (Vec::new(), Vec::new());
    for (place, (figure, _)) in campaign.summarized().iter().enumerate() {
        let column = rows.figure(place)?;
        for (cell, own) in cells.iter().enumerate() {
            let good = own.iter().filter(|at| rows.is_good(**at));
            let values: Vec<f64> = good.map(|at| column[*at]).collect();
            let summary = FigureOfCell {
                cell: campaign.cell_name(cell).to_owned(),
                figure: figure.clone(),
                runs: values.len(),
                median: quantile(&values, 0.5, CONFIDENCE),
                percentile_95: quantile(&values, 0.95, CONFIDENCE),
            };
            figures.push((cell, summary));
            let Some((first, pairs)) = &pairs[cell] else { continue };
            let differences = pairs.iter().map(|(own, other)| column[*own] - column[*other]);
            let differences: Vec<f64> = differences.filter(|value| !value.is_nan()).collect();
            let difference = Compared {
                cell: campaign.cell_name(*first).to_owned(),
                with: campaign.cell_name(cell).to_owned(),
                figure: figure.clone(),
                pairs: differences.len(),
                difference: quantile(&differences, 0.5, CONFIDENCE),
            };
            compared.push((cell, difference));
        }
    }
    Ok((ordered(figures), ordered(compared)))
}

/// The cell with the first replacement and otherwise the same factors, and the pairs of rows of a
/// cell and that one; `None` for the first one itself.
fn paired(
    campaign: &Campaign,
    rows: &Rows,
    cell: usize,
    cells: &[Vec<usize>],
) -> Option<(usize, Vec<(usize, usize)>)> {
    let own = &campaign.cells[cell];
    let alike = |other: &Cell| {
        let all = |c: &Cell| (c.system, c.scenario, c.levels.clone(), c.row);
        other.replacement == 0 && all(other) == all(own)
    };
    let first = campaign.cells.iter().position(alike).filter(|_| own.replacement != 0)?;
    let replicate = |at: usize| campaign.replicate_of(rows.runs()[at]);
    Some((first, pairs(&cells[cell], &cells[first], replicate, replicate)))
}

fn verdicts(campaign: &Campaign, rows: &Rows, cells: &[Vec<usize>]) -> Result<Vec<Verdict>> {
    let mut verdicts = Vec::new();
    for threshold in &campaign.verdicts {
        let column = rows.figure(threshold.figure)?;
        for (cell, own) in cells.iter().enumerate() {
            let name = campaign.cell_name(cell);
            if names::matches(&threshold.cells, name) {
                verdicts.push((cell, verdict(campaign, threshold, name, of(&column, own))));
            }
        }
    }
    Ok(ordered(verdicts))
}

/// The verdict on the values of a figure in a cell.
fn verdict(campaign: &Campaign, threshold: &Threshold, cell: &str, values: Vec<f64>) -> Verdict {
    let (least, most) = (threshold.least, threshold.most);
    let lowest = least.unwrap_or(f64::NEG_INFINITY);
    let keeps = |value: &f64| *value >= lowest && most.is_none_or(|most| *value <= most);
    // A run without figures counts as the worst possible.
    let worst = if most.is_some() { f64::INFINITY } else { f64::NEG_INFINITY };
    let counts = |value: f64| if value.is_nan() { worst } else { value };
    let values: Vec<f64> = values.into_iter().map(counts).collect();
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
        cell: cell.to_owned(),
        figure: campaign.figures[threshold.figure].0.clone(),
        threshold: format!("{what} {sign} {bound}"),
        answer: decide(kept, values.len() as u64, wanted, confidence),
        quantile: quantile(&values, p, confidence),
        runs: values.len() as u64,
        kept,
    }
}

/// Figures at single instants: normalised errors squared, and errors.
fn over_time(
    campaign: &Campaign,
    rows: &Rows,
    cells: &[Vec<usize>],
) -> Result<(Vec<Consistency>, Vec<Errors>)> {
    let (mut consistent, mut errors) = (Vec::new(), Vec::new());
    let all = campaign.over_time.iter();
    for (over, place) in all.flat_map(|over| over.instants.iter().map(move |place| (over, *place)))
    {
        let Some(time) = campaign.figures[place].1.instant() else { continue };
        let column = rows.figure(place)?;
        // The claimed deviation of an error follows it.
        let claimed = if over.axes.is_none() { rows.figure(place + 1)? } else { Vec::new() };
        for (cell, own) in cells.iter().enumerate() {
            let (name, figure) = (campaign.cell_name(cell).to_owned(), over.figure.clone());
            let values = known(of(&column, own));
            match over.axes {
                Some(axes) => {
                    consistent.push((cell, consistency(name, figure, time, axes, &values)))
                }
                None => {
                    let claimed = known(of(&claimed, own));
                    errors.push((cell, errors_at(name, figure, time, values, &claimed)));
                }
            }
        }
    }
    Ok((ordered(consistent), ordered(errors)))
}

/// The values of a figure in the runs that have it.
fn known(mut values: Vec<f64>) -> Vec<f64> {
    values.retain(|value| !value.is_nan());
    values
}

fn consistency(
    cell: String,
    figure: String,
    time: f64,
    axes: usize,
    values: &[f64],
) -> Consistency {
    let count = values.len() as f64;
    let freedom = count * axes as f64;
    let band = [0.025, 0.975].map(|p| chi_square_quantile(p, freedom) / count);
    let mean = values.iter().sum::<f64>() / count;
    Consistency { cell, figure, time, runs: values.len(), mean, band }
}

fn errors_at(
    cell: String,
    figure: String,
    time: f64,
    mut values: Vec<f64>,
    claimed: &[f64],
) -> Errors {
    values.sort_by(f64::total_cmp);
    Errors {
        cell,
        figure,
        time,
        runs: values.len(),
        quantiles: [0.05, 0.25, 0.5, 0.75, 0.95].map(|p| report::quantile_of_sorted(&values, p)),
        sigma: report::quantile(claimed, 0.5),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{Number, Row, Status};

    fn judge(campaign: &Campaign, all: &[Row]) -> Judgement {
        let mut rows = Rows::new(campaign.figures.len(), Path::new("/nowhere"));
        all.iter().for_each(|row| rows.push(0, &row.clone().into()).unwrap());
        Judgement::new(campaign, &rows).unwrap()
    }

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
        judge(&campaign, &rows)
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
        let judgement = judge(&campaign, &rows);
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
