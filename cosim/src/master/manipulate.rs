//! What acts on a run: faults, scenarios, a pace. Manipulators write; what only watches is an
//! `Observer`.
//!
//! A manipulator says when it acts next. At that instant all steps that end there are made and
//! recorded, then it acts; every step that ends later sees what it did. (A step is made as a
//! whole when its end is reached, so a step already begun sees it from its beginning.)

use serde::{Deserialize, Serialize};

use super::drive::Drive;
use super::engine::Engine;
use super::patched_slave::{Patch, PatchedSlave, SharedPatches};
use crate::error::{Code, Error, Result};
use crate::fmi::{Causality, Kind, Value, Variability, Variable};
use crate::observe::Stop;
use crate::system::{Port, System};
use crate::time::Time;

/// Acts on a run at instants that it chooses.
pub trait Manipulator {
    /// Before the run, to check names. A resumed run has done everything up to and at `resumed`.
    fn start(&mut self, system: &System, resumed: Option<Time>) -> Result<()> {
        let _ = (system, resumed);
        Ok(())
    }

    /// When it acts next, if ever; asked again after each action.
    fn next(&self) -> Option<Time>;

    /// Acts. An error ends the run.
    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()>;
}

/// What a manipulator can do to a running system. Variables are named as in the results.
pub struct Controls<'a> {
    pub(super) system: &'a System,
    pub(super) driven: &'a mut dyn Drive,
    pub(super) now: Time,
    pub(super) stop: Option<Stop>,
}

impl Controls<'_> {
    /// From now on the variable has this value, whatever computes or drives it.
    pub fn set(&mut self, variable: &str, value: f64) -> Result<()> {
        self.change(variable, Some(Patch::Override(value)))
    }

    /// From now on this is added to the variable.
    pub fn bias(&mut self, variable: &str, bias: f64) -> Result<()> {
        self.change(variable, Some(Patch::Bias(bias)))
    }

    /// The variable is again what it was; one that nothing drives gets its start value.
    pub fn release(&mut self, variable: &str) -> Result<()> {
        self.change(variable, None)
    }

    /// Ends the run here.
    pub fn end(&mut self, reason: Stop) {
        self.stop = Some(reason);
    }

    fn change(&mut self, name: &str, patch: Option<Patch>) -> Result<()> {
        let port = self.system.manipulable(name)?;
        let start = start_of(self.system, port);
        let change = Change { variable: port.variable, patch, start };
        self.driven.change(port.component, change, self.now)
    }
}

/// A manipulation of one variable of a component.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Change {
    /// Position of the variable.
    pub variable: usize,
    /// What is done to it; nothing any more without.
    pub patch: Option<Patch>,
    /// What it was at the start.
    pub start: f64,
}

impl Engine {
    /// Changes a variable from now on.
    pub(crate) fn change(&mut self, component: usize, change: Change) -> Result<()> {
        let Change { variable, patch, start } = change;
        if !self.plan.nodes[component].exchanges(variable) {
            self.slaves[component]
                .assign(variable, patch.map_or(start, |patch| patch.of(start)))?;
        }
        // What was assigned is kept in the list too, for a snapshot.
        self.patch(component, variable, patch);
        Ok(())
    }

    /// Replaces what is done to a variable.
    pub(super) fn patch(&mut self, component: usize, variable: usize, patch: Option<Patch>) {
        let shared = self.patches_of(component);
        let mut patches = shared.borrow_mut();
        patches.retain(|(patched, _)| *patched != variable);
        patches.extend(patch.map(|patch| (variable, patch)));
    }

    fn patches_of(&mut self, component: usize) -> SharedPatches {
        if let Some(patches) = &self.patches[component] {
            return patches.clone();
        }
        let patches = SharedPatches::default();
        self.patches[component] = Some(patches.clone());
        let inner = self.slaves.remove(component);
        let patched = PatchedSlave::new(inner, &self.plan.nodes[component], patches.clone());
        self.slaves.insert(component, Box::new(patched));
        self.steps.leave(component, &self.plan);
        patches
    }
}

impl System {
    /// The port of a variable that may be manipulated, or why it may not.
    pub(crate) fn manipulable(&self, name: &str) -> Result<Port> {
        let port = self.port(name)?;
        let Some(description) = self.components()[port.component].model.description() else {
            return Err(Error::new(Code::Parameter, format!("'{name}' cannot be set"))
                .why("it is a signal of a file"));
        };
        let variable = &description.variables[port.variable];
        let why = if variable.kind == Kind::String {
            "it is a String; only numbers and Booleans are set while a system runs"
        } else if may_change(variable) {
            return Ok(port);
        } else {
            "only inputs, outputs and tunable parameters are set while a system runs"
        };
        Err(Error::new(Code::Parameter, format!("'{name}' cannot be set")).why(why))
    }
}

fn may_change(variable: &Variable) -> bool {
    match variable.causality {
        Causality::Input | Causality::Output => true,
        Causality::Parameter => variable.variability == Variability::Tunable,
        _ => false,
    }
}

/// The value that a run begins with.
fn start_of(system: &System, port: Port) -> f64 {
    let component = &system.components()[port.component];
    let given = component.start_values.iter().rev().find(|(v, _)| *v == port.variable);
    let description = component.model.description();
    let declared = description.and_then(|d| d.variables[port.variable].start.as_ref());
    match given.map(|(_, value)| value).or(declared) {
        Some(Value::Real(value)) => *value,
        Some(Value::Integer(value)) => f64::from(*value),
        Some(Value::Boolean(value)) => f64::from(u8::from(*value)),
        Some(Value::String(_)) | None => 0.0,
    }
}
