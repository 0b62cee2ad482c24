//! The rows of a campaign, as many as there are, in little memory: how each run ended, where its
//! line is in the log, and its figures as columns. All else is read from the log when it is needed.

use std::path::Path;

use super::columns::Columns;
use super::row::Number;
use super::{Campaign, Row, Status};
use cosim_base::error::{Code, Error, Result};

/// Rows, in order of arrival.
pub struct Rows {
    runs: Vec<u64>,
    statuses: Vec<Status>,
    places: Vec<u64>,
    figures: Columns,
}

/// What is kept of a row.
pub(super) struct Kept {
    run: u64,
    status: Status,
    figures: Box<[Number]>,
}

impl From<Row> for Kept {
    fn from(row: Row) -> Self {
        Self { run: row.run, status: row.status, figures: row.figures }
    }
}

impl Rows {
    /// No rows yet, of so many figures; these may be kept in a file in this folder.
    pub(super) fn new(figures: usize, folder: &Path) -> Self {
        let figures = Columns::new(figures, folder);
        Self { runs: Vec::new(), statuses: Vec::new(), places: Vec::new(), figures }
    }

    /// Adds a row, whose line begins at this octet of the log.
    pub(super) fn push(&mut self, place: u64, row: &Kept) -> Result<()> {
        self.runs.push(row.run);
        self.statuses.push(row.status);
        self.places.push(place);
        let figure = |place: usize| row.figures.get(place).map_or(f64::NAN, |number| number.0);
        let figures = (0..self.figures.width).map(figure);
        self.figures.push(figures).map_err(unkept)
    }

    /// The numbers of their runs.
    pub fn runs(&self) -> &[u64] {
        &self.runs
    }

    /// For each of the first runs whether it has a row.
    pub fn made(&self, runs: u64) -> Vec<bool> {
        let mut made = vec![false; runs as usize];
        for run in self.runs.iter().filter(|run| **run < runs) {
            made[*run as usize] = true;
        }
        made
    }

    /// How the run of a row ended.
    pub(super) fn status(&self, at: usize) -> Status {
        self.statuses[at]
    }

    /// Whether the run of a row was simulated.
    pub(super) fn is_good(&self, at: usize) -> bool {
        self.statuses[at] == Status::Ok
    }

    /// Where the lines of these rows are in the log.
    pub(super) fn places(&self, rows: &[usize]) -> Vec<u64> {
        rows.iter().map(|at| self.places[*at]).collect()
    }

    /// A figure of all rows; NaN where there is none.
    pub(super) fn figure(&self, place: usize) -> Result<Vec<f64>> {
        if place >= self.figures.width {
            return Ok(vec![f64::NAN; self.runs.len()]);
        }
        self.figures.column(place).map_err(unkept)
    }

    /// The same of these rows.
    pub(super) fn figure_of(&self, place: usize, rows: &[usize]) -> Result<Vec<f64>> {
        self.figures.of(place, rows.iter().copied()).map_err(unkept)
    }

    /// The positions of the rows of runs below `until`, in the order of these. A run counts once,
    /// with its first row.
    pub(super) fn in_order(&self, until: u64) -> Vec<usize> {
        let mut order = Vec::with_capacity(self.runs.len());
        order.extend((0..self.runs.len()).filter(|at| self.runs[*at] < until));
        order.sort_unstable_by_key(|at| (self.runs[*at], *at));
        order.dedup_by_key(|at| self.runs[*at]);
        order
    }

    /// The same for each cell.
    pub(super) fn by_cell(&self, campaign: &Campaign, until: u64) -> Vec<Vec<usize>> {
        let order = self.in_order(until.min(campaign.runs()));
        let alike = order.len().div_ceil(campaign.cells());
        let mut cells: Vec<_> = (0..campaign.cells()).map(|_| Vec::with_capacity(alike)).collect();
        for at in order {
            cells[campaign.cell_of(self.runs[at])].push(at);
        }
        cells
    }
}

/// An error of the file with numbers.
pub(super) fn unkept(why: std::io::Error) -> Error {
    Error::new(Code::Output, "the figures of the runs cannot be kept")
        .why(why)
        .help("free some space where the results are")
}

/// The elements of two lists that have the same key; both are in the order of their keys.
pub(super) fn pairs<K: Ord>(
    ours: &[usize],
    theirs: &[usize],
    key: impl Fn(usize) -> K,
    their_key: impl Fn(usize) -> K,
) -> Vec<(usize, usize)> {
    let mut theirs = theirs.iter().copied().peekable();
    let pair = |own: &usize| {
        let wanted = key(*own);
        while theirs.next_if(|other| their_key(*other) < wanted).is_some() {}
        theirs.next_if(|other| their_key(*other) == wanted).map(|other| (*own, other))
    };
    let mut pairs = Vec::with_capacity(ours.len());
    pairs.extend(ours.iter().filter_map(pair));
    pairs
}

/// What was made in another order, with its place in this one.
pub(super) fn ordered<T>(mut made: Vec<(usize, T)>) -> Vec<T> {
    made.sort_by_key(|(place, _)| *place);
    made.into_iter().map(|(_, of)| of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_counts_once_with_its_first_row_whatever_the_order_of_arrival() {
        let mut rows = Rows::new(1, Path::new("/nowhere"));
        for (place, (run, status)) in [
            (5, Status::Ok),
            (2, Status::Failed),
            (9, Status::Ok),
            (2, Status::Ok),
            (0, Status::Ok),
        ]
        .into_iter()
        .enumerate()
        {
            rows.push(place as u64, &Row::without_figures(run, status, "").into()).unwrap();
        }
        assert_eq!(rows.in_order(9), [4, 1, 0]);
        assert_eq!(rows.places(&rows.in_order(9)), [4, 1, 0]);
        assert!(!rows.is_good(1));
    }

    #[test]
    fn pairs_are_of_the_same_key() {
        let (ours, theirs) = ([0, 1, 3, 4], [10, 20, 21, 40, 50]);
        assert_eq!(pairs(&ours, &theirs, |own| own, |other| other / 10), [(1, 10), (4, 40)]);
    }
}
