//! The parts of a system as text or JSON.

use cosim::shown;
use cosim::system::{Component, Model};
use cosim::{System, Time};
use serde_json::{Value, json};

/// The name of the model and its file.
fn model(component: &Component) -> (String, String) {
    match &component.model {
        Model::Fmu(fmu) => (fmu.description().model_name.clone(), fmu.path().display().to_string()),
        Model::Signals(_) => ("signals".to_owned(), String::new()),
        Model::Function(function) => (format!("sum of {}", function.inputs()), String::new()),
    }
}

pub(super) fn text(system: &System) -> Vec<String> {
    let mut lines = vec![format!(
        "{}: {} to {}, {}, recorded every {}",
        system.name(),
        system.start_time(),
        match system.stop_time() {
            Time::NEVER => "no stop time".to_owned(),
            stop => stop.to_string(),
        },
        system.algorithm(),
        system.output_interval()
    )];
    let components = system.components();
    lines.push(format!("components ({})", components.len()));
    let width = shown::width(components.iter().map(|c| c.name.as_str()));
    for component in components {
        let (model, file) = model(component);
        lines
            .push(format!("  {:width$}  {model}, step {}  {file}", component.name, component.step));
    }
    lines.push(format!("connections ({})", system.connections().len()));
    for connection in system.connections() {
        let (from, to) = (system.port_name(connection.from), system.port_name(connection.to));
        lines.push(format!("  {from} -> {to}"));
    }
    lines
}

pub(super) fn json(system: &System) -> Value {
    json!({
        "name": system.name(),
        "startTime": system.start_time().seconds(),
        "stopTime": (system.stop_time() < Time::NEVER).then(|| system.stop_time().seconds()),
        "outputInterval": system.output_interval().seconds(),
        "algorithm": system.algorithm().to_string(),
        "components": system.components().iter().map(|component| {
            let (model, file) = model(component);
            json!({
                "name": component.name,
                "model": model,
                "file": file,
                "stepSize": component.step.seconds(),
            })
        }).collect::<Vec<_>>(),
        "connections": system.connections().iter().map(|c| json!({
            "from": system.port_name(c.from),
            "to": system.port_name(c.to),
        })).collect::<Vec<_>>(),
        "warnings": system.warnings(),
        "notes": ([system.notes(), system.sampled_loops()].concat()),
    })
}
