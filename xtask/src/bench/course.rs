//! The paper's loop on its first course: eight FMUs in one process, outputs recorded at 10 Hz.

use super::{Bar, Row, row};
use crate::paths;
use anyhow::Result;
use cosim::{Overrides, System, observe::CsvRecorder};
use std::time::Instant;

const REPETITIONS: usize = 5;

pub(super) fn measure() -> Result<Vec<Row>> {
    let system = System::load(paths::root().join("examples/paper.ssd"), &Overrides::new())?;
    let csv = paths::target().join("bench.csv");
    let mut best = f64::INFINITY;
    let mut simulated = 0.0;
    for _ in 0..REPETITIONS {
        let begun = Instant::now();
        let summary = system.run(&mut [&mut CsvRecorder::create(&csv)?])?;
        best = best.min(begun.elapsed().as_secs_f64());
        simulated = summary.simulated;
    }
    let what = "course BE1, all outputs recorded to CSV";
    Ok(vec![row(what, simulated / best, "x real", Bar::AtLeast(2000.0))])
}
