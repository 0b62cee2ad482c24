//! The variables of a hosted system by value reference.

use std::collections::BTreeMap;

use super::Stage;
use super::interface::{Exposed, Interface, Role};
use crate::master::Plan;
use crate::system::{Column, Conversion, Port, System};
use cosim_base::error::{Code, Error, Result};
use cosim_import::{Basic, Kind, Value};

/// All variables, by type.
pub(super) struct Table {
    known: [Vec<Known>; Basic::ALL.len()],
    /// For each Real, the position of its value in the engine; `None` if it has none.
    slots: Box<[Option<Slot>]>,
}

/// A position among the engine's values.
#[derive(Clone, Copy)]
pub(super) struct Slot {
    pub place: u32,
    /// It is up to date only after steps of this component that read it.
    pub read_with: Option<u32>,
}

/// A variable.
pub(super) struct Known {
    pub name: String,
    pub role: Role,
    pub ends: Vec<Inner>,
    pub read: Read,
    /// What the host set last, or its start value.
    pub value: Value,
    start: Value,
}

/// A variable of a component.
pub(super) struct Inner {
    pub port: Port,
    conversion: Option<Conversion>,
}

/// Where the value is read.
#[derive(Clone, Copy)]
pub(super) enum Read {
    /// What the host has set.
    Own,
    /// Among the engine's values.
    Slot(usize),
    /// The same, but read only for the host, from this component.
    Recorded(usize, usize),
    /// From the component, on request.
    Asked,
}

impl Known {
    pub(super) fn settable(&self, stage: Stage) -> Result<()> {
        let early = stage != Stage::Running;
        let why = match self.role {
            Role::Input | Role::Tunable => return Ok(()),
            Role::Fixed | Role::Start if early => return Ok(()),
            Role::Fixed => "it is fixed once initialization is over; reset to change it",
            Role::Start | Role::Calculated => "it is calculated",
        };
        Err(Error::new(Code::Parameter, format!("{} cannot be set", self.name)).why(why))
    }

    /// A value of the system as the host sees it.
    #[inline]
    pub(super) fn outward(&self, value: f64) -> f64 {
        match &self.ends[0].conversion {
            None => value,
            Some(conversion) => conversion.apply(value).unwrap_or(value),
        }
    }
}

impl Inner {
    /// A value of the host as the component gets it.
    pub(super) fn inward(&self, value: &Value) -> Result<Value> {
        let Some(conversion) = &self.conversion else {
            return Ok(value.clone());
        };
        let converted = conversion.apply(value.number()).ok_or_else(|| {
            Error::new(Code::Connection, format!("a mapping of the system has no {value}"))
        })?;
        Ok(match value {
            Value::Integer(_) => Value::Integer(converted as i32),
            Value::Boolean(_) => Value::Boolean(converted != 0.0),
            _ => Value::Real(converted),
        })
    }
}

impl Table {
    /// The table of a system, and the system with everything that has to be read from it.
    pub(super) fn new(system: System, interface: &Interface) -> Result<(System, Self)> {
        let components: BTreeMap<&str, usize> =
            system.components().iter().enumerate().map(|(p, c)| (c.name.as_str(), p)).collect();
        let mut found = Vec::with_capacity(interface.variables.len());
        for exposed in &interface.variables {
            let ends = exposed.ends.iter().map(|end| {
                let component = components.get(end.component.as_str()).copied();
                let port = component.and_then(|component| {
                    let model = &system.components()[component].model;
                    let variable = model.description()?.position(&end.variable)?;
                    Some(Port { component, variable })
                });
                let port = port.ok_or_else(|| strange(&end.component, &end.variable))?;
                Ok(Inner { port, conversion: end.conversion.clone() })
            });
            let ends = ends.collect::<Result<Vec<Inner>>>()?;
            if ends.is_empty() {
                return Err(strange(&exposed.name, ""));
            }
            found.push((exposed, ends));
        }
        let columns = found.iter().filter(|(exposed, _)| is_column(exposed));
        let columns = columns.map(|(exposed, ends)| {
            let port = ends[0].port;
            let model = &system.components()[port.component].model;
            let variables = model.description().map(|description| &description.variables);
            let kind = variables.map_or(Kind::Real, |all| all[port.variable].kind.clone());
            Column { name: exposed.name.clone(), port, kind, unit: model.unit(port.variable) }
        });
        let columns = columns.collect();
        let system = system.recording(columns);
        let plan = Plan::new(&system);
        let mut table = Self { known: Default::default(), slots: Box::default() };
        for (exposed, ends) in found {
            let known = Known {
                name: exposed.name.clone(),
                role: exposed.role,
                read: read(exposed, &ends, &plan),
                ends,
                value: exposed.start.clone(),
                start: exposed.start.clone(),
            };
            table.known[exposed.basic as usize].push(known);
        }
        let slot = |known: &Known| {
            let (slot, component) = match known.read {
                Read::Slot(slot) => (slot, None),
                Read::Recorded(slot, component) => (slot, Some(component)),
                Read::Own | Read::Asked => return None,
            };
            let read_with = component.map(u32::try_from).transpose().ok()?;
            let plain = known.ends[0].conversion.is_none();
            u32::try_from(slot).ok().filter(|_| plain).map(|place| Slot { place, read_with })
        };
        table.slots = table.known[Basic::Real as usize].iter().map(slot).collect();
        Ok((system, table))
    }

    /// The position of a Real among the engine's values.
    #[inline]
    pub(super) fn slot(&self, reference: u32) -> Option<Slot> {
        *self.slots.get(reference as usize)?
    }

    pub(super) fn reset(&mut self) {
        let all = self.known.iter_mut().flatten();
        all.for_each(|known| known.value.clone_from(&known.start));
    }

    /// The host's view of each variable, for a state.
    pub(super) fn values(&self) -> Vec<Value> {
        self.known.iter().flatten().map(|known| known.value.clone()).collect()
    }

    /// Whether a state has the right number and types of values.
    pub(super) fn fits(&self, values: &[Value]) -> bool {
        let all = || self.known.iter().flatten();
        let alike = |(known, value): (&Known, &Value)| {
            std::mem::discriminant(&known.value) == std::mem::discriminant(value)
        };
        values.len() == all().count() && all().zip(values).all(alike)
    }

    /// What the host may set at any time: the variables behind it, and their values.
    pub(super) fn open(&self) -> impl Iterator<Item = (&Inner, &Value)> {
        let all = self.known.iter().flatten();
        let open = all.filter(|known| matches!(known.role, Role::Input | Role::Tunable));
        open.flat_map(|known| known.ends.iter().map(move |end| (end, &known.value)))
    }

    /// Restores the values of a state.
    pub(super) fn take(&mut self, values: &[Value]) {
        let all = self.known.iter_mut().flatten();
        all.zip(values).for_each(|(known, value)| known.value.clone_from(value));
    }

    #[inline]
    pub(super) fn known(&self, basic: Basic, reference: u32) -> Result<&Known> {
        let list = &self.known[basic as usize];
        list.get(reference as usize).ok_or_else(|| unknown(list.len(), basic, reference))
    }

    pub(super) fn known_mut(&mut self, basic: Basic, reference: u32) -> Result<&mut Known> {
        let list = &mut self.known[basic as usize];
        let count = list.len();
        list.get_mut(reference as usize).ok_or_else(|| unknown(count, basic, reference))
    }
}

fn is_column(exposed: &Exposed) -> bool {
    matches!(exposed.role, Role::Start | Role::Calculated) && exposed.basic != Basic::String
}

fn read(exposed: &Exposed, ends: &[Inner], plan: &Plan) -> Read {
    let port = ends[0].port;
    match exposed.role {
        Role::Input | Role::Tunable => Read::Own,
        // The value in the host's unit is known only here.
        Role::Fixed if ends[0].conversion.is_some() => Read::Own,
        Role::Fixed => Read::Asked,
        _ => match plan.value_slot(port) {
            None => Read::Asked,
            Some(slot) if plan.nodes[port.component].recorded_slots.contains(&slot) => {
                Read::Recorded(slot, port.component)
            }
            Some(slot) => Read::Slot(slot),
        },
    }
}

#[cold]
fn unknown(count: usize, basic: Basic, reference: u32) -> Error {
    let what = format!("no {basic:?} has value reference {reference}");
    Error::new(Code::UnknownName, what).why(match count.checked_sub(1) {
        Some(last) => format!("the last is {last}"),
        None => "there are none".to_owned(),
    })
}

fn strange(component: &str, variable: &str) -> Error {
    Error::new(Code::File, "the parts of the FMU are inconsistent")
        .why(format!("its system has no variable '{variable}' of '{component}'"))
        .help("export it again")
}
