//! Step sizes, start, stop and output interval.

use super::Findings;
use super::components::Opened;
use crate::error::{Code, Error, Result};
use crate::system::raw::RawSystem;
use crate::system::{Model, Overrides};
use crate::time::Time;

/// Steps that share no common base longer than this part of the smallest are refused.
const FINEST: i64 = 1000;

pub(super) struct Timing {
    pub start: Time,
    pub stop: Time,
    pub output_interval: Time,
    /// Per component.
    pub steps: Vec<Time>,
}

pub(super) fn check(
    raw: &RawSystem,
    overrides: &Overrides,
    opened: &[Opened],
    findings: &mut Findings,
) -> Option<Timing> {
    let steps = steps(raw, overrides, opened, findings)?;
    let rest = span(raw, overrides, opened).and_then(|(start, stop)| {
        let wanted = overrides.output_interval.or(raw.master.output_interval);
        let output_interval = check_span(&steps, start, stop, wanted)?;
        Ok(Timing { start, stop, output_interval, steps: steps.clone() })
    });
    findings.note(rest.map_err(|e| match (misfit(&steps), &raw.experiment) {
        (Some(component), _) => raw.components[component].place.mark(e),
        (None, Some(place)) => place.mark(e),
        (None, None) => e.at(&raw.file),
    }))
}

/// The first component whose step has no common base with those before it.
fn misfit(steps: &[Time]) -> Option<usize> {
    let smallest = steps.iter().min().copied()?;
    let mut base = *steps.first()?;
    steps.iter().position(|&step| {
        base = base.gcd(step);
        base.nanoseconds() < smallest.nanoseconds() / FINEST
    })
}

/// A component's step: of the command line, of its annotation, of its FMU's default experiment,
/// of the system's annotation, or the smallest of the others.
fn steps(
    raw: &RawSystem,
    overrides: &Overrides,
    opened: &[Opened],
    findings: &mut Findings,
) -> Option<Vec<Time>> {
    let mut steps: Vec<Option<Time>> = Vec::new();
    let mut sound = true;
    for (component, opened) in raw.components.iter().zip(opened) {
        let named = overrides.steps.iter().rev().find(|(name, _)| *name == component.name);
        let default = || opened.description().and_then(|d| d.experiment.step);
        let seconds =
            named.map(|(_, step)| *step).or(component.step).or_else(default).or(raw.master.step);
        let name = format!("the step of '{}'", component.name);
        let step = seconds.map(|s| Time::positive(s, &name)).transpose();
        let step = step.map_err(|e| component.place.mark(e));
        let step = findings.note(step);
        sound &= step.is_some();
        steps.push(step.flatten());
    }
    let smallest = steps.iter().flatten().min().copied();
    if !sound || opened.iter().any(|o| o.model.is_none()) || steps.is_empty() {
        return None;
    }
    if smallest.is_none() {
        findings.problems.push(
            Error::new(Code::Timing, "no component has a step size").at(&raw.file).help(
                "give one by --step COMPONENT=SECONDS, or for all by the annotation \
                 <cosim:Master stepSize=\"0.01\"/>",
            ),
        );
    }
    let smallest = smallest?;
    let base = steps.iter().flatten().fold(smallest, |base, &step| base.gcd(step));
    let functions = opened.iter().map(|o| matches!(o.model, Some(Model::Function(_))));
    // A function changes whenever one of its inputs does.
    let step = |(step, function): (Option<Time>, bool)| match function {
        true => base,
        false => step.unwrap_or(smallest),
    };
    Some(steps.into_iter().zip(functions).map(step).collect())
}

fn span(raw: &RawSystem, overrides: &Overrides, opened: &[Opened]) -> Result<(Time, Time)> {
    let start = overrides.start_time.or(raw.start).unwrap_or(0.0);
    let suggested =
        opened.iter().filter_map(|o| o.description()?.experiment.stop).max_by(f64::total_cmp);
    let stop = overrides.stop_time.or(raw.stop).or(suggested).ok_or_else(|| {
        Error::new(Code::Timing, "there is no stop time").help(
            "give --stop-time SECONDS, or in the file <ssd:DefaultExperiment stopTime=\"...\"/> (SSP) \
             or <EndTime> (OSP)",
        )
    })?;
    Ok((Time::from_seconds(start, "the start time")?, Time::from_seconds(stop, "the stop time")?))
}

/// Checks that everything is a multiple of the common base; gives the output interval.
pub(in crate::system) fn check_span(
    steps: &[Time],
    start: Time,
    stop: Time,
    wanted_interval: Option<f64>,
) -> Result<Time> {
    let Some(smallest) = steps.iter().min().copied() else {
        return Ok(Time::ZERO);
    };
    let base = steps.iter().fold(smallest, |base, &step| base.gcd(step));
    if base.nanoseconds() < smallest.nanoseconds() / FINEST {
        return Err(Error::new(Code::Timing, "the step sizes do not fit together")
            .why(format!("their greatest common divisor is {base}, the smallest is {smallest}"))
            .help("choose steps that are multiples of one another, by --step COMPONENT=SECONDS"));
    }
    if stop <= start {
        return Err(Error::new(Code::Timing, format!("the run would go from {start} to {stop}"))
            .help("choose a stop time after the start time"));
    }
    if !(stop - start).is_multiple_of(base) {
        return Err(off_base("the duration", stop - start, base));
    }
    let interval = match wanted_interval {
        Some(seconds) => Time::positive(seconds, "the output interval")?,
        None => smallest,
    };
    if !interval.is_multiple_of(base) {
        return Err(off_base("the output interval", interval, base));
    }
    Ok(interval)
}

fn off_base(what: &str, time: Time, base: Time) -> Error {
    let below = time.nanoseconds() / base.nanoseconds() * base.nanoseconds();
    let below = Time::from_nanoseconds(below);
    let nearest = if below > Time::ZERO {
        format!("take {below} or {}", below + base)
    } else {
        format!("take {base} or a multiple of it")
    };
    Error::new(Code::Timing, format!("{what} is {time}"))
        .why(format!("it is no multiple of {base}, the common base of the step sizes"))
        .help(nearest)
}
