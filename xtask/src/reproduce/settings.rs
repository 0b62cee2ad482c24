//! How a case becomes start values of the system `examples/paper.ssd`, for the library and, in the
//! same words, for the command line.

use std::path::PathBuf;

use cosim::Overrides;

use super::case::{Case, Filter};
use super::trace::SIGNALS;
use crate::paths;

/// The paper's loop.
pub(crate) const SYSTEM: &str = "examples/paper.ssd";
/// Time between recorded rows, s.
pub(crate) const OUTPUT_INTERVAL_S: f64 = 0.1;
/// Rate of the position fix, Hz.
pub(crate) const FIX_RATE_HZ: f64 = 10.0;
/// Speed along the course (paper, section 9), m/s.
pub(crate) const SPEED_M_S: f64 = 0.3;
/// The sensors that draw noise, each from its own stream.
const SENSORS: [&str; 4] = ["imu", "dvl", "gps", "pressure"];

/// What the paper does not say and what was chosen for the levels of its tables: noise of the DVL
/// (m/s) and turn-on bias of the accelerometers (m/s2). The filter's guard speed, chosen alike, is
/// its default; everything else is nominal.
pub(crate) const CHOSEN: [(&str, f64); 2] =
    [("dvl.sigma", 0.01), ("imu.accelerometer.turn_on_sigma", 0.1)];

/// Start values of one run, as `component.variable` and text.
pub(crate) fn start_values(case: &Case) -> Vec<(String, String)> {
    let (course, sigma) = (case.course.name(), case.fix.sigma());
    let mut values = vec![
        ("pursuit.course".to_string(), course.to_string()),
        ("gps.sigma".to_string(), sigma.to_string()),
        ("gps.rate_hz".to_string(), FIX_RATE_HZ.to_string()),
        ("ekf.fix_sigma".to_string(), sigma.to_string()),
    ];
    for (name, value) in CHOSEN {
        values.push((name.to_string(), value.to_string()));
    }
    for (i, sensor) in SENSORS.iter().enumerate() {
        values.push((format!("{sensor}.seed"), sensor_seed(case.seed, i).to_string()));
    }
    values
}

/// Seed of a sensor's noise: one for each run and sensor, the same for both filters.
fn sensor_seed(seed: u32, sensor: usize) -> usize {
    10 * seed as usize + sensor + 1
}

/// The last instant, s: a third more than the course takes at the set speed. A vehicle that swerves
/// on a noisy estimate needs up to a fifth more.
pub(crate) fn stop_time(case: &Case) -> anyhow::Result<f64> {
    Ok((4.0 / 3.0 * case.course.path()?.length() / SPEED_M_S).ceil())
}

/// The filter's FMU where the system file has another.
fn replacement(case: &Case) -> Option<PathBuf> {
    (case.filter != Filter::Dynamic).then(|| paths::fmus().join(case.filter.fmu()))
}

/// The changes to the system for one run.
pub(crate) fn overrides(case: &Case) -> anyhow::Result<Overrides> {
    let mut overrides = Overrides::new()
        .stop_time(stop_time(case)?)
        .output_interval(OUTPUT_INTERVAL_S)
        .output_variables(SIGNALS);
    for (name, value) in start_values(case) {
        overrides = overrides.start_value(name, value);
    }
    if let Some(fmu) = replacement(case) {
        overrides = overrides.replace("ekf", fmu);
    }
    Ok(overrides)
}

/// The arguments of `cosim` for one run from the root of the workspace: a verb with a file, then
/// options with their values.
pub(crate) fn arguments(case: &Case) -> anyhow::Result<Vec<(String, String)>> {
    let mut arguments = vec![("run".to_owned(), SYSTEM.to_owned())];
    let mut add = |option: &str, value: String| arguments.push((option.to_owned(), value));
    if replacement(case).is_some() {
        add("--replace", format!("ekf=target/fmus/{}", case.filter.fmu()));
    }
    for (name, value) in start_values(case) {
        add("--start-value", format!("{name}={value}"));
    }
    add("--stop-time", stop_time(case)?.to_string());
    add("--output-interval", OUTPUT_INTERVAL_S.to_string());
    Ok(arguments)
}

/// The command that repeats one run.
pub(crate) fn command(case: &Case) -> anyhow::Result<String> {
    let mut arguments = arguments(case)?;
    arguments.push(("--output-file".to_owned(), case.file_name()));
    let parts = arguments.iter().map(|(option, value)| format!("{option} {value}"));
    Ok(format!("cosim {}", parts.collect::<Vec<_>>().join(" \\\n    ")))
}

#[cfg(test)]
mod tests {
    use super::super::case::{Course, Fix};
    use super::*;

    fn case(filter: Filter, seed: u32) -> Case {
        Case { course: Course::Be2, filter, fix: Fix::Coarse, seed }
    }

    fn seeds(case: &Case) -> Vec<String> {
        let values = start_values(case).into_iter();
        values.filter(|(name, _)| name.ends_with(".seed")).map(|(_, value)| value).collect()
    }

    #[test]
    fn noise_differs_between_sensors_and_runs_but_not_between_filters() {
        let mut all: Vec<String> =
            (1..=50).flat_map(|seed| seeds(&case(Filter::Dynamic, seed))).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 50 * SENSORS.len());
        assert_eq!(seeds(&case(Filter::Dynamic, 7)), seeds(&case(Filter::Kinematic, 7)));
    }

    #[test]
    fn the_command_sets_what_the_run_sets() {
        let case = case(Filter::Kinematic, 3);
        let command = command(&case).unwrap();
        for (name, value) in start_values(&case) {
            assert!(command.contains(&format!("--start-value {name}={value}")), "{name}");
        }
        assert!(command.contains("--replace ekf=target/fmus/EkfKinematic.fmu"));
    }
}
