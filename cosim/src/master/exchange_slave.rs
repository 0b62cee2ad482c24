//! A model exchange FMU in this process as a slave: our integrator steps it.
//!
//! The convention is that of co-simulation: in a step from t to t + h inputs hold the values set
//! before it, and the events in (t, t + h] are handled. A discrete input that changes is an event
//! (FMI 2.0.5, 3.2.2: it may be set in event mode only), a continuous one that moves an event
//! indicator into its other domain too.

use std::sync::Arc;

use super::fmu_slave::instantiate;
use super::group::Group;
use super::plan::Node;
use super::slave::Slave;
use crate::error::Result;
use crate::fmi::{Fmu, Instance, InterfaceType, Logging, State, Variability};
use crate::solver::{Continuous, Settings};
use crate::system::Component;
use crate::time::Time;

pub(super) struct ExchangeSlave {
    instance: Instance,
    solver: Continuous,
    /// The integration, and the discrete inputs that the saved FMU has.
    saved: Option<(Continuous, Vec<f64>)>,
    start: Time,
    continuous: Inputs,
    discrete: Inputs,
    outputs: Group,
    recorded: Group,
}

/// Some of the inputs.
struct Inputs {
    group: Group,
    /// Where they are among all inputs.
    places: Vec<usize>,
    /// What was set last.
    values: Vec<f64>,
}

impl Inputs {
    fn new(fmu: &Fmu, inputs: &[usize], continuous: bool) -> Self {
        let variables = &fmu.description().variables;
        let is = |p: usize| variables[inputs[p]].variability == Variability::Continuous;
        let places: Vec<usize> = (0..inputs.len()).filter(|&p| is(p) == continuous).collect();
        let positions: Vec<usize> = places.iter().map(|&p| inputs[p]).collect();
        let group = Group::new(variables, &positions);
        Self { group, values: vec![f64::NAN; places.len()], places }
    }

    /// Takes the own values out of those of all inputs; whether one is another.
    fn take(&mut self, all: &[f64]) -> bool {
        let mut changed = false;
        for (value, &place) in self.values.iter_mut().zip(&self.places) {
            changed |= value.to_bits() != all[place].to_bits();
            *value = all[place];
        }
        changed
    }

    fn set(&mut self, instance: &mut Instance) -> Result<()> {
        self.group.set(instance, &self.values)
    }
}

impl ExchangeSlave {
    pub(super) fn new(
        component: &Component,
        fmu: &Arc<Fmu>,
        node: &Node,
        settings: Settings,
        logging: &Logging,
    ) -> Result<Self> {
        let instance = instantiate(component, fmu, logging)?;
        let told = !fmu.interface(InterfaceType::ModelExchange)?.no_completed_step;
        let variables = &fmu.description().variables;
        Ok(Self {
            solver: Continuous::new(settings, &instance, told),
            instance,
            saved: None,
            start: Time::ZERO,
            continuous: Inputs::new(fmu, &node.inputs, true),
            discrete: Inputs::new(fmu, &node.inputs, false),
            outputs: Group::new(variables, &node.outputs),
            recorded: Group::new(variables, &node.recorded),
        })
    }
}

impl Slave for ExchangeSlave {
    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.start = start;
        self.instance.enter_initialization(start, stop)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.instance.exit_initialization()?;
        self.solver.begin(&mut self.instance, self.start)
    }

    fn set(&mut self, values: &[f64]) -> Result<()> {
        let jump = self.discrete.take(values);
        self.continuous.take(values);
        if self.instance.state() != State::ContinuousTime {
            self.discrete.set(&mut self.instance)?;
            return self.continuous.set(&mut self.instance);
        }
        if !jump {
            return self.continuous.set(&mut self.instance);
        }
        let (discrete, continuous) = (&mut self.discrete, &mut self.continuous);
        self.solver.event(&mut self.instance, |instance| {
            discrete.set(instance)?;
            continuous.set(instance)
        })
    }

    fn step(&mut self, start: Time, step: Time) -> Result<()> {
        self.solver.advance(&mut self.instance, start + step)
    }

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
        self.instance.save()?;
        self.saved = Some((self.solver.clone(), self.discrete.values.clone()));
        Ok(())
    }

    fn restore(&mut self, time: Time) -> Result<()> {
        self.instance.restore(time)?;
        if let Some((solver, discrete)) = &self.saved {
            self.solver = solver.clone();
            self.discrete.values.clone_from(discrete);
        }
        Ok(())
    }
}
