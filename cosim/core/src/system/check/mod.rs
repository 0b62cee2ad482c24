//! The single check that turns raw structures into a [`System`]; every problem found is reported.

mod columns;
mod components;
mod connection_notes;
mod connections;
mod conversion;
mod lookup;
mod parameters;
mod places;
mod ports;
mod timing;

use std::sync::Arc;

use places::Places;
use timing::Timing;

use super::order::Order;
use super::raw::RawSystem;
use super::{Component, Overrides, System, abilities, input, loops};
use cosim_base::Warnings;
use cosim_base::error::{Error, Problems, Result};

pub(super) use columns::{columns, without_any};
pub(super) use components::{needs_no_tool, unknown_component};
pub(super) use lookup::Names;
pub(super) use parameters::start_value;
pub(super) use timing::{Interval, Span, Stepped, check_span, is_base};

/// Findings collected during the check.
struct Findings {
    problems: Problems,
    warnings: Warnings,
    notes: Vec<String>,
}

impl Findings {
    /// The value, or `None` after recording the problem.
    fn note<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|problem| self.problems.push(problem)).ok()
    }
}

/// Applies the overrides and checks everything; `problems` were found while reading.
pub(super) fn check(
    raw: Arc<RawSystem>,
    overrides: &Overrides,
    problems: Problems,
) -> Result<System> {
    let (warnings, notes) = (raw.warnings.clone(), raw.notes.clone());
    let mut findings = Findings { problems, warnings, notes };
    let opened = components::open(&raw, overrides, &mut findings);
    raw.fmus.forget_failures();
    let places = Places::of(&raw);
    let connections = connections::check(&raw, &places, &opened, &mut findings);
    let ports = ports::check(&raw, &places, &opened, &mut findings);
    let names = Names::of(&opened);
    let start_values = parameters::check(&raw, overrides, &opened, &names, &mut findings);
    let timing = timing::check(&raw, overrides, &opened, &mut findings);
    let suggested = opened.iter().filter_map(|o| o.description()?.experiment.tolerance);
    let solver = findings.note(overrides.settings(suggested.reduce(f64::min)));
    let wanted = match &overrides.output_variables[..] {
        [] => &raw.recorded,
        chosen => chosen,
    };
    let columns = findings.note(columns(&names, wanted));
    findings.problems.all()?;
    let (Some(timing), Some(solver), Some(columns)) = (timing, solver, columns) else {
        return Err(Error::new(crate::Code::Ssd, "the system is not valid").at(&raw.file));
    };
    findings.warnings.extend(without_any(&columns, wanted));
    let Timing { span, steps, unknown_steps } = timing;
    findings.warnings.extend(span.warnings);
    let components: Vec<Component> = opened
        .into_iter()
        .zip(steps)
        .zip(start_values)
        .zip(&raw.components)
        .filter_map(|(((opened, step), start_values), described)| {
            let (name, interface, model) = (opened.name, opened.interface, opened.model?);
            let worker = described.worker.clone();
            let file = opened.file;
            Some(Component { name, model, file, interface, step, start_values, worker })
        })
        .collect();
    let algorithm = overrides.algorithm.or(raw.master.algorithm).unwrap_or_default();
    let mut system = System {
        name: raw.name.clone(),
        raw: Some(raw),
        order: Order::new(algorithm, &components, &connections),
        components,
        connections,
        ports,
        linear: Vec::new(),
        step_control: overrides.step_control,
        retries: overrides.retries,
        columns,
        start: span.start,
        stop: span.stop,
        output_interval: span.output_interval,
        shortened: span.shortened,
        unknown_steps,
        algorithm,
        solver,
        tolerance: overrides.tolerance,
        logging: overrides.logging.clone(),
        warnings: findings.warnings.into_vec(),
        sampled: Vec::new(),
        notes: [findings.notes, span.notes].concat(),
    };
    loops::report(&mut system)?;
    input::apply(&mut system, &overrides.inputs)?;
    abilities::check(&system)?;
    Ok(system)
}
