//! An FMU in this process as a slave.

use crate::error::Result;
use crate::fmi::{Instance, Kind, Variable};
use crate::system::{Component, Model};
use crate::time::Time;

use super::plan::Node;
use super::slave::Slave;

/// Variables that are set or read together, one FMI call per type. A master's plan lists Reals
/// first, then Integers, then Booleans ([`rank`]).
struct Group {
    reals: Vec<u32>,
    integers: Vec<u32>,
    booleans: Vec<u32>,
    /// Room for the values that are not Reals.
    buffer: Vec<i32>,
}

/// Order of types within a group.
pub(super) fn rank(kind: &Kind) -> u8 {
    match kind {
        Kind::Real => 0,
        Kind::Integer | Kind::Enumeration(_) => 1,
        Kind::Boolean => 2,
        Kind::String => 3,
    }
}

impl Group {
    fn new(variables: &[Variable], positions: &[usize]) -> Self {
        let of = |wanted: u8| -> Vec<u32> {
            let chosen = positions.iter().map(|&p| &variables[p]);
            chosen.filter(|v| rank(&v.kind) == wanted).map(|v| v.value_reference).collect()
        };
        let (reals, integers, booleans) = (of(0), of(1), of(2));
        let buffer = vec![0; integers.len().max(booleans.len())];
        Self { reals, integers, booleans, buffer }
    }

    #[inline]
    fn set(&mut self, instance: &mut Instance, values: &[f64]) -> Result<()> {
        let (reals, rest) = values.split_at(self.reals.len());
        if !reals.is_empty() {
            instance.set_real(&self.reals, reals)?;
        }
        if rest.is_empty() { Ok(()) } else { self.set_rest(instance, rest) }
    }

    fn set_rest(&mut self, instance: &mut Instance, rest: &[f64]) -> Result<()> {
        let (integers, booleans) = rest.split_at(self.integers.len());
        if !integers.is_empty() {
            let buffer = fill(&mut self.buffer, integers);
            instance.set_integer(&self.integers, buffer)?;
        }
        if !booleans.is_empty() {
            let buffer = fill(&mut self.buffer, booleans);
            instance.set_boolean(&self.booleans, buffer)?;
        }
        Ok(())
    }

    #[inline]
    fn get(&mut self, instance: &mut Instance, values: &mut [f64]) -> Result<()> {
        let (reals, rest) = values.split_at_mut(self.reals.len());
        if !reals.is_empty() {
            instance.get_real(&self.reals, reals)?;
        }
        if rest.is_empty() { Ok(()) } else { self.get_rest(instance, rest) }
    }

    fn get_rest(&mut self, instance: &mut Instance, rest: &mut [f64]) -> Result<()> {
        let (integers, booleans) = rest.split_at_mut(self.integers.len());
        if !integers.is_empty() {
            let buffer = &mut self.buffer[..integers.len()];
            instance.get_integer(&self.integers, buffer)?;
            integers.iter_mut().zip(buffer).for_each(|(to, from)| *to = f64::from(*from));
        }
        if !booleans.is_empty() {
            let buffer = &mut self.buffer[..booleans.len()];
            instance.get_boolean(&self.booleans, buffer)?;
            // Any number but 0 is true in C.
            booleans.iter_mut().zip(buffer).for_each(|(to, from)| *to = f64::from(*from != 0));
        }
        Ok(())
    }
}

/// Exact: the values came from an i32 or a Boolean, or from a file (then they are rounded).
fn fill<'b>(buffer: &'b mut [i32], values: &[f64]) -> &'b [i32] {
    let buffer = &mut buffer[..values.len()];
    buffer.iter_mut().zip(values).for_each(|(to, from)| *to = from.round() as i32);
    buffer
}

/// An instance and the variables exchanged with it.
pub(super) struct FmuSlave {
    instance: Instance,
    inputs: Group,
    outputs: Group,
    recorded: Group,
}

impl FmuSlave {
    /// Instantiates a component and gives it its start values.
    pub(super) fn new(
        component: &Component,
        fmu: &std::sync::Arc<crate::fmi::Fmu>,
        node: &Node,
        logging: bool,
    ) -> Result<Self> {
        debug_assert!(matches!(component.model, Model::Fmu(_)));
        let mut instance = Instance::new(fmu.clone(), &component.name, logging)?;
        let variables = &fmu.description().variables;
        for (position, value) in &component.start_values {
            instance.set_value(&variables[*position], value)?;
        }
        Ok(Self {
            instance,
            inputs: Group::new(variables, &node.inputs),
            outputs: Group::new(variables, &node.outputs),
            recorded: Group::new(variables, &node.recorded),
        })
    }
}

impl Slave for FmuSlave {
    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.instance.enter_initialization(start, stop)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.instance.exit_initialization()
    }

    #[inline]
    fn set(&mut self, values: &[f64]) -> Result<()> {
        self.inputs.set(&mut self.instance, values)
    }

    #[inline]
    fn step(&mut self, start: Time, step: Time) -> Result<()> {
        self.instance.do_step(start, step)
    }

    #[inline]
    fn get(&mut self, values: &mut [f64]) -> Result<()> {
        self.outputs.get(&mut self.instance, values)
    }

    fn read(&mut self, values: &mut [f64]) -> Result<()> {
        self.recorded.get(&mut self.instance, values)
    }

    fn messages(&mut self) -> Vec<String> {
        self.instance.messages()
    }

    fn save(&mut self) -> Result<()> {
        self.instance.save()
    }

    fn restore(&mut self, time: Time) -> Result<()> {
        self.instance.restore(time)
    }
}
