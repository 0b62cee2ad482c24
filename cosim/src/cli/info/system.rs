//! A system for people and programs: who steps when, and which values come a step late.

use cosim::System;
use cosim::system::{Algorithm, Component, Model};
use serde_json::{Value, json};

fn algorithm(system: &System) -> &'static str {
    match system.algorithm() {
        Algorithm::Jacobi => "jacobi",
        Algorithm::GaussSeidel => "gauss-seidel",
    }
}

/// The model's name and its file.
fn model(component: &Component) -> (String, String) {
    match &component.model {
        Model::Fmu(fmu) => (fmu.description().model_name.clone(), fmu.path().display().to_string()),
        Model::Signals(_) => ("signals".to_owned(), String::new()),
    }
}

pub(super) fn text(system: &System) -> String {
    let mut lines = vec![format!(
        "{}: {} to {}, {}, recorded every {}",
        system.name(),
        system.start_time(),
        system.stop_time(),
        algorithm(system),
        system.output_interval()
    )];
    lines.push("components in stepping order".to_owned());
    let components = system.order().sequence.iter().map(|&c| &system.components()[c]);
    let width = components.clone().map(|c| c.name.len()).max().unwrap_or(0);
    for component in components {
        let (model, file) = model(component);
        lines
            .push(format!("  {:width$}  {model}, step {}  {file}", component.name, component.step));
    }
    lines.push("connections (=> without delay, -> held from the step's beginning)".to_owned());
    for (connection, &fresh) in system.connections().iter().zip(&system.order().fresh) {
        let arrow = if fresh { "=>" } else { "->" };
        let (from, to) = (system.port_name(connection.from), system.port_name(connection.to));
        lines.push(format!("  {from} {arrow} {to}"));
    }
    lines.join("\n")
}

pub(super) fn json(system: &System) -> Value {
    let order = system.order();
    let name = |&c: &usize| system.components()[c].name.as_str();
    json!({
        "name": system.name(),
        "startTime": system.start_time().seconds(),
        "stopTime": system.stop_time().seconds(),
        "outputInterval": system.output_interval().seconds(),
        "algorithm": algorithm(system),
        "components": system.components().iter().map(|component| {
            let (model, file) = model(component);
            json!({
                "name": component.name,
                "model": model,
                "file": file,
                "stepSize": component.step.seconds(),
            })
        }).collect::<Vec<_>>(),
        "order": order.sequence.iter().map(name).collect::<Vec<_>>(),
        "connections": system.connections().iter().zip(&order.fresh).map(|(c, fresh)| json!({
            "from": system.port_name(c.from),
            "to": system.port_name(c.to),
            "delayed": !fresh,
        })).collect::<Vec<_>>(),
        "loops": order.loops.iter()
            .map(|l| l.members.iter().map(name).collect::<Vec<_>>())
            .collect::<Vec<_>>(),
        "warnings": system.warnings(),
        "notes": system.notes(),
    })
}
