//! A co-simulation FMU in this process as a slave.

use std::sync::Arc;

use crate::system::Component;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{Step, Time};
use cosim_import::guard::Float;
use cosim_import::{Fmu, Instance, InterfaceType, Logging, Place, Scalar, Unusual, Value};

use super::group::Group;
use super::plan::Node;
use super::slave::{DirectCalls, Slave};
use super::start::StartValues;

/// What happens to a step that the FMU discards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Discards {
    /// It is an error, because the FMU cannot go back.
    Final,
    /// It is repeated with smaller steps up to this many times; then, or with 0, it is an error.
    Repeated(u32),
    /// It is reported to the caller.
    Reported,
}

/// An instance and the variables exchanged with it. The fields that every step uses come first and
/// occupy as few cache lines as possible.
#[repr(C, align(64))]
pub(super) struct FmuSlave {
    inputs: Group,
    discards: Discards,
    outputs: Group,
    instance: Instance,
    recorded: Group,
    rejected: u64,
    step: Step,
    start_values: StartValues,
    warnings: Vec<String>,
    /// The inputs of this step and their slopes, if any.
    ramp: (Vec<Scalar>, Vec<f64>),
    /// It provides derivatives of its outputs in time, and with respect to its inputs.
    output_slopes: bool,
    tangents: bool,
}

impl FmuSlave {
    /// Instantiates a component and sets its start values.
    pub(super) fn new(
        component: &Component,
        fmu: &Arc<Fmu>,
        node: &Node,
        discards: Discards,
        tolerance: Option<f64>,
        logging: &Logging,
    ) -> Result<Self> {
        let (mut instance, start_values) = instantiate(component, fmu, logging)?;
        if let Some(tolerance) = tolerance {
            instance.set_tolerance(tolerance);
        }
        let variables = &fmu.description().variables;
        let interface = fmu.interface(InterfaceType::CoSimulation)?;
        Ok(Self {
            instance,
            inputs: Group::new(variables, &node.inputs),
            outputs: Group::new(variables, &node.outputs),
            recorded: Group::new(variables, &node.recorded),
            discards,
            step: node.step,
            start_values,
            warnings: Vec::new(),
            rejected: 0,
            ramp: Default::default(),
            output_slopes: interface.output_derivative_order > 0,
            tangents: interface.directional_derivative,
        })
    }

    /// Repeats a discarded step from its start with smaller ones, as suggested by the FMU or
    /// halved.
    #[cold]
    fn discarded(&mut self, start: Time, step: Time, reached: Time) -> Result<Time> {
        let retries = match self.discards {
            Discards::Reported => return Ok(reached),
            Discards::Final => {
                return Err(self.instance.discarded(reached).help(
                    "a smaller --step; its FMU does not declare both canGetAndSetFMUstate and \
                     canHandleVariableCommunicationStepSize, so no step can be repeated",
                ));
            }
            Discards::Repeated(0) => {
                let error = self.instance.discarded(reached);
                return Err(error.help("--retries 10 repeats it with smaller steps"));
            }
            Discards::Repeated(retries) => retries,
        };
        let (end, mut begin, mut reached) = (start + step, start, reached);
        let mut smaller = step;
        for _ in 0..retries {
            self.rejected += 1;
            self.instance.restore(Place::Retry, begin)?;
            // Use the part that it completed, if that is long enough for a step.
            let came = reached - begin;
            let half = Time::from_ns(smaller.ns() / 2);
            smaller = if came > Time::ZERO && came < smaller { came } else { half };
            if smaller == Time::ZERO {
                break;
            }
            loop {
                let length = smaller.min(end - begin);
                reached = self.instance.try_step(begin, length)?;
                if reached == end {
                    return Ok(end);
                }
                if reached < begin + length {
                    break;
                }
                begin = reached;
                self.go_on(begin - start)?;
                self.instance.save(Place::Retry)?;
            }
        }
        let what = format!("'{}' discards its step at t = {begin}", self.instance.name());
        Err(Error::new(Code::Step, what)
            .at(self.instance.fmu().path())
            .why(format!("it was made smaller {retries} times; the last one reached {reached}"))
            .log(self.instance.messages()))
    }

    /// Inputs with slopes continue from their values at the start of a part of the step.
    fn go_on(&mut self, since: Time) -> Result<()> {
        if self.ramp.0.is_empty() {
            return Ok(());
        }
        let (values, slopes) = &self.ramp;
        let (mut moved, count) = (values.clone(), self.inputs.reals().len());
        for (value, slope) in Scalar::reals_mut(&mut moved[..count]).iter_mut().zip(slopes) {
            *value += slope * since.seconds();
        }
        self.inputs.set(&mut self.instance, &moved)?;
        self.instance.set_input_derivatives(self.inputs.reals(), &slopes[..count])
    }
}

/// An instance with the start values of the component.
pub(super) fn instantiate(
    component: &Component,
    fmu: &Arc<Fmu>,
    logging: &Logging,
) -> Result<(Instance, StartValues)> {
    let mut instance = Instance::of(fmu.clone(), component.interface, &component.name, logging)?;
    let start_values = StartValues::new(&mut instance, &component.start_values)?;
    Ok((instance, start_values))
}

impl Slave for FmuSlave {
    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.instance.steps_by(start, self.step);
        self.warnings.extend(self.start_values.enter(&mut self.instance, start, stop)?);
        Ok(())
    }

    fn warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.warnings.extend(self.start_values.exit(&mut self.instance)?);
        Ok(())
    }

    fn reset(&mut self, now: Time, stop: Time) -> Result<()> {
        self.instance.reset()?;
        self.start_values.again(&mut self.instance)?;
        self.enter_initialization(now, stop)?;
        self.exit_initialization()?;
        // What is odd about its start has been reported.
        self.warnings.clear();
        Ok(())
    }

    #[inline(always)]
    fn set(&mut self, values: &[Scalar]) -> Result<()> {
        self.inputs.set(&mut self.instance, values)
    }

    fn ramp(&mut self, values: &[Scalar], slopes: &[f64]) -> Result<()> {
        self.ramp.0.clear();
        self.ramp.0.extend_from_slice(values);
        self.ramp.1.clear();
        self.ramp.1.extend_from_slice(slopes);
        self.go_on(Time::ZERO)
    }

    #[inline(always)]
    fn step(&mut self, start: Time, step: Time) -> Result<Time> {
        if matches!(self.discards, Discards::Repeated(1..)) {
            self.instance.save(Place::Retry)?;
        }
        let reached = self.instance.try_step(start, step)?;
        if reached == start + step { Ok(reached) } else { self.discarded(start, step, reached) }
    }

    #[inline(always)]
    fn get(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.outputs.get(&mut self.instance, values)
    }

    fn slopes(&mut self, slopes: &mut [f64]) -> Result<bool> {
        let reals = self.outputs.reals();
        if !self.output_slopes {
            return Ok(false);
        }
        let (of_reals, rest) = slopes.split_at_mut(reals.len());
        rest.fill(0.0);
        self.instance.get_output_derivatives(reals, of_reals)?;
        Ok(true)
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
        give(&mut self.instance, variable, value)
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

    fn save(&mut self, place: Place) -> Result<()> {
        self.instance.save(place)
    }

    fn restore(&mut self, place: Place, time: Time) -> Result<()> {
        self.instance.restore(place, time)
    }

    fn serialize(&mut self) -> Result<Vec<u8>> {
        self.instance.serialize()
    }

    fn deserialize(&mut self, state: &[u8], time: Time) -> Result<()> {
        self.instance.deserialize(state, time)
    }

    fn rejected(&self) -> u64 {
        self.rejected
    }

    fn direct(&self) -> Option<DirectCalls<'_>> {
        if !matches!(self.discards, Discards::Final | Discards::Repeated(0)) {
            return None;
        }
        let (inputs, outputs) = (self.inputs.only_reals()?, self.outputs.only_reals()?);
        let recorded = self.recorded.reals();
        Some(DirectCalls { calls: self.instance.direct()?, inputs, outputs, recorded })
    }

    #[cold]
    fn conclude(&mut self, found: Unusual, start: Time, step: Time) -> Result<()> {
        let reached = self.instance.conclude(found, start, step)?;
        self.discarded(start, step, reached).map(drop)
    }

    fn check_process(&mut self, function: &str) {
        self.instance.check_process(function);
    }

    fn changed_float(&mut self, before: Float) {
        self.instance.changed_float(before);
    }

    fn came_to(&mut self, now: Time) {
        self.instance.came_to(now);
    }
}

/// The directional derivative of the outputs; values that are not Reals do not change.
pub(super) fn tangent(
    instance: &mut Instance,
    inputs: &Group,
    outputs: &Group,
    seed: &[f64],
    result: &mut [f64],
) -> Result<bool> {
    let (knowns, unknowns) = (inputs.reals(), outputs.reals());
    let (of_reals, rest) = result.split_at_mut(unknowns.len());
    rest.fill(0.0);
    instance.directional_derivative(unknowns, knowns, &seed[..knowns.len()], of_reals)
}

/// Sets one variable to a value of its type.
pub(super) fn give(instance: &mut Instance, variable: usize, value: &Value) -> Result<()> {
    let fmu = instance.fmu().clone();
    instance.set_value(&fmu.description().variables[variable], value)
}

/// Reads one variable.
pub(super) fn look(instance: &mut Instance, variable: usize) -> Result<Value> {
    let fmu = instance.fmu().clone();
    instance.get_value(&fmu.description().variables[variable])
}
