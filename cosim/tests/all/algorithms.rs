//! The order of accuracy of each algorithm, compared with exact solutions; the table in
//! docs/algorithms.md contains the values measured here.

use std::fmt::Write;

use cosim::{Algorithm, Input, Overrides, Recording};

use crate::models::Model::{Gain, Inertia, Mass};
use crate::ssd::{Ssd, run};

const STOP: f64 = 2.0;
/// Stiffness of a mass with its springs, and of the spring between both.
const K: f64 = 5.0;
const COUPLING: f64 = 3.0;
/// Added mass per mass, and stiffness of the split oscillator.
const ADDED: f64 = 0.5;

/// The maximum error of some results.
type ErrorOf = fn(&Recording) -> f64;

/// x1'' = -K x1 + C x2 and the same for x2, x1(0) = 1, x2(0) = 0: two modes.
fn two_masses(t: f64) -> [f64; 2] {
    let (slow, fast) = (((K - COUPLING).sqrt() * t).cos(), ((K + COUPLING).sqrt() * t).cos());
    [0.5 * (slow + fast), 0.5 * (slow - fast)]
}

fn masses() -> Ssd {
    let values = |start: f64| [("k", K), ("second", COUPLING), ("m", start)];
    Ssd::new()
        .add_with("a", Mass, &values(1.0), None)
        .add_with("b", Mass, &values(0.0), None)
        .stop(STOP)
}

fn positions(results: &Recording) -> f64 {
    let (a, b) = (results.column("a.y").unwrap(), results.column("b.y").unwrap());
    let each = results.time().iter().zip(a.iter().zip(b)).map(|(t, (a, b))| {
        let exact = two_masses(*t);
        (a - exact[0]).abs().max((b - exact[1]).abs())
    });
    each.fold(0.0, f64::max)
}

fn acceleration(results: &Recording) -> f64 {
    let square = K / (1.0 + ADDED);
    let exact = |t: f64| -square * (square.sqrt() * t).cos();
    let found = results.time().iter().zip(results.column("body.y").unwrap());
    // Without the start: there only the solved loop has the acceleration.
    found.skip(1).map(|(t, y)| (y - exact(*t)).abs()).fold(0.0, f64::max)
}

/// A system, its error, and its name in the table.
fn cases() -> Vec<(&'static str, Ssd, ErrorOf)> {
    let direct = masses().connect("a.y", "b.u").connect("b.y", "a.u");
    let sensed = masses()
        .add("sensor", Gain)
        .connect("a.y", "sensor.u")
        .connect("sensor.y", "b.u")
        .connect("b.y", "a.u");
    let split = Ssd::new()
        .add_with("body", Inertia, &[("k", K), ("second", 1.0)], None)
        .add_with("water", Gain, &[("k", -ADDED)], None)
        .connect("water.y", "body.u")
        .connect("body.y", "water.u")
        .stop(STOP);
    vec![
        ("two masses, positions exchanged", direct, positions),
        ("the same, one position through a sensor", sensed, positions),
        ("a mass and its added mass", split, acceleration),
    ]
}

fn error(ssd: &Ssd, of: ErrorOf, overrides: Overrides, step: f64) -> f64 {
    let names = ["a", "b", "sensor", "body", "water"];
    let text = ssd.text();
    let present = names.iter().filter(|name| text.contains(&format!("name='{name}'")));
    let overrides = present.fold(overrides.output_interval(0.2), |o, name| o.step(*name, step));
    of(&run(&ssd.load(&overrides).unwrap()))
}

/// The slope between two step sizes, as in the table.
fn order(ssd: &Ssd, of: ErrorOf, overrides: &Overrides) -> String {
    let (coarse, fine) = (0.01, 0.005);
    let errors = [coarse, fine].map(|step| error(ssd, of, overrides.clone(), step));
    if errors[1] > 1.0 {
        return "unstable".to_owned();
    }
    format!("{:.1} ({:.0e})", (errors[0] / errors[1]).log2(), errors[1])
}

#[test]
fn the_table_of_orders_is_what_is_measured() {
    let mut table = String::from("| system | algorithm | hold | linear |\n|---|---|---|---|\n");
    for (name, ssd, of) in cases() {
        for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel, Algorithm::Iterative] {
            let base = Overrides::new().algorithm(algorithm);
            let hold = order(&ssd, of, &base);
            let linear = order(&ssd, of, &base.clone().input("", Input::Linear));
            writeln!(table, "| {name} | {algorithm} | {hold} | {linear} |").unwrap();
        }
    }
    let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/algorithms.md");
    let docs = std::fs::read_to_string(docs).unwrap_or_default();
    assert!(docs.contains(&table), "docs/algorithms.md should have\n{table}");
}
