//! Checks that components support the options of a run; all that do not are reported.

use super::{Component, Model, System};
use cosim_base::error::{Code, Error, Result};
use cosim_import::Fmu;

/// Checks step control and retries.
pub(super) fn check(system: &System) -> Result<()> {
    let mut problems = Vec::new();
    if let Some(tolerance) = system.step_control {
        if !(tolerance > 0.0 && tolerance < 1.0) {
            let what = format!("the tolerance of the step control is {tolerance}");
            let why = "it is relative and must lie between 0 and 1";
            problems.push(Error::new(Code::Timing, what).why(why));
        }
        for (component, fmu) in fmus(system) {
            problems.extend(unable(component, fmu, "follow a step control"));
        }
    } else if system.retries > 0 {
        // A component that cannot go back may never have to: there is an error if it does.
        if !fmus(system).any(|(component, fmu)| component.can_repeat(fmu)) {
            problems.extend(fmus(system).filter_map(|(c, fmu)| unable(c, fmu, "repeat steps")));
        }
    }
    Error::all(problems)
}

impl Component {
    /// Whether its FMU can go back to the start of a step and make a shorter one.
    pub(crate) fn can_repeat(&self, fmu: &Fmu) -> bool {
        unable(self, fmu, "").is_none()
    }
}

fn fmus(system: &System) -> impl Iterator<Item = (&Component, &Fmu)> {
    system.components.iter().filter_map(|component| match &component.model {
        Model::Fmu(fmu) => Some((component, &**fmu)),
        Model::Signals(_) | Model::Function(_) => None,
    })
}

/// Why a component cannot go back and make a step of a different length.
fn unable(component: &Component, fmu: &Fmu, what: &str) -> Option<Error> {
    let interface = fmu.interface(component.interface).ok()?;
    let fixed = !fmu.varies(component.interface);
    let missing = match (interface.get_and_set_state, fixed) {
        (true, false) => return None,
        (true, true) => "canHandleVariableCommunicationStepSize",
        (false, false) => "canGetAndSetFMUstate",
        (false, true) => "canGetAndSetFMUstate and canHandleVariableCommunicationStepSize",
    };
    let error = Error::new(Code::Timing, format!("'{}' cannot {what}", component.name));
    Some(error.at(fmu.path()).why(format!("its FMU does not declare {missing}")))
}
