//! Step sizes, start, stop and output interval.

use super::Findings;
use super::components::Opened;
use crate::system::raw::RawSystem;
use crate::system::{Model, Overrides};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{self, Step, Time};

/// Default for unknown steps.
const UNKNOWN: Time = Time::from_ns(1_000_000_000);

/// A common base of steps is longer than this part of the smallest: whatever has to be done at each
/// multiple of it would otherwise take most of a run.
const FINEST: f64 = 1000.0;

pub(super) struct Timing {
    pub span: Span,
    /// For each component.
    pub steps: Vec<Step>,
    /// Their lengths are unknown.
    pub unknown_steps: bool,
}

/// Start and stop of a run, and the recording interval.
pub(in crate::system) struct Span {
    pub start: Time,
    /// [`Time::NEVER`] if it is unknown.
    pub stop: Time,
    pub output_interval: Step,
    /// The run ends with shorter steps.
    pub shortened: bool,
    pub warnings: Vec<String>,
    pub notes: Vec<String>,
}

/// The step of a component, and whether its last one may be shorter; for a model that is not an FMU
/// it always may.
pub(in crate::system) struct Stepped<'a> {
    pub name: &'a str,
    pub step: Step,
    pub varies: bool,
    pub fmu: bool,
}

/// An output interval.
#[derive(Clone, Copy)]
pub(in crate::system) enum Interval {
    /// From the command line.
    Asked(f64),
    /// From the file.
    Suggested(f64),
    /// The smallest step.
    Smallest,
}

pub(super) fn check(
    raw: &RawSystem,
    overrides: &Overrides,
    opened: &[Opened],
    findings: &mut Findings,
) -> Option<Timing> {
    let steps = steps(raw, overrides, opened, findings)?;
    let unknown_steps = steps.is_none();
    let steps = steps.unwrap_or_else(|| vec![Step::whole(UNKNOWN); opened.len()]);
    let stepped: Vec<Stepped<'_>> = opened.iter().zip(&steps).map(stepped).collect();
    let span = span(raw, overrides, opened).and_then(|(start, stop)| {
        let wanted = match (overrides.output_interval, raw.master.output_interval) {
            (Some(seconds), _) => Interval::Asked(seconds),
            (None, Some(seconds)) => Interval::Suggested(seconds),
            (None, None) => Interval::Smallest,
        };
        check_span(&stepped, start, stop, wanted)
    });
    let span = findings.note(span.map_err(|e| match (misfit(&stepped), &raw.experiment) {
        (Some(component), _) => raw.components[component].place.mark(e),
        (None, Some(place)) => place.mark(e),
        (None, None) => e.at(&raw.file),
    }));
    Some(Timing { span: span?, steps, unknown_steps })
}

fn stepped<'a>((opened, step): (&'a Opened, &Step)) -> Stepped<'a> {
    let fmu = opened.fmu();
    let varies = fmu.is_none_or(|fmu| fmu.varies(opened.interface));
    Stepped { name: &opened.name, step: *step, varies, fmu: fmu.is_some() }
}

/// The first FMU whose step has no common base with those before it, if one is needed.
fn misfit(stepped: &[Stepped<'_>]) -> Option<usize> {
    let fmus = || stepped.iter().filter(|component| component.fmu);
    let smallest = fmus().map(|component| component.step).min()?;
    let mut base = fmus().next()?.step;
    let mut found = stepped.iter().enumerate().filter(|(_, component)| component.fmu);
    let found = found.find(|(_, component)| {
        base = base.gcd(component.step);
        !is_base(base, smallest)
    });
    found.filter(|_| fmus().count() < stepped.len()).map(|(place, _)| place)
}

/// Whether a common divisor of steps is long enough to do something at each multiple of it.
pub(in crate::system) fn is_base(base: Step, smallest: Step) -> bool {
    base.seconds() * FINEST >= smallest.seconds() * (1.0 - 1e-9)
}

/// The step of a component: from the command line, from its annotation, from the default experiment
/// of its FMU, from the annotation of the system, or the smallest of the others. `None` inside:
/// there is none at all.
fn steps(
    raw: &RawSystem,
    overrides: &Overrides,
    opened: &[Opened],
    findings: &mut Findings,
) -> Option<Option<Vec<Step>>> {
    let mut steps: Vec<Option<Step>> = Vec::new();
    let mut sound = true;
    for (component, opened) in raw.components.iter().zip(opened) {
        let default = || opened.description().and_then(|d| d.experiment.step);
        let seconds = (overrides.step_of(&component.name).or(component.step))
            .or_else(default)
            .or(raw.master.step);
        let name = format!("the step of '{}'", component.name);
        let step = seconds.map(|s| time::step_from_seconds(s, &name)).transpose();
        let step = step.map_err(|e| component.place.mark(e));
        let step = findings.note(step);
        sound &= step.is_some();
        steps.push(step.flatten());
    }
    let smallest = steps.iter().flatten().min().copied();
    if !sound || opened.iter().any(|o| o.model.is_none()) {
        return None;
    }
    let Some(smallest) = smallest else { return Some(None) };
    let base = steps.iter().flatten().fold(smallest, |base, &step| base.gcd(step));
    let functions = opened.iter().map(|o| matches!(o.model, Some(Model::Function(_))));
    // A function changes whenever one of its inputs does.
    let step = |(step, function): (Option<Step>, bool)| match function {
        true => base,
        false => step.unwrap_or(smallest),
    };
    Some(Some(steps.into_iter().zip(functions).map(step).collect()))
}

fn span(raw: &RawSystem, overrides: &Overrides, opened: &[Opened]) -> Result<(Time, Time)> {
    let start = overrides.start_time.or(raw.start).unwrap_or(0.0);
    let suggested =
        opened.iter().filter_map(|o| o.description()?.experiment.stop).max_by(f64::total_cmp);
    let suggested = suggested.filter(|stop| *stop > start);
    let stop = overrides.stop_time.or(raw.stop).or(suggested);
    let stop = stop.map(|stop| time::from_seconds(stop, "the stop time")).transpose()?;
    Ok((time::from_seconds(start, "the start time")?, stop.unwrap_or(Time::NEVER)))
}

/// Checks that the steps are consistent, and determines how the run ends.
pub(in crate::system) fn check_span(
    stepped: &[Stepped<'_>],
    start: Time,
    stop: Time,
    wanted: Interval,
) -> Result<Span> {
    // Functions step by the common base of the others.
    let fmus = || stepped.iter().filter(|component| component.fmu);
    let only_functions = fmus().next().is_none();
    let steps = || stepped.iter().filter(|c| c.fmu || only_functions).map(|c| c.step);
    let smallest = steps().min().unwrap_or(Step::whole(UNKNOWN));
    let base = steps().fold(smallest, Step::gcd);
    let has_base = is_base(base, smallest);
    let mut span = Span {
        start,
        stop,
        output_interval: smallest,
        shortened: false,
        warnings: Vec::new(),
        notes: Vec::new(),
    };
    if !has_base && fmus().count() < stepped.len() {
        return Err(Error::new(Code::Timing, "the step sizes are inconsistent")
            .why(format!(
                "a function changes at each multiple of their greatest common divisor, {base}; the \
                 smallest is {smallest}"
            ))
            .help(
                "choose steps that are multiples of one another, with --step COMPONENT=SECONDS",
            ));
    }
    if stop <= start {
        return Err(Error::new(Code::Timing, format!("the run would go from {start} to {stop}"))
            .help("choose a stop time after the start time"));
    }
    if stop < Time::NEVER && !steps().any(|step| step.divides(stop - start)) {
        end_between_steps(&mut span, stepped, smallest)?;
    }
    match wanted {
        Interval::Smallest => {}
        Interval::Asked(seconds) => {
            let interval = time::step_from_seconds(seconds, "the output interval")?;
            if has_base && base.parts_of(interval).is_none() {
                return Err(off_base(interval, base));
            }
            span.output_interval = interval;
        }
        Interval::Suggested(seconds) => {
            let interval = time::step_from_seconds(seconds, "the output interval")?;
            span.output_interval = match base.parts_of(interval) {
                None if has_base => base.times(base.count(interval.rounded()) + 1),
                _ => interval,
            };
            if span.output_interval != interval {
                span.notes.push(format!(
                    "recorded every {} instead of {interval}, which is not a multiple of {base}, \
                     the common base of the step sizes",
                    span.output_interval
                ));
            }
        }
    }
    Ok(span)
}

/// No step ends at the stop time: the last ones are shorter, or the run ends earlier.
fn end_between_steps(span: &mut Span, stepped: &[Stepped<'_>], smallest: Step) -> Result<()> {
    let (start, stop) = (span.start, span.stop);
    let fmus = || stepped.iter().filter(|component| component.fmu);
    if fmus().all(|component| !component.varies) && fmus().next().is_some() {
        let ends = fmus().map(|c| start + c.step.multiple(c.step.count(stop - start)));
        let last = ends.max().unwrap_or(start);
        if last <= start {
            let what =
                format!("the run from {start} to {stop} is shorter than a step of {smallest}");
            return Err(Error::new(Code::Timing, what)
                .why("no FMU declares canHandleVariableCommunicationStepSize")
                .help(format!(
                    "use --stop-time {} or later",
                    (start + smallest.rounded()).seconds()
                )));
        }
        span.warnings.push(format!(
            "the run ends at {last}, with the last whole step before {stop}: no FMU declares \
             canHandleVariableCommunicationStepSize, which a shorter step needs"
        ));
        span.stop = last;
        return Ok(());
    }
    span.shortened = true;
    for Stepped { name, step, .. } in stepped.iter().filter(|component| !component.varies) {
        span.warnings.push(format!(
            "the last step of '{name}' ends at {}, its outputs stay from there to {stop}: its FMU \
             does not declare canHandleVariableCommunicationStepSize, which a shorter step needs",
            start + step.multiple(step.count(stop - start))
        ));
    }
    Ok(())
}

fn off_base(interval: Step, base: Step) -> Error {
    let below = base.count(interval.rounded());
    let nearest = if below > 0 {
        format!("take {} or {}", base.times(below), base.times(below + 1))
    } else {
        format!("use {base} or a multiple of it")
    };
    Error::new(Code::Timing, format!("the output interval is {interval}"))
        .why(format!("it is not a multiple of {base}, the common base of the step sizes"))
        .help(nearest)
}
