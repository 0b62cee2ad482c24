//! Which runs are shown.

use super::*;
use crate::campaign::{Number, Status};

fn rows(figures: &[f64]) -> Vec<Row> {
    let row = |(run, figure): (usize, &f64)| {
        let mut row = Row::without_figures(run as u64, Status::Ok, "");
        row.figures = vec![Number(*figure)];
        row
    };
    figures.iter().enumerate().map(row).collect()
}

#[test]
fn the_worst_run_and_the_median_one_are_shown_first() {
    let rows = rows(&[3.0, 1.0, f64::INFINITY, 2.0, 5.0]);
    let rows: Vec<&Row> = rows.iter().collect();
    let main = |small_is_bad| Main { figure: 0, small_is_bad };
    assert_eq!(main(false).choose(&rows, 2), [(2, "worst"), (0, "median")]);
    assert_eq!(main(true).choose(&rows, 1), [(1, "worst")]);
    assert_eq!(main(false).choose(&rows, 9).len(), 5);
    assert_eq!(main(false).choose(&[], 2), []);
    assert_eq!(main(false).choose(&rows[..1], 2), [(0, "worst")]);
}
