//! Which runs are shown.

use super::*;
use crate::{Number, Status};

fn rows(figures: &[f64]) -> Vec<Row> {
    let row = |(run, figure): (usize, &f64)| {
        let mut row = Row::without_figures(run as u64, Status::Ok, "");
        row.figures = [Number(*figure)].into();
        row
    };
    figures.iter().enumerate().map(row).collect()
}

#[test]
fn the_worst_run_and_the_median_one_are_shown_first() {
    let rows = rows(&[3.0, 1.0, f64::INFINITY, 2.0, 5.0]);
    let rows: Vec<&Row> = rows.iter().collect();
    let main = |small_is_bad| Main { figure: 0, small_is_bad };
    assert_eq!(main(false).choose(&rows, 2, &[]), [(2, "worst"), (0, "median")]);
    assert_eq!(main(true).choose(&rows, 1, &[]), [(1, "worst")]);
    assert_eq!(main(false).choose(&rows, 9, &[]).len(), 5);
    assert_eq!(main(false).choose(&[], 2, &[0]), []);
    assert_eq!(main(false).choose(&rows[..1], 2, &[]), [(0, "worst")]);
    // Those that are asked for come after them, once, if they were made.
    assert_eq!(main(false).choose(&rows, 1, &[2, 4, 9]), [(2, "worst"), (4, "chosen")]);
}

#[test]
fn points_are_the_first_runs_the_worst_ones_and_those_shown_in_full() {
    let text = "seeds = 1000\n[systems]\na = 'a.ssd'\n[figures.f]\nkind = 'max'\nof = 'x'\n\
        [[verdict]]\nfigure = 'f'\nat-least = 3\n";
    let campaign = Campaign::parse(text, Path::new("/c/c.toml")).unwrap();
    let values: Vec<f64> = (0..1000).map(|run| f64::from((run * 7) % 1000)).collect();
    let rows = rows(&values);
    let rows: Vec<&Row> = rows.iter().collect();
    let main = Main::of(&campaign);
    let shown = main.choose(&rows, 3, &[321]);
    let sampling =
        Sampling { inputs: Vec::new(), outages: Outages::default(), figures: 1, replicates: 5 };
    let sample = serde_json::to_value(sampling.sample(&campaign, &rows, &main, &shown)).unwrap();
    let points: Vec<u64> =
        sample["run"].as_array().unwrap().iter().map(|run| run.as_u64().unwrap()).collect();
    let has = |run: u64| points.contains(&run);
    assert!((0..5).all(has) && shown.iter().all(|(run, _)| has(*run)), "{points:?}");
    // The bound is a lower one: the smallest are the worst.
    let mut worst: Vec<u64> = (0..1000).collect();
    worst.sort_by(|a, b| values[*a as usize].total_cmp(&values[*b as usize]));
    assert!(worst[..20].iter().all(|run| has(*run)), "{points:?}");
    assert!(points.len() <= 5 + 20 + 4, "{points:?}");
    let none = Sampling { replicates: 0, ..sampling };
    let sample = serde_json::to_value(none.sample(&campaign, &rows, &main, &shown)).unwrap();
    assert_eq!(sample["run"].as_array().unwrap().len(), shown.len());
}
