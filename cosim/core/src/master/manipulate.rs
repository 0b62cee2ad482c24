//! Actions on a run: faults, scenarios, a pace. Manipulators write; what only reads is an
//! `Observer`.
//!
//! A manipulator says when it acts next. At that instant, all steps that end there are made and
//! recorded, then it acts; every step that ends later sees the effect. (A step is made as a whole
//! when its end is reached, so a step already begun sees it from its start.)

use serde::{Deserialize, Serialize};

use super::drive::Drive;
use super::engine::Engine;
use super::patched_slave::{Patch, Patched, PatchedSlave, SharedPatches, release};
use crate::fault::{Acting, Way};
use crate::observe::Stop;
use crate::system::{Port, System};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::time::Time;
use cosim_import::{Basic, Causality, Kind, Scalar, Value, Variability, Variable};

/// Acts on a run at instants that it chooses.
pub trait Manipulator {
    /// Called before the run, to check names. A resumed run has done everything up to and at
    /// `resumed`.
    fn start(&mut self, system: &System, resumed: Option<Time>) -> Result<()> {
        let _ = (system, resumed);
        Ok(())
    }

    /// When it acts next, if ever; called again after each action.
    fn next(&self) -> Option<Time>;

    /// Acts. An error ends the run.
    fn act(&mut self, now: Time, controls: &mut Controls<'_>) -> Result<()>;
}

/// What a manipulator can do to a running system. Variables are named as in the results.
pub struct Controls<'a> {
    pub(super) system: &'a System,
    pub(super) driven: &'a mut dyn Drive,
    pub(super) now: Time,
    /// The values recorded last.
    pub(super) row: &'a [f64],
    pub(super) stop: Option<Stop>,
}

impl<'a> Controls<'a> {
    #[cfg(feature = "files")]
    pub(crate) fn system(&self) -> &'a System {
        self.system
    }

    /// For an engine that is stepped without recording.
    pub(crate) fn of(system: &'a System, engine: &'a mut Engine, now: Time) -> Self {
        Self { system, driven: engine, now, row: &[], stop: None }
    }
}

impl Controls<'_> {
    /// From now on the variable has this value, whatever computes or drives it.
    pub fn set(&mut self, variable: &str, value: f64) -> Result<()> {
        self.change(variable, Act::Patch(Patch::Override(value)))
    }

    /// From now on this is added to the variable.
    pub fn bias(&mut self, variable: &str, bias: f64) -> Result<()> {
        self.change(variable, Act::Patch(Patch::Bias(bias)))
    }

    /// Restores the variable; an unconnected one gets its start value. Faults stay.
    pub fn release(&mut self, variable: &str) -> Result<()> {
        self.change(variable, Act::Release)
    }

    /// Adds a fault to a variable, after those that already act on it.
    pub(crate) fn install(&mut self, variable: &str, fault: Acting) -> Result<()> {
        let way = self.system.way(self.system.manipulable(variable)?);
        let fault = Patch::Fault(Box::new(fault.installed(way, self.now)));
        self.change(variable, Act::Patch(fault))
    }

    /// The condition of the fault with this number holds.
    pub(crate) fn trigger(&mut self, variable: &str, number: u32) -> Result<()> {
        self.change(variable, Act::Trigger(number, self.now, self.system.stop_time()))
    }

    /// Prepares a reset of a component for when the condition of this fault holds. The fault is
    /// attached to a variable, which it does not change, so that snapshots know whether the reset
    /// has happened.
    pub(crate) fn install_reset(&mut self, component: &str, fault: Acting) -> Result<()> {
        let fault = Patch::Fault(Box::new(fault.installed(Way::Output, self.now)));
        self.act_on(component, Act::Patch(fault))
    }

    /// The condition of such a fault holds.
    pub(crate) fn trigger_reset(&mut self, component: &str, number: u32) -> Result<()> {
        self.act_on(component, Act::Trigger(number, self.now, self.system.stop_time()))
    }

    /// Resets a component now: it starts again with its start values.
    pub(crate) fn reset(&mut self, component: &str) -> Result<()> {
        self.act_on(component, Act::Reset(self.now, self.system.stop_time()))
    }

    /// An action on a whole component, represented by its first variable.
    fn act_on(&mut self, component: &str, act: Act) -> Result<()> {
        let component = self.system.resettable(component)?;
        let basic = self.system.basic(Port { component, variable: 0 });
        let change = Change { variable: 0, basic, way: Way::Output, act, start: 0.0 };
        self.driven.change(component, change, self.now)
    }

    /// The value of a recorded variable at the last output instant, which may be now.
    pub fn recorded(&self, variable: &str) -> Option<f64> {
        let place = self.system.columns().iter().position(|column| column.name == variable)?;
        self.row.get(place).copied()
    }

    /// Ends the run now.
    pub fn end(&mut self, reason: Stop) {
        self.stop = Some(reason);
    }

    fn change(&mut self, name: &str, act: Act) -> Result<()> {
        let port = self.system.manipulable(name)?;
        let (start, way) = (start_of(self.system, port), self.system.way(port));
        let (variable, basic) = (port.variable, self.system.basic(port));
        let change = Change { variable, basic, way, act, start };
        self.driven.change(port.component, change, self.now)
    }
}

/// A manipulation of one variable of a component.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Position of the variable, and its type.
    pub variable: usize,
    pub(crate) basic: Basic,
    /// How its value gets to the component or from it.
    pub(crate) way: Way,
    /// What is done to it.
    pub(crate) act: Act,
    /// Its start value.
    pub(crate) start: f64,
}

/// An action on a variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Act {
    /// Replaces an existing override or bias; faults are added to one another.
    Patch(Patch),
    /// Removes overrides and biases.
    Release,
    /// The condition for the fault with this number holds now, in a run that ends at the second
    /// instant.
    Trigger(u32, Time, Time),
    /// The component is reset at this instant, in a run that ends at the second one; its variable
    /// does not matter.
    Reset(Time, Time),
}

impl Engine {
    /// Changes a variable from now on.
    pub fn change(&mut self, component: usize, change: Change) -> Result<()> {
        let Change { variable, basic, way, act, start } = change;
        if let Act::Reset(now, stop) = act {
            return self.reset(component, now, stop);
        }
        let shared = self.patches_of(component);
        let mut patches = shared.borrow_mut();
        let own = |patched: &Patched| patched.variable == variable;
        let fault = match act {
            Act::Trigger(number, now, stop) => {
                let mut reset = false;
                for patched in patches.iter_mut().filter(|patched| own(patched)) {
                    if let Patch::Fault(fault) = &mut patched.patch {
                        reset |= fault.trigger(number, now);
                    }
                }
                release(&mut patches);
                drop(patches);
                return if reset { self.reset(component, now, stop) } else { Ok(()) };
            }
            Act::Patch(patch) => Some(patch),
            Act::Release | Act::Reset(..) => None,
        };
        if let Some(patch @ Patch::Fault(_)) = fault {
            // It is applied with the next step.
            patches.push(Patched { variable, basic, way, start, given: start, patch });
            release(&mut patches);
            return Ok(());
        }
        patches.retain(|patched| !own(patched) || patched.patch.is_fault());
        let value = match fault {
            Some(Patch::Override(value)) => value,
            Some(Patch::Bias(bias)) => start + bias,
            _ => start,
        };
        if way == Way::Free {
            // The slave must not be borrowed during the assignment.
            self.slaves[component].give(variable, &Scalar::of_number(basic, value).value(basic))?;
            patches.iter_mut().filter(|p| own(p)).for_each(|patched| patched.given = value);
        }
        // The assigned value is also kept in the list, for a snapshot.
        let patched = |patch| Patched { variable, basic, way, start, given: value, patch };
        let place = patches.iter().position(own).unwrap_or(patches.len());
        if let Some(patch) = fault {
            patches.insert(place, patched(patch));
        }
        Ok(())
    }

    /// Resets a component; actions on its variables are applied again.
    fn reset(&mut self, component: usize, now: Time, stop: Time) -> Result<()> {
        self.slaves[component].reset(now, stop)?;
        let Some(shared) = self.patches[component].clone() else { return Ok(()) };
        for patched in shared.borrow_mut().iter_mut().filter(|p| p.way == Way::Free) {
            match patched.patch {
                // It is applied with the next step.
                Patch::Fault(_) => patched.given = patched.start,
                _ => self.slaves[component].give(patched.variable, &patched.given())?,
            }
        }
        Ok(())
    }

    /// Sets an unconnected variable from outside.
    pub(crate) fn give(&mut self, port: Port, value: &Value, now: Time) -> Result<()> {
        let slave = &mut self.slaves[port.component];
        slave.came_to(now);
        slave.give(port.variable, value)?;
        self.rebase(port, value.number())
    }

    /// Actions on an unconnected variable apply to this value, which its component has.
    pub(crate) fn rebase(&mut self, port: Port, value: f64) -> Result<()> {
        let Some(shared) = &self.patches[port.component] else { return Ok(()) };
        let mut patches = shared.borrow_mut();
        let own = |patched: &&mut Patched| patched.variable == port.variable;
        let mut given = value;
        for patched in patches.iter_mut().filter(own) {
            patched.start = value;
            if !patched.patch.is_fault() {
                given = patched.patch.apply(given);
                patched.given = given;
                self.slaves[port.component].give(port.variable, &patched.given())?;
            }
        }
        // Faults are applied with the next step.
        patches.iter_mut().filter(own).for_each(|patched| patched.given = given);
        Ok(())
    }

    /// Replaces all actions on the variables of a component.
    pub(super) fn replace_patches(&mut self, component: usize, patches: &[Patched]) {
        if !patches.is_empty() || self.patches[component].is_some() {
            *self.patches_of(component).borrow_mut() = patches.to_vec();
        }
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
    /// The variables that may be manipulated and that match a name or a pattern (`*`, `?`).
    pub(crate) fn manipulables(&self, name: &str) -> Result<Vec<String>> {
        if !names::is_pattern(name) {
            return self.manipulable(name).map(|_| vec![name.to_owned()]);
        }
        let mut found = Vec::new();
        for (component, own) in self.components().iter().enumerate() {
            let variables = own.model.description().map_or(&[][..], |d| &d.variables);
            for (variable, described) in variables.iter().enumerate() {
                let full = self.port_name(Port { component, variable });
                let fits = described.kind != Kind::String && may_change(described);
                if fits && names::matches(name, &full) {
                    found.push(full);
                }
            }
        }
        if found.is_empty() {
            return Err(Error::new(Code::UnknownName, format!("'{name}' matches no variable"))
                .why("only inputs, outputs and tunable parameters are set while a system runs"));
        }
        Ok(found)
    }

    /// The component of this name if it can be reset; the error says why not.
    pub(crate) fn resettable(&self, name: &str) -> Result<usize> {
        let names = || self.components().iter().map(|component| component.name.as_str());
        let Some(component) = names().position(|known| known == name) else {
            let what = format!("there is no component '{name}'");
            let help = names::did_you_mean(name, names())
                .unwrap_or_else(|| format!("there are {}", names().collect::<Vec<_>>().join(", ")));
            return Err(Error::new(Code::UnknownName, what).help(help));
        };
        if self.components()[component].fmu().is_none() {
            return Err(Error::new(Code::Parameter, format!("'{name}' cannot be reset"))
                .why("it is a file of signals"));
        }
        Ok(component)
    }

    /// The port of a variable that may be manipulated; the error says why it may not.
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

impl System {
    /// The type of a variable.
    pub(super) fn basic(&self, port: Port) -> Basic {
        let description = self.components()[port.component].model.description();
        let variable = description.and_then(|d| d.variables.get(port.variable));
        variable.map_or(Basic::Real, |variable| variable.kind.basic())
    }

    /// How the values of a variable get to its component, or from it.
    fn way(&self, port: Port) -> Way {
        let description = self.components()[port.component].model.description();
        let causality = description.map(|d| d.variables[port.variable].causality);
        if causality == Some(Causality::Output) {
            Way::Output
        } else if self.connections().iter().any(|connection| connection.to == port) {
            Way::Input
        } else {
            Way::Free
        }
    }
}

fn may_change(variable: &Variable) -> bool {
    match variable.causality {
        Causality::Input | Causality::Output => true,
        Causality::Parameter => variable.variability == Variability::Tunable,
        _ => false,
    }
}

/// The value at the start of a run.
fn start_of(system: &System, port: Port) -> f64 {
    let component = &system.components()[port.component];
    let given = component.start_values.iter().rev().find(|(v, _)| *v == port.variable);
    let description = component.model.description();
    let declared = description.and_then(|d| d.variables[port.variable].start.as_ref());
    given.map(|(_, value)| value).or(declared).map_or(0.0, Value::number)
}
