//! A co-simulation FMU in this process as a slave.

use std::sync::Arc;

use crate::error::Result;
use crate::fmi::{Fmu, Instance, Logging};
use crate::system::Component;
use crate::time::Time;

use super::group::Group;
use super::plan::Node;
use super::slave::Slave;

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
        fmu: &Arc<Fmu>,
        node: &Node,
        logging: &Logging,
    ) -> Result<Self> {
        let instance = instantiate(component, fmu, logging)?;
        let variables = &fmu.description().variables;
        Ok(Self {
            instance,
            inputs: Group::new(variables, &node.inputs),
            outputs: Group::new(variables, &node.outputs),
            recorded: Group::new(variables, &node.recorded),
        })
    }
}

/// An instance with the component's start values.
pub(super) fn instantiate(
    component: &Component,
    fmu: &Arc<Fmu>,
    logging: &Logging,
) -> Result<Instance> {
    let mut instance = Instance::of(fmu.clone(), component.interface, &component.name, logging)?;
    for (position, value) in &component.start_values {
        instance.set_value(&fmu.description().variables[*position], value)?;
    }
    Ok(instance)
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
