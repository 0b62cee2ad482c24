//! Seeded runs of the baseline with a fault: the DVL is off between 100 s and 130 s.
//!
//! `cargo run --release -p cosim --example campaign -- examples/baseline.ssd 20` (after
//! `cargo xtask package`). The system is read once and its FMUs are mapped once; each run has
//! instances of its own, so runs may also go on in several threads.

use cosim::{Controls, Manipulator, Overrides, Recording, Result, Run, System, Time};

/// When the DVL is switched, and to what.
struct Outage(Vec<(Time, f64)>);

impl Manipulator for Outage {
    fn next(&self) -> Option<Time> {
        self.0.first().map(|(time, _)| *time)
    }
    fn act(&mut self, _: Time, controls: &mut Controls<'_>) -> Result<()> {
        let (_, off) = self.0.remove(0);
        controls.set("dvl.off", off)
    }
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or("examples/baseline.ssd".to_owned());
    let runs = arguments.next().and_then(|runs| runs.parse().ok()).unwrap_or(3);
    let second = |s: i64| Time::from_ns(s * 1_000_000_000);
    let system = System::load(&file, &Overrides::new())?;
    for seed in 1..=runs {
        let overrides = Overrides::new().start_value("dvl.seed", seed).stop_time(200.0);
        let mut outage = Outage(vec![(second(100), 1.0), (second(130), 0.0)]);
        let (system, mut results) = (system.with(&overrides)?, Recording::new());
        Run::new(&system).observe(&mut results).manipulate(&mut outage).go()?;
        let (truth, estimate) =
            (results.column("vehicle.pose.x")?, results.column("filter.pose.x")?);
        let worst = truth.iter().zip(estimate).map(|(t, e)| (t - e).abs()).fold(0.0, f64::max);
        println!("seed {seed}: the estimate of x is off by at most {worst:.2} m");
    }
    Ok(())
}
