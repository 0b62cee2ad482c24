//! One FMU as a system of its own, with inputs driven by signals of a file.

use std::path::Path;
use std::sync::Arc;

use super::check::{self, Interval, Names, Span, Stepped};
use super::order::Order;
use super::{Algorithm, Component, Connection, Model, Overrides, Port, System, abilities, input};
use crate::signals::{Signal, Signals, Table};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::time::{self, Step};
use cosim_import::{Causality, Description, Fmu, InterfaceType, Kind, Value, Variability};

/// Steps per run if neither the FMU nor the user sets a step size.
const DEFAULT_STEPS: f64 = 500.0;

impl System {
    /// A system of one FMU, whose variables are named without a prefix. The columns of `inputs`
    /// drive the inputs with the same names.
    pub fn single(file: &Path, overrides: &Overrides, inputs: Option<Table<'_>>) -> Result<Self> {
        let fmu = Fmu::open(file)?;
        let interface = fmu.choose(overrides.interface_of(""))?;
        if !overrides.execution_tools {
            check::needs_no_tool(&fmu, interface, &fmu.description().model_name)?;
        }
        let solver = overrides.settings(fmu.description().experiment.tolerance)?;
        let names = Names::single(&fmu);
        let description = fmu.description();
        let (span, step) = timing(&fmu, interface, overrides)?;
        let mut problems = Vec::new();
        let start_values = start_values(&names, overrides, &mut problems);
        let columns = check::columns(&names, &overrides.output_variables);
        let columns = columns.unwrap_or_else(|problem| {
            problems.push(problem);
            Vec::new()
        });
        Error::all(problems)?;
        let mut warnings = span.warnings;
        warnings.extend(check::without_any(&columns, &overrides.output_variables));
        let mut components = vec![Component {
            name: description.model_name.clone(),
            model: Model::Fmu(fmu.clone()),
            file: Some(file.to_owned()),
            interface,
            step,
            start_values,
            worker: None,
        }];
        let mut connections = Vec::new();
        if let Some(table) = inputs {
            let signals = signals(description, &table)?;
            connections = connect(description, &signals);
            let model = Model::Signals(Arc::new(signals));
            let name = "input file".to_owned();
            let start_values = Vec::new();
            let (file, worker) = (None, None);
            components.push(Component { name, model, file, interface, step, start_values, worker });
        }
        // Held: an input keeps the value at the start of the step, as in fmusim and FMPy.
        let algorithm = Algorithm::Jacobi;
        let mut system = System {
            raw: None,
            name: description.model_name.clone(),
            order: Order::new(algorithm, &components, &connections),
            components,
            connections,
            ports: Vec::new(),
            linear: Vec::new(),
            step_control: overrides.step_control,
            retries: overrides.retries,
            columns,
            start: span.start,
            stop: span.stop,
            output_interval: span.output_interval,
            shortened: span.shortened,
            unknown_steps: false,
            algorithm,
            solver,
            tolerance: overrides.tolerance,
            logging: overrides.logging.clone(),
            warnings,
            notes: span.notes,
            sampled: Vec::new(),
        };
        input::apply(&mut system, &overrides.inputs)?;
        abilities::check(&system)?;
        Ok(system)
    }
}

fn timing(fmu: &Fmu, interface: InterfaceType, overrides: &Overrides) -> Result<(Span, Step)> {
    let default = fmu.description().experiment;
    let start = overrides.start_time.or(default.start).unwrap_or(0.0);
    let suggested = default.stop.filter(|stop| *stop > start).unwrap_or(start + 1.0);
    let stop = overrides.stop_time.unwrap_or(suggested);
    let name = "the step size";
    let of = |seconds: f64| time::step_from_seconds(seconds, name);
    let interval = overrides.output_interval;
    // A run that goes backwards is reported as such.
    let duration = if stop > start { stop - start } else { 1.0 };
    let step = match (overrides.step_of(""), default.step, interval) {
        (Some(step), _, _) => of(step)?,
        // The FMU's own step is only a suggestion: recording may need finer steps.
        (None, Some(step), Some(interval)) => {
            let (step, interval) = (of(step)?, of(interval)?);
            match step.parts_of(interval) {
                Some(_) => step,
                None => interval.part(step.count(interval.rounded()) + 1),
            }
        }
        (None, step, interval) => of(step.or(interval).unwrap_or(duration / DEFAULT_STEPS))?,
    };
    let start = time::from_seconds(start, "the start time")?;
    let stop = time::from_seconds(stop, "the stop time")?;
    let name = &fmu.description().model_name;
    let stepped = Stepped { name, step, varies: fmu.varies(interface), fmu: true };
    let interval = interval.map_or(Interval::Smallest, Interval::Asked);
    Ok((check::check_span(&[stepped], start, stop, interval)?, step))
}

fn start_values(
    names: &Names,
    overrides: &Overrides,
    problems: &mut Vec<Error>,
) -> Vec<(usize, Value)> {
    let mut values = Vec::new();
    for (name, text) in &overrides.start_values {
        match check::start_value(names, name, text) {
            Ok(found) => values.extend(found.map(|(port, value)| (port.variable, value))),
            Err(problem) => problems.push(problem),
        }
    }
    values
}

fn signals(description: &Description, table: &Table<'_>) -> Result<Signals> {
    let mut signals = Vec::new();
    let mut problems = Vec::new();
    for (name, values) in &table.columns {
        let inputs = || description.variables.iter().filter(|v| v.causality == Causality::Input);
        let wrong = |code| Error::new(code, format!("the input file's column '{name}'"));
        match (inputs().find(|v| v.name == *name), values) {
            (None, _) => problems.push(
                wrong(Code::UnknownName)
                    .why(format!("'{}' has no such input", description.model_name))
                    .maybe_help(names::did_you_mean(name, inputs().map(|v| v.name.as_str()))),
            ),
            (Some(input), _) if input.kind == Kind::String => problems.push(
                wrong(Code::Parameter)
                    .why("the input is a String; files drive only inputs of numbers")
                    .help(format!("set it for the whole run: --start-value '{name}=TEXT'")),
            ),
            (Some(input), Err(text)) => problems.push(wrong(Code::Parameter).why(format!(
                "it has {text}, which is not a number; the input is of the type {}",
                input.kind.name()
            ))),
            (Some(input), Ok(values)) => signals.push(Signal {
                name: input.name.clone(),
                kind: input.kind.clone(),
                continuous: input.variability == Variability::Continuous,
                values: values.to_vec(),
            }),
        }
    }
    Error::all(problems)?;
    Signals::new(table.time, signals)
}

fn connect(description: &Description, signals: &Signals) -> Vec<Connection> {
    let ends = signals.names().iter().map(|name| description.position(name));
    ends.enumerate()
        .filter_map(|(signal, input)| {
            Some(Connection {
                from: Port { component: 1, variable: signal },
                to: Port { component: 0, variable: input? },
                conversion: None,
            })
        })
        .collect()
}
