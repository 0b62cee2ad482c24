//! Many runs of one system with other start values: `campaign SYSTEM COMPONENT.VARIABLE RUNS`.
//!
//! The system is read once and its FMUs are mapped once; each run has instances of its own, so
//! runs may also go on in several threads. A wish of an observer ends a run early.

use cosim::observe::{Observer, RunInfo, Stop};
use cosim::{Overrides, Result, System, Time};

/// Keeps the last value of the first column, and has enough when it is no number.
#[derive(Default)]
struct Last(f64);

impl Observer for Last {
    fn start(&mut self, _: &RunInfo<'_>) -> Result<()> {
        Ok(())
    }
    fn sample(&mut self, _: Time, values: &[f64]) -> Result<()> {
        self.0 = values[0];
        Ok(())
    }
    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
    fn stop(&self) -> Option<Stop> {
        self.0.is_nan().then_some(Stop::Enough)
    }
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, variable, runs] = &arguments[..] else {
        println!("usage: campaign SYSTEM COMPONENT.VARIABLE RUNS");
        return Ok(());
    };
    let system = System::load(file, &Overrides::new())?;
    for run in 0..runs.parse().unwrap_or(1) {
        let mut last = Last::default();
        system.with(&Overrides::new().start_value(variable, run))?.run(&mut [&mut last])?;
        println!("{variable} = {run}: {} ends at {}", system.columns()[0].name, last.0);
    }
    Ok(())
}
