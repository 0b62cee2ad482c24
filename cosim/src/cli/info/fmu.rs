//! The description of an FMU as text or JSON.

use cosim::fmi::description::{Experiment, Interface};
use cosim::fmi::{Causality, Description, Fmu, Kind, Variable};
use cosim::shown;
use serde_json::{Value, json};

pub(super) fn text(fmu: &Fmu) -> Vec<String> {
    let description = fmu.description();
    let mut lines = vec![description.model_name.clone()];
    if !description.description.is_empty() {
        lines.push(format!("  {}", description.description));
    }
    let kinds = [
        description.co_simulation.is_some().then_some("co-simulation"),
        description.model_exchange.is_some().then_some("model exchange"),
    ];
    let kinds: Vec<&str> = kinds.into_iter().flatten().collect();
    lines.push(format!("  FMI 2.0, {}; by {}", kinds.join(" and "), description.generation_tool));
    let Experiment { start, stop, step, .. } = description.experiment;
    let shown = |seconds: Option<f64>| seconds.map_or("-".to_owned(), |s| format!("{s} s"));
    let (start, stop, step) = (shown(start), shown(stop), shown(step));
    lines.push(format!("  default experiment: start {start}, stop {stop}, step {step}"));
    let platforms = fmu.platforms();
    lines.push(match platforms.is_empty() {
        true => "  no binaries".to_owned(),
        false => format!("  binaries for {}", platforms.join(", ")),
    });
    for (name, interface) in [
        ("co-simulation", &description.co_simulation),
        ("model exchange", &description.model_exchange),
    ] {
        if let Some(interface) = interface {
            lines.push(format!("  {name}: its state {}", state(interface)));
        }
    }
    for (title, causality) in [
        ("parameters", Causality::Parameter),
        ("inputs", Causality::Input),
        ("outputs", Causality::Output),
        ("calculated parameters", Causality::CalculatedParameter),
        ("locals", Causality::Local),
    ] {
        list(description, title, causality, &mut lines);
    }
    lines
}

/// What can be done with the state of an instance.
fn state(interface: &Interface) -> &'static str {
    match (interface.get_and_set_state, interface.serialize_state) {
        (true, true) => "can be saved, and serialized for snapshots",
        (true, false) => "can be saved, but not serialized: no snapshots",
        (false, _) => "cannot be saved: no snapshots",
    }
}

fn list(description: &Description, title: &str, causality: Causality, lines: &mut Vec<String>) {
    let chosen: Vec<&Variable> =
        description.variables.iter().filter(|v| v.causality == causality).collect();
    if chosen.is_empty() {
        return;
    }
    lines.push(format!("{title} ({})", chosen.len()));
    let width = shown::width(chosen.iter().map(|v| v.name.as_str()));
    for variable in chosen {
        let start = variable.start.as_ref().map_or(String::new(), |v| format!(" = {v}"));
        let unit = variable.unit.as_ref().map_or(String::new(), |u| format!(" {u}"));
        let kind = variable.kind.name();
        let line =
            format!("  {:width$}  {kind}{start}{unit}  {}", variable.name, variable.description);
        lines.push(line.trim_end().to_owned());
    }
}

pub(super) fn json(fmu: &Fmu) -> Value {
    let description = fmu.description();
    let experiment = description.experiment;
    json!({
        "modelName": description.model_name,
        "description": description.description,
        "fmiVersion": "2.0",
        "guid": description.guid,
        "generationTool": description.generation_tool,
        "coSimulation": description.co_simulation.is_some(),
        "modelExchange": description.model_exchange.is_some(),
        "platforms": fmu.platforms(),
        "capabilities": {
            "coSimulation": description.co_simulation.as_ref().map(capabilities),
            "modelExchange": description.model_exchange.as_ref().map(capabilities),
        },
        "defaultExperiment": {
            "startTime": experiment.start,
            "stopTime": experiment.stop,
            "stepSize": experiment.step,
            "tolerance": experiment.tolerance,
        },
        "variables": description.variables.iter().enumerate()
            .map(|(position, v)| variable(description, position, v))
            .collect::<Vec<_>>(),
    })
}

/// Under FMI's names.
fn capabilities(interface: &Interface) -> Value {
    json!({
        "canGetAndSetFMUstate": interface.get_and_set_state,
        "canSerializeFMUstate": interface.serialize_state,
        "needsExecutionTool": interface.needs_execution_tool,
    })
}

fn variable(description: &Description, position: usize, variable: &Variable) -> Value {
    let mut object = json!({
        "name": variable.name,
        "type": variable.kind.name(),
        "causality": variable.causality.name(),
        "variability": variable.variability.name(),
        "description": variable.description,
        "start": variable.start.as_ref().map(value),
        "unit": variable.unit,
    });
    if let Kind::Enumeration(items) = &variable.kind {
        object["items"] = items.iter().map(|(name, value)| json!([name, value])).collect();
    }
    if variable.causality == Causality::Input {
        object["directFeedThrough"] = description.feeds_through(position).into();
    }
    object
}

fn value(value: &cosim::fmi::Value) -> Value {
    match value {
        cosim::fmi::Value::Real(value) => json!(value),
        cosim::fmi::Value::Integer(value) => json!(value),
        cosim::fmi::Value::Boolean(value) => json!(value),
        cosim::fmi::Value::String(value) => json!(value),
    }
}
