//! What connected inputs do during a step: hold a value or change linearly.
//!
//! Linear inputs need continuous Reals at both ends, and a component that supports it: model
//! exchange always (we integrate it), co-simulation if the FMU declares canInterpolateInputs. Other
//! inputs hold their value, which is noted if linear was requested.

use super::{Connection, Model, System};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_import::{InterfaceType, Kind, Variability};

/// What an input does during a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Input {
    /// It keeps one value: that of the start of the step, or if fresh that of its end.
    #[default]
    Hold,
    /// It moves: with the slope of its source, or if fresh from one value to the other.
    Linear,
}

impl std::str::FromStr for Input {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "hold" => Ok(Input::Hold),
            "linear" => Ok(Input::Linear),
            _ => Err(format!("'{text}' is neither hold nor linear")),
        }
    }
}

/// Decides for each connection; notes the components that hold despite the request.
pub(super) fn apply(system: &mut System, requests: &[(String, Input)]) -> Result<()> {
    let names: Vec<String> = system.connections().iter().map(|c| system.port_name(c.to)).collect();
    let mut problems = Vec::new();
    for (request, _) in requests.iter().filter(|(request, _)| !request.is_empty()) {
        if !names.iter().any(|name| names::matches(request, name)) {
            problems.push(
                Error::new(Code::UnknownName, format!("'{request}' is not a connected input"))
                    .maybe_help(names::did_you_mean(request, names.iter().map(String::as_str))),
            );
        }
    }
    Error::all(problems)?;
    let mut unable: Vec<&str> = Vec::new();
    let mut linear = Vec::with_capacity(names.len());
    for (connection, name) in system.connections().iter().zip(&names) {
        let fits = |request: &str| request.is_empty() || names::matches(request, name);
        let wanted = requests.iter().rev().find(|(request, _)| fits(request));
        let wanted = wanted.is_some_and(|(_, input)| *input == Input::Linear);
        let receiver = &system.components()[connection.to.component];
        // A function follows immediately; its own outputs may move.
        let function = matches!(receiver.model, Model::Function(_));
        let moves = wanted && !function && smooth(system, connection);
        let able = match &receiver.model {
            Model::Fmu(fmu) => {
                receiver.interface == InterfaceType::ModelExchange
                    || fmu.interface(receiver.interface).is_ok_and(|i| i.interpolates_inputs)
            }
            Model::Signals(_) | Model::Function(_) => false,
        };
        if moves && !able && !unable.contains(&receiver.name.as_str()) {
            unable.push(&receiver.name);
        }
        linear.push(moves && able);
    }
    let notes: Vec<String> = unable
        .iter()
        .map(|name| {
            format!("'{name}' holds its inputs: its FMU does not declare canInterpolateInputs")
        })
        .collect();
    system.linear = linear;
    system.notes.extend(notes);
    Ok(())
}

/// Whether both ends are continuous Reals.
fn smooth(system: &System, connection: &Connection) -> bool {
    [connection.from, connection.to].iter().all(|port| {
        let model = &system.components()[port.component].model;
        match (model, model.description()) {
            (Model::Signals(signals), _) => *signals.kind(port.variable) == Kind::Real,
            (_, Some(description)) => {
                let variable = &description.variables[port.variable];
                variable.kind == Kind::Real && variable.variability == Variability::Continuous
            }
            (_, None) => false,
        }
    })
}
