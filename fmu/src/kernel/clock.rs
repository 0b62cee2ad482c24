//! Times from importers: valid experiments and steps, and when two times are the same.

use fmu_standard::Call;

use super::status::Trouble;

/// Latest time, and with a minus sign the earliest: nanoseconds in 64 bits cover 292 years.
const LATEST_S: f64 = 9e9;

/// Two times are the same if no more than this many ulp apart …
const SAME_ULP: f64 = 16.0;
/// … or this many seconds, the resolution of time events.
const SAME_S: f64 = 1e-9;

/// Whether two times are the same except for rounding.
#[inline]
fn same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_S.max(SAME_ULP * f64::EPSILON * a.abs().max(b.abs()))
}

/// Whether a time is valid for an instance.
#[inline]
#[must_use]
pub fn is_instant(time_s: f64) -> bool {
    time_s.abs() <= LATEST_S
}

/// Checks a time that an importer calls `name`.
///
/// # Errors
/// The time is not valid for an instance.
pub(crate) fn check_instant(name: &str, time_s: f64) -> Result<(), Trouble> {
    if is_instant(time_s) {
        return Ok(());
    }
    Err(Trouble::error(format_args!(
        "{name} = {time_s} s is not within -{LATEST_S:e} s and {LATEST_S:e} s"
    )))
}

/// Checks the arguments of `SetupExperiment`.
///
/// # Errors
/// Which of them is invalid.
pub fn check_experiment(
    tolerance: Option<f64>,
    start_s: f64,
    stop_s: Option<f64>,
) -> Result<(), Trouble> {
    if let Some(bad) = tolerance.filter(|tolerance| !(0.0..=1.0).contains(tolerance)) {
        return Err(Trouble::error(format_args!("tolerance = {bad} is not within 0 and 1")));
    }
    check_instant("startTime", start_s)?;
    if let Some(stop) = stop_s.filter(|stop| stop.is_nan() || *stop < start_s) {
        return Err(Trouble::error(format_args!(
            "stopTime = {stop} s is before startTime = {start_s} s"
        )));
    }
    Ok(())
}

/// Checks the arguments of `DoStep` for an instance at `now_s` that ends at `stop_s`.
///
/// # Errors
/// Which of them is invalid.
pub fn check_step(t: f64, h: f64, now_s: f64, stop_s: Option<f64>) -> Result<(), Trouble> {
    if !(h >= 0.0 && h.is_finite()) {
        return Err(Trouble::error(format_args!(
            "communicationStepSize = {h} s; it must not be negative and must be finite"
        )));
    }
    if !(is_instant(t) && same_time(t, now_s)) {
        return Err(Trouble::error(format_args!(
            "currentCommunicationPoint = {t} s, but this instance is at {now_s} s; steps must join"
        )));
    }
    if !is_instant(t + h) {
        return Err(Trouble::error(format_args!(
            "communicationStepSize = {h} s leads beyond {LATEST_S:e} s"
        )));
    }
    match stop_s {
        Some(stop) if t + h > stop && !same_time(t + h, stop) => Err(Trouble::error(format_args!(
            "a step to {} s goes past the stop time of {stop} s given in {}",
            t + h,
            Call::SetupExperiment.name()
        ))),
        _ => Ok(()),
    }
}
