//! Which runs are shown.

use super::*;
use crate::columns::Columns;
use crate::{Number, Row, Rows, Status};

fn rows(figures: &[f64]) -> Rows {
    let mut rows = Rows::new(1, Path::new("/nowhere"));
    for (run, figure) in figures.iter().enumerate() {
        let mut row = Row::without_figures(run as u64, Status::Ok, "");
        row.figures = [Number(*figure)].into();
        rows.push(0, &row.into()).unwrap();
    }
    rows
}

/// Of 1000 runs; large values are bad unless there is a lower bound.
fn campaign(bound: &str) -> Campaign {
    let text = format!(
        "seeds = 1000\n[systems]\na = 'a.ssd'\n[figures.f]\nkind = 'max'\nof = 'x'\n\
         [[verdict]]\nfigure = 'f'\n{bound} = 3\n"
    );
    Campaign::parse(&text, Path::new("/c/c.toml")).unwrap()
}

#[test]
fn the_worst_run_and_the_median_one_are_shown_first() {
    let rows = rows(&[3.0, 1.0, f64::INFINITY, 2.0, 5.0]);
    let main = |bound: &str| Main::of(&campaign(bound), &rows).unwrap();
    let (large, all) = (main("at-most"), [0, 1, 2, 3, 4]);
    assert_eq!(large.choose(&all, 2, &[]), [(2, "worst"), (0, "median")]);
    assert_eq!(main("at-least").choose(&all, 1, &[]), [(1, "worst")]);
    assert_eq!(large.choose(&all, 9, &[]).len(), 5);
    assert_eq!(large.choose(&[], 2, &[0]), []);
    assert_eq!(large.choose(&all[..1], 2, &[]), [(0, "worst")]);
    // Those that are asked for come after them, once, if they were made.
    assert_eq!(large.choose(&all, 1, &[2, 4, 9]), [(2, "worst"), (4, "chosen")]);
}

#[test]
fn points_are_the_first_runs_the_worst_ones_and_those_shown_in_full() {
    // The bound is a lower one: the smallest are the worst.
    let campaign = campaign("at-least");
    let values: Vec<f64> = (0..1000).map(|run| f64::from((run * 7) % 1000)).collect();
    let rows = rows(&values);
    let all: Vec<usize> = (0..1000).collect();
    let main = Main::of(&campaign, &rows).unwrap();
    let shown = main.choose(&all, 3, &[321]);
    let mut sampling = Sampling {
        inputs: Vec::new(),
        values: Columns::new(0, Path::new("/nowhere")),
        outages: Outages::default(),
        figures: 1,
        replicates: 5,
    };
    let points = sampling.points(&campaign, &rows, &all, &main, &shown);
    let has = |run: usize| points.contains(&run);
    let shown_too = shown.iter().all(|(run, _)| has(*run as usize));
    assert!((0..5).all(has) && shown_too, "{points:?}");
    let mut worst = all.clone();
    worst.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    assert!(worst[..20].iter().all(|run| has(*run)), "{points:?}");
    assert!(points.len() <= 5 + 20 + 4, "{points:?}");
    sampling.replicates = 0;
    assert_eq!(sampling.points(&campaign, &rows, &all, &main, &shown).len(), shown.len());
}
