//! Measurement faults: each filter keeps its accuracy, or recovers it.
//!
//! `SEEDS=24 cargo test --release --test faults -- --nocapture` prints the table for 24 seeds:
//! medians and 95 % quantiles of the results, and the goal. Without `SEEDS` few seeds run, and the
//! margin is wider because their median scatters more.
//!
//! The inertial filter, which has no vehicle model, does not reach the goal while the velocity log
//! is off, stuck, zero or not a number: only the fix then determines its velocity. It reaches 0.45
//! m.

use crate::mission::*;
use crate::scoring::*;
use rexrov::estimation::NavigationParameters;
use rexrov::guidance::Course;

const FILTERS: [Which; 3] = [Which::Dynamic, Which::Inertial, Which::ModelAided];
const SEEDS: u64 = 3;
/// How much the medians may exceed the goals.
const MARGIN: f64 = 0.2;
/// Standard deviation of a mission's result, relative to the median over missions.
const SCATTER: f64 = 0.24;

/// The margin, and two standard deviations of the median of this many seeds.
fn margin(seeds: u64) -> f64 {
    (1.0 + MARGIN) * (1.0 + 2.0 * 1.25 * SCATTER / (seeds as f64).sqrt())
}

/// When faults begin (s), and when temporary ones do so.
const FAULT: f64 = 200.0;
const PASSED: f64 = 260.0;
/// Goals without the velocity log (m); see above for the second.
const WITHOUT_DVL: [f64; FILTERS.len()] = [0.27, 0.45, 0.27];
/// When a filter counts as settled (s).
const SETTLED: f64 = 30.0;
const KINDS: [Kind; 6] = [Kind::Imu, Kind::Thrust, Kind::Ahrs, Kind::Dvl, Kind::Fix, Kind::Depth];

/// A modification of a mission, and the expected result of a filter.
struct Cell {
    name: &'static str,
    options: fn(&mut Options),
    fault: fn(&mut Mission, u64),
    /// Standard deviation of the bias of the compass that the filter expects (rad).
    heading_bias: f64,
    measure: fn(&Run) -> f64,
    /// Medians that each filter must reach (m, s or degrees).
    goals: [f64; FILTERS.len()],
}

fn settled(run: &Run) -> f64 {
    run.rmse(SETTLED, f64::MAX)
}

fn in_the_fault(run: &Run) -> f64 {
    run.rmse(FAULT, PASSED)
}

fn since_the_fault(run: &Run) -> f64 {
    run.rmse(FAULT, f64::MAX)
}

fn heading_since(run: &Run) -> f64 {
    run.rms(FAULT, |s| s.heading).to_degrees()
}

fn widest_heading(run: &Run) -> f64 {
    let late = run.samples.iter().filter(|s| s.time > SETTLED);
    late.fold(0.0_f64, |m, s| m.max(s.heading.abs())).to_degrees()
}

/// Seconds from the fault until the error first is below 0.3 m.
fn time_to_return(run: &Run) -> f64 {
    let near = |s: &&Sample| s.time > FAULT + 0.5 && s.error[0].hypot(s.error[1]) < 0.3;
    run.samples.iter().find(near).map_or(1e3, |s| s.time - FAULT)
}

/// The mission begins at the fault, with a filter that is half a metre wrong.
fn restart(mission: &mut Mission) {
    mission.truth.retain(|t| t.time >= FAULT - 1e-9);
    mission.events.retain(|e| e.arrival >= FAULT - 1e-9);
    let [x, y, _] = mission.truth[0].position;
    let [a, b] = mission.initial_error;
    let scale = 0.5 / a.hypot(b);
    mission.initial_error = [x + scale * a, y + scale * b];
}

fn clock(mission: &mut Mission, kinds: &[Kind], seconds: f64) {
    kinds.iter().for_each(|&k| shift_clock(&mut mission.events, k, FAULT, seconds));
}

fn cells() -> Vec<Cell> {
    let nominal = Cell {
        name: "nominal",
        options: |_| {},
        fault: |_, _| {},
        heading_bias: 0.0,
        measure: settled,
        goals: [0.069; 3],
    };
    macro_rules! cell {
        ($($field:ident: $value:expr),*) => { Cell { $($field: $value,)* ..nominal } };
    }
    vec![
        cell!(name: "fix outliers 5 %, 10 to 50 m", goals: [0.065; 3],
            fault: |m, s| outliers(&mut m.events, Kind::Fix, 0.05, 10.0, 50.0, s)),
        cell!(name: "fix outliers 5 %, 2 to 5 m", goals: [0.065; 3],
            fault: |m, s| outliers(&mut m.events, Kind::Fix, 0.05, 2.0, 5.0, s)),
        cell!(name: "fix outliers 20 %, 10 to 50 m", goals: [0.071; 3],
            fault: |m, s| outliers(&mut m.events, Kind::Fix, 0.2, 10.0, 50.0, s)),
        cell!(name: "DVL outliers 5 %, 1 m/s", goals: [0.068; 3],
            fault: |m, s| outliers(&mut m.events, Kind::Dvl, 0.05, 1.0, 1.0, s)),
        cell!(name: "DVL off 60 s", goals: WITHOUT_DVL, measure: in_the_fault,
            fault: |m, _| drop(&mut m.events, Kind::Dvl, FAULT, PASSED)),
        cell!(name: "DVL stuck 60 s", goals: WITHOUT_DVL, measure: in_the_fault,
            fault: |m, _| stuck(&mut m.events, Kind::Dvl, FAULT, PASSED)),
        cell!(name: "DVL zero 60 s", goals: WITHOUT_DVL, measure: in_the_fault,
            fault: |m, _| zero(&mut m.events, Kind::Dvl, FAULT, PASSED)),
        cell!(name: "DVL NaN 60 s", goals: WITHOUT_DVL, measure: in_the_fault,
            fault: |m, _| nan(&mut m.events, Kind::Dvl, FAULT, PASSED)),
        cell!(name: "fix late 0.5 s", goals: [0.063; 3],
            fault: |m, _| delay(&mut m.events, Kind::Fix, 0.5)),
        cell!(name: "fix late 2 s", goals: [0.064; 3],
            fault: |m, _| delay(&mut m.events, Kind::Fix, 2.0)),
        cell!(name: "fix late 0 to 1 s, out of order", goals: [0.063; 3],
            fault: |m, s| jitter(&mut m.events, Kind::Fix, 1.0, s)),
        cell!(name: "all clocks +5 s", goals: [0.054; 3], measure: since_the_fault,
            fault: |m, _| clock(m, &KINDS, 5.0)),
        cell!(name: "all clocks -5 s", goals: [0.054; 3], measure: since_the_fault,
            fault: |m, _| clock(m, &KINDS, -5.0)),
        cell!(name: "clock of the DVL -5 s", goals: [0.054; 3], measure: since_the_fault,
            fault: |m, _| clock(m, &[Kind::Dvl], -5.0)),
        cell!(name: "clock of the IMU -5 s", goals: [0.054; 3], measure: since_the_fault,
            fault: |m, _| clock(m, &[Kind::Imu], -5.0)),
        cell!(name: "compass step 10 deg", goals: [0.073; 3], heading_bias: 0.035,
            measure: since_the_fault,
            fault: |m, _| heading_step(&mut m.events, FAULT, 10_f64.to_radians())),
        cell!(name: "compass step 10 deg: heading", goals: [0.18; 3], heading_bias: 0.035,
            measure: heading_since,
            fault: |m, _| heading_step(&mut m.events, FAULT, 10_f64.to_radians())),
        cell!(name: "compass bias 3 deg", goals: [0.083; 3], heading_bias: 0.035,
            options: |o| o.heading_bias = 3_f64.to_radians()),
        cell!(name: "kidnapped 10 m: back below 0.3 m (s)", goals: [11.0; 3], measure: time_to_return,
            options: |o| o.kidnap = Some(FAULT)),
        cell!(name: "fix every 5 s", goals: [0.132; 3], options: |o| o.fix_hz = 0.2),
        cell!(name: "DVL 2 Hz", goals: [0.081; 3], options: |o| o.dvl_hz = 2.0),
        cell!(name: "restart in mid-mission", goals: [0.071; 3], fault: |m, _| restart(m),
            measure: |r| r.rmse(FAULT + 30.0, f64::MAX)),
        cell!(name: "heading across south: largest error (deg)", goals: [1.0; 3],
            measure: widest_heading),
        nominal,
    ]
}

/// The result of each filter in a cell with a seed.
fn run_cell(
    cell: &Cell,
    mut mission: Mission,
    options: &Options,
    seed: u64,
) -> [f64; FILTERS.len()] {
    (cell.fault)(&mut mission, seed);
    let tune = |p: &mut NavigationParameters| p.sensors.heading_bias_sigma = cell.heading_bias;
    FILTERS.map(|which| (cell.measure)(&run(which, options, &mission, tune)))
}

#[test]
fn faults_cost_no_more_than_they_must() {
    let seeds = std::env::var("SEEDS").map_or(SEEDS, |s| s.parse().unwrap());
    let only = std::env::var("CELL").unwrap_or_default();
    let cells: Vec<Cell> = cells().into_iter().filter(|c| c.name.contains(&only)).collect();
    let runs = parallel(1..=seeds, |seed| {
        let nominal = Options::nominal(Course::BE3, seed);
        let flown = fly(&nominal);
        let run = |cell: &Cell| {
            let mut options = nominal;
            (cell.options)(&mut options);
            let mission = if options == nominal { flown.clone() } else { fly(&options) };
            run_cell(cell, mission, &options, seed)
        };
        cells.iter().map(run).collect::<Vec<_>>()
    });
    let mut missed = Vec::new();
    for (k, cell) in cells.iter().enumerate() {
        for (i, (which, goal)) in FILTERS.into_iter().zip(cell.goals).enumerate() {
            let reached: Vec<f64> = runs.iter().map(|run| run[k][i]).collect();
            let (median, high) = (quantile(&reached, 0.5), quantile(&reached, 0.95));
            let line =
                format!("{:<42} {which:?}: {median:.3}/{high:.3}, goal {goal:.3}", cell.name);
            println!("{line}");
            if median > margin(seeds) * goal {
                missed.push(line);
            }
        }
    }
    assert!(missed.is_empty(), "missed: {missed:#?}");
}
