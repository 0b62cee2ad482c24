//! Figures of hand-made recordings.

use super::*;
use cosim_base::error::Code;
use cosim_core::observe::Recording;
use cosim_core::table::Document;

fn read(text: &str) -> Figure {
    let document = Document::new(text, std::path::Path::new("c.toml"), Code::Scenario);
    let parsed = document.parse().unwrap();
    let figure = Figure::read(&document.root(&parsed));
    document.finish().unwrap();
    figure.unwrap()
}

fn compute(text: &str, columns: &[(&str, &[f64])]) -> f64 {
    of_figure(&read(text), columns)
}

fn of_figure(figure: &Figure, columns: &[(&str, &[f64])]) -> f64 {
    let names = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
    let time = (0..columns[0].1.len()).map(|row| row as f64 * 0.5).collect();
    let values = columns.iter().map(|(_, values)| values.to_vec()).collect();
    let recording = Recording::from_columns(names, time, values);
    assert!(figure.columns().iter().all(|name| recording.column(name).is_ok()));
    figure.compute(&recording, Some([0.5, 1.0])).unwrap()
}

#[test]
fn figures_of_a_variable_are_what_they_say() {
    let x: &[(&str, &[f64])] = &[("x", &[1.0, -2.0, 5.0, 4.0]), ("y", &[0.0, 0.0, 1.0, 1.0])];
    let of = |more: &str| compute(&format!("of = \"x\"\n{more}"), x);
    assert_eq!(of("kind = 'final'"), 4.0);
    assert_eq!(of("kind = 'min'"), -2.0);
    assert_eq!(of("kind = 'max'"), 5.0);
    assert_eq!(of("kind = 'mean'"), 2.0);
    assert_eq!(of("kind = 'max'\nminus = 'y'"), 4.0);
    assert_eq!(of("kind = 'mean'\nabsolute = true"), 3.0);
    assert_eq!(of("kind = 'rms'"), (46.0_f64 / 4.0).sqrt());
    assert_eq!(of("kind = 'percentile'\np = 50"), 2.5);
    assert_eq!(of("kind = 'time-above'\nabove = 0.5"), 1.0);
    assert_eq!(of("kind = 'first-above'\nabove = 3"), 1.0);
    assert_eq!(of("kind = 'first-above'\nabove = 9"), f64::INFINITY);
    assert_eq!(of("kind = 'max'\nfrom = 0.4\nuntil = 0.6"), -2.0);
    assert_eq!(of("kind = 'settled-below'\nbelow = 4.5"), 1.5);
    assert_eq!(of("kind = 'settled-below'\nbelow = 2"), f64::INFINITY);
    assert_eq!(of("kind = 'settled-below'\nbelow = 9\nfrom = 0.5"), 0.0);
    let window = |window: &str| of(&format!("kind = 'max'\nwindow = '{window}'"));
    assert_eq!([window("before"), window("during"), window("after")], [1.0, 5.0, 5.0]);
    assert!(of("kind = 'max'\nfrom = 7").is_nan());
    assert!(compute("kind = 'max'\nof = 'x'", &[("x", &[1.0, f64::NAN, 3.0])]).is_nan());
}

#[test]
fn nees_and_nis_weigh_errors_by_their_covariance() {
    let columns: &[(&str, &[f64])] = &[
        ("t.x", &[0.0]),
        ("t.yaw", &[3.1]),
        ("e.x", &[2.0]),
        ("e.yaw", &[-3.1]),
        ("s.x", &[1.0]),
        ("s.yaw", &[0.1]),
        ("c.x_yaw", &[0.0]),
    ];
    let text = "kind = 'nees'\ntruth = 't'\nestimate = 'e'\nsigma = 's'\naxes = ['x', 'yaw']";
    let turn = std::f64::consts::TAU - 6.2;
    let wanted = 4.0 + turn * turn / 0.01;
    assert!((compute(text, columns) - wanted).abs() < 1e-9);
    let with = compute(&format!("{text}\ncovariance = 'c'"), columns);
    assert!((with - wanted).abs() < 1e-9);
    let columns: &[(&str, &[f64])] =
        &[("n", &[9.0, 9.0, 2.0, 2.0, 4.0]), ("c", &[0.0, 0.0, 1.0, 1.0, 2.0])];
    assert_eq!(compute("kind = 'nis'\nnis = 'n'\ncount = 'c'", columns), 3.0);
}

#[test]
fn errors_beside_the_way_beyond_their_deviation_and_correlated_are_found() {
    let columns: &[(&str, &[f64])] = &[
        ("t.x", &[0.0, 1.0, 2.0, 2.0]),
        ("t.y", &[0.0, 0.0, 0.0, 1.0]),
        ("e.x", &[5.0, 1.0, 2.5, 2.5]),
        ("e.y", &[1.0, -2.0, 9.0, 1.0]),
        ("s.x", &[1.0, 1.0, 1.0, 1.0]),
        ("s.y", &[1.0, 1.0, 3.0, 1.0]),
        ("v", &[1.0, 1.0, -1.0, 1.0]),
        ("c", &[0.0, 1.0, 2.0, 3.0]),
    ];
    let poses = "truth = 't'\nestimate = 'e'\naxes = ['x', 'y']\n";
    let of = |text: &str| compute(&format!("{poses}{text}"), columns);
    // 1 and 2 to the side of the way north, then 0.5 to the side of the way east.
    assert_eq!(of("kind = 'cross-track'\ntake = 'max'"), 2.0);
    assert!(
        (of("kind = 'cross-track'") - ((1.0 + 4.0 + 0.25 + 0.25) / 4.0_f64).sqrt()).abs() < 1e-12
    );
    assert_eq!(of("kind = 'beyond'\nsigma = 's'"), 1.0 / 8.0);
    assert_eq!(of("kind = 'beyond'\nsigma = 's'\nsigmas = 1.5"), 3.0 / 8.0);
    let white = compute("kind = 'whiteness'\ninnovation = 'v'\ncount = 'c'", columns);
    assert_eq!(white, -2.0 / 2.0 * 2.0_f64.sqrt());
}

#[test]
fn an_error_over_time_has_a_claimed_deviation_and_ends_with_the_run() {
    // At 0, 0.5, 1 and 1.5 s.
    let columns: &[(&str, &[f64])] = &[
        ("t", &[0.0, 1.0, 2.0, 3.1]),
        ("e", &[1.0, -1.0, 2.5, -3.1]),
        ("s", &[1.0, 2.0, 3.0, 4.0]),
    ];
    let text =
        "kind = 'error'\nof = 'e'\nminus = 't'\nsigma = '2 * {s}'\nangle = true\nevery = 0.5\n";
    let figure = read(text);
    let turn = 6.2 - std::f64::consts::TAU;
    let wanted = ((1.0 + 4.0 + 0.25 + turn * turn) / 4.0).sqrt();
    assert!((of_figure(&figure, columns) - wanted).abs() < 1e-12);
    let at = |figure: &Figure, instant: f64| {
        let both = figure.at(instant);
        assert_eq!(both.iter().map(|(more, _)| *more).collect::<Vec<_>>(), ["", ".sigma"]);
        both.iter().map(|(_, figure)| of_figure(figure, columns)).collect::<Vec<_>>()
    };
    assert_eq!(at(&figure, 0.5), [-2.0, 4.0]);
    assert_eq!(at(&figure, 0.9), [-2.0, 4.0]);
    // 3 * 0.5 may be a little less or more.
    assert!((at(&figure, 1.5 - 1e-12)[0] + turn).abs() < 1e-12);
    assert!(at(&figure, 2.0).iter().all(|value| value.is_nan()));
    let part = read(&format!("{text}window = 'during'"));
    assert_eq!(at(&part, 1.0), [0.5, 6.0]);
    assert!(at(&part, 0.4).iter().chain(&at(&part, 1.5)).all(|value| value.is_nan()));
    assert!(read("kind = 'rms'\nof = 'e'").at(1.0).is_empty());
}
