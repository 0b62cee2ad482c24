//! Times as importers give them: what an experiment and a step may be, and which two are the same.

use super::status::Trouble;

/// Latest time, and with a minus the earliest: nanoseconds in 64 bits reach 292 years.
const LATEST_S: f64 = 9e9;

/// Two times are the same if no more than this many ulp apart …
const SAME_ULP: f64 = 16.0;
/// … or this many seconds, the resolution of time events.
const SAME_S: f64 = 1e-9;

/// Whether two times are the same but for rounding.
#[inline]
fn same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_S.max(SAME_ULP * f64::EPSILON * a.abs().max(b.abs()))
}

/// Whether a time is one that an instance can be at.
#[inline]
#[must_use]
pub fn is_instant(time_s: f64) -> bool {
    time_s.abs() <= LATEST_S
}

/// Checks a time that an importer names `name`.
///
/// # Errors
/// It is none that an instance can be at.
pub(crate) fn check_instant(name: &str, time_s: f64) -> Result<(), Trouble> {
    if is_instant(time_s) {
        return Ok(());
    }
    Err(Trouble::error(format_args!(
        "{name} = {time_s} s is not within -{LATEST_S:e} s and {LATEST_S:e} s"
    )))
}

/// Checks the arguments of `fmi2SetupExperiment`.
///
/// # Errors
/// Which of them cannot be.
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

/// Checks the arguments of `fmi2DoStep` of an instance that is at `now_s` and ends at `stop_s`.
///
/// # Errors
/// Which of them cannot be.
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
            "a step to {} s goes past the stop time of {stop} s given in fmi2SetupExperiment",
            t + h
        ))),
        _ => Ok(()),
    }
}
