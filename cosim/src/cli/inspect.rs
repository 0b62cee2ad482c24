//! `cosim inspect`: stepping order, and the delay of each connection with its reason; as text or as
//! a drawing.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use cosim::Result;
use cosim::System;
use cosim::shown;
use cosim::system::Delay;
use serde_json::{Value, json};

use super::changes::Changes;
use super::output::{print, print_lines};
use super::{drawing, messages};

/// Output format.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Shown {
    /// Text
    Text,
    /// JSON
    Json,
    /// A picture
    Svg,
    /// A graph for Graphviz
    Dot,
}

/// Show the stepping order, and the delay of each connection with its reason
#[derive(Args)]
pub(crate) struct Inspect {
    /// A .ssd, .ssp or OspSystemStructure.xml file, or the folder of the latter
    file: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Output format: text, JSON, a picture or a graph for Graphviz
    #[arg(long, value_enum, default_value_t = Shown::Text)]
    format: Shown,
}

impl Inspect {
    pub(crate) fn run(self) -> Result<()> {
        let system = System::load(&self.file, &self.changes.overrides())?;
        match self.format {
            Shown::Text => {
                messages::findings(&system, false);
                system.sampled_loops().iter().for_each(|text| messages::note(text));
                print_lines(&text(&system))
            }
            Shown::Json => print(&json(&system).to_string()),
            Shown::Svg => print(drawing::svg(&system).trim_end()),
            Shown::Dot => print(drawing::dot(&system).trim_end()),
        }
    }
}

fn name(system: &System, component: usize) -> &str {
    &system.components()[component].name
}

fn text(system: &System) -> Vec<String> {
    let mut lines = vec![format!("stepping order ({})", system.algorithm())];
    let sequence = &system.order().sequence;
    let width = shown::width(sequence.iter().map(|&c| name(system, c)));
    for (place, &c) in sequence.iter().enumerate() {
        let (name, step) = (name(system, c), system.components()[c].step);
        lines.push(format!("  {:>3}  {name:width$}  every {step}", place + 1));
    }
    lines.push(format!("connections ({})", system.connections().len()));
    // Adjacent connections with the same ends and the same delay share one explanation.
    let mut last = String::new();
    for (position, delay) in system.delays().iter().enumerate() {
        let ends = &system.connections()[position];
        let (from, to) = (ends.from.component, ends.to.component);
        let reason = system.explain(position, delay);
        let title = format!("  {} -> {}: {reason}", name(system, from), name(system, to));
        if title != last {
            lines.push(title.clone());
            last = title;
        }
        let variable = |port: cosim::system::Port| {
            system.components()[port.component].model.variable_name(port.variable).to_owned()
        };
        let conversion = ends.conversion.as_ref().map_or(String::new(), |c| format!("  ({c})"));
        lines.push(format!("    {} -> {}{conversion}", variable(ends.from), variable(ends.to)));
    }
    lines
}

fn json(system: &System) -> Value {
    let delays = system.delays();
    json!({
        "name": system.name(),
        "algorithm": system.algorithm().to_string(),
        "order": system.order().sequence.iter().map(|&c| json!({
            "name": name(system, c),
            "stepSize": system.components()[c].step.seconds(),
        })).collect::<Vec<_>>(),
        "connections": delays.iter().enumerate().map(|(position, delay)| {
            connection(system, position, delay)
        }).collect::<Vec<_>>(),
        "loops": system.order().loops.iter().map(|l| json!({
            "members": l.members.iter().map(|&m| name(system, m)).collect::<Vec<_>>(),
            "cut": l.held,
            "solved": l.solved,
        })).collect::<Vec<_>>(),
        "warnings": system.warnings(),
        "notes": ([system.notes(), system.sampled_loops()].concat()),
    })
}

fn connection(system: &System, position: usize, delay: &Delay) -> Value {
    let ends = &system.connections()[position];
    json!({
        "from": system.port_name(ends.from),
        "to": system.port_name(ends.to),
        "conversion": ends.conversion.as_ref().map(ToString::to_string),
        "late": delay.late.seconds(),
        "heldUpTo": delay.held.seconds(),
        "reason": system.explain(position, delay),
    })
}
