//! A model exchange FMU in this process as a slave: our solver steps it.
//!
//! The convention is that of co-simulation: in a step from t to t + h, inputs hold the values set
//! before it, and the events in (t, t + h] are handled. A discrete input that changes is an event
//! (FMI 2.0.5, 3.2.2: it may be set in event mode only), and so is a continuous one that moves an
//! event indicator into its other domain.

use std::sync::Arc;

use super::fmu_slave::{give, instantiate, look, tangent};
use super::group::Group;
use super::plan::Node;
use super::slave::Slave;
use super::start::StartValues;
use crate::solver::{Continuous, Settings};
use crate::system::Component;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{Step, Time};
use cosim_import::{
    Fmu, Instance, InterfaceType, Kind, Logging, Phase, Place, Scalar, Value, Variability,
};

pub(super) struct ExchangeSlave {
    instance: Instance,
    solver: Continuous,
    /// The integration, and the discrete inputs of the saved FMU, by place.
    saved: [Option<(Continuous, Option<Vec<Scalar>>)>; Place::COUNT],
    start: Time,
    continuous: Inputs,
    discrete: Inputs,
    outputs: Group,
    recorded: Group,
    /// The connected inputs in their own order, for derivatives.
    inputs: Group,
    tangents: bool,
    step: Step,
    start_values: StartValues,
    warnings: Vec<String>,
}

/// Some of the inputs.
struct Inputs {
    group: Group,
    /// Their positions among all inputs.
    places: Vec<usize>,
    /// The values set last, if they have been set.
    values: Option<Vec<Scalar>>,
}

impl Inputs {
    fn new(fmu: &Fmu, inputs: &[usize], continuous: bool) -> Self {
        let variables = &fmu.description().variables;
        let is = |p: usize| variables[inputs[p]].variability == Variability::Continuous;
        let places: Vec<usize> = (0..inputs.len()).filter(|&p| is(p) == continuous).collect();
        let positions: Vec<usize> = places.iter().map(|&p| inputs[p]).collect();
        let group = Group::new(variables, &positions);
        Self { group, places, values: None }
    }

    /// Extracts its own values from those of all inputs; returns whether any has changed.
    fn take(&mut self, all: &[Scalar]) -> bool {
        let mut changed = self.values.is_none() && !self.places.is_empty();
        let values = self.values.get_or_insert_with(|| vec![Scalar::default(); self.places.len()]);
        for (value, &place) in values.iter_mut().zip(&self.places) {
            changed |= *value != all[place];
            *value = all[place];
        }
        changed
    }

    fn values(&self) -> &[Scalar] {
        self.values.as_deref().unwrap_or_default()
    }

    fn set(&mut self, instance: &mut Instance) -> Result<()> {
        match &self.values {
            Some(values) => self.group.set(instance, values),
            None => Ok(()),
        }
    }

    /// For another process, in which Strings have other numbers. `None`: not set yet.
    fn kept(&self) -> Option<Kept> {
        let mut values = self.values.clone()?;
        let texts = self.group.texts(&mut values).iter().map(|text| text.as_text().to_string());
        Some((texts.collect(), values))
    }

    /// Takes them back; returns whether they fit.
    fn resume(&mut self, kept: Option<Kept>) -> bool {
        let Some((texts, mut values)) = kept else {
            self.values = None;
            return true;
        };
        let fits = values.len() == self.places.len();
        if fits {
            let own = self.group.texts(&mut values).iter_mut();
            own.zip(texts).for_each(|(value, text)| *value = Scalar::text(&text));
            self.values = Some(values);
        }
        fits
    }
}

/// The Strings of inputs, and all their values.
type Kept = (Vec<String>, Vec<Scalar>);

impl ExchangeSlave {
    pub(super) fn new(
        component: &Component,
        fmu: &Arc<Fmu>,
        node: &Node,
        settings: Settings,
        logging: &Logging,
    ) -> Result<Self> {
        let (instance, start_values) = instantiate(component, fmu, logging)?;
        let interface = fmu.interface(InterfaceType::ModelExchange)?;
        let completes_steps = !interface.no_completed_step;
        let variables = &fmu.description().variables;
        Ok(Self {
            solver: Continuous::new(settings, &instance, completes_steps),
            instance,
            saved: Default::default(),
            start: Time::ZERO,
            continuous: Inputs::new(fmu, &node.inputs, true),
            discrete: Inputs::new(fmu, &node.inputs, false),
            outputs: Group::new(variables, &node.outputs),
            recorded: Group::new(variables, &node.recorded),
            inputs: Group::new(variables, &node.inputs),
            tangents: interface.directional_derivative,
            step: node.step,
            start_values,
            warnings: Vec::new(),
        })
    }
}

impl Slave for ExchangeSlave {
    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.start = start;
        self.warnings.extend(self.start_values.enter(&mut self.instance, start, stop)?);
        Ok(())
    }

    fn warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.warnings.extend(self.start_values.exit(&mut self.instance)?);
        self.solver.begin(&mut self.instance, self.start)
    }

    fn reset(&mut self, now: Time, stop: Time) -> Result<()> {
        self.instance.reset()?;
        self.start_values.again(&mut self.instance)?;
        // The FMU has the default values of its description again, which are not known here.
        self.discrete.values = None;
        self.enter_initialization(now, stop)?;
        self.exit_initialization()?;
        // What is odd about its start has been reported.
        self.warnings.clear();
        Ok(())
    }

    fn set(&mut self, values: &[Scalar]) -> Result<()> {
        self.solver.ramp(&[], &[], &[]);
        let jump = self.discrete.take(values);
        self.continuous.take(values);
        if self.instance.phase() != Phase::Continuous {
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

    fn ramp(&mut self, values: &[Scalar], slopes: &[f64]) -> Result<()> {
        self.set(values)?;
        let reals = self.continuous.group.reals();
        let own: Vec<f64> = self.continuous.places.iter().map(|&place| slopes[place]).collect();
        let values = Scalar::reals(&self.continuous.values()[..reals.len()]);
        self.solver.ramp(reals, values, &own[..reals.len()]);
        Ok(())
    }

    fn step(&mut self, start: Time, step: Time) -> Result<Time> {
        let end = self.step.seconds_at(self.start, start + step);
        self.solver.advance(&mut self.instance, end)?;
        Ok(start + step)
    }

    fn get(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.outputs.get(&mut self.instance, values)
    }

    fn slopes(&mut self, _slopes: &mut [f64]) -> Result<bool> {
        Ok(false)
    }

    fn tangent(&mut self, seed: &[f64], outputs: &mut [f64]) -> Result<bool> {
        match self.tangents {
            true => tangent(&mut self.instance, &self.inputs, &self.outputs, seed, outputs),
            false => Ok(false),
        }
    }

    fn read(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.recorded.get(&mut self.instance, values)
    }

    fn give(&mut self, variable: usize, value: &Value) -> Result<()> {
        let described = &self.instance.fmu().description().variables[variable];
        let smooth =
            described.variability == Variability::Continuous && described.kind == Kind::Real;
        if smooth || self.instance.phase() != Phase::Continuous {
            return give(&mut self.instance, variable, value);
        }
        self.solver.event(&mut self.instance, |instance| give(instance, variable, value))
    }

    fn look(&mut self, variable: usize) -> Result<Value> {
        look(&mut self.instance, variable)
    }

    fn debug(&mut self, on: bool) -> Result<()> {
        self.instance.debug(on)
    }

    fn messages(&mut self) -> Vec<String> {
        self.instance.messages()
    }

    fn check_process(&mut self, function: &str) {
        self.instance.check_process(function);
    }

    fn save(&mut self, place: Place) -> Result<()> {
        self.instance.save(place)?;
        self.saved[place as usize] = Some((self.solver.clone(), self.discrete.values.clone()));
        Ok(())
    }

    fn restore(&mut self, place: Place, time: Time) -> Result<()> {
        self.instance.restore(place, time)?;
        if let Some((solver, discrete)) = &self.saved[place as usize] {
            self.solver = solver.clone();
            self.discrete.values.clone_from(discrete);
        }
        Ok(())
    }

    fn serialize(&mut self) -> Result<Vec<u8>> {
        let (fmu, solver) = (self.instance.serialize()?, self.solver.progress());
        postcard::to_stdvec(&(fmu, solver, self.discrete.kept(), self.continuous.kept()))
            .map_err(|e| self.unusable(&e))
    }

    fn deserialize(&mut self, state: &[u8], time: Time) -> Result<()> {
        let (fmu, solver, discrete, continuous): (Vec<u8>, _, Option<Kept>, Option<Kept>) =
            postcard::from_bytes(state).map_err(|e| self.unusable(&e))?;
        self.instance.deserialize(&fmu, time)?;
        if !self.discrete.resume(discrete)
            || !self.continuous.resume(continuous)
            || !self.solver.resume(solver)
        {
            return Err(self.unusable(&"it has a different number of values"));
        }
        Ok(())
    }
}

impl ExchangeSlave {
    fn unusable(&self, why: &dyn std::fmt::Display) -> Error {
        let what =
            format!("the integration of '{}' is not part of a snapshot", self.instance.name());
        Error::new(Code::State, what).why(why)
    }
}
