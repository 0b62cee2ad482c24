//! A function of a system as a slave: its outputs follow its inputs immediately.

use std::sync::Arc;

use super::plan::Node;
use super::slave::Slave;
use crate::system::Function;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::{Place, Scalar, Value};

/// A function and its current inputs, which are its state; unconnected inputs are 0.
pub(super) struct FunctionSlave {
    function: Arc<Function>,
    /// By position in its description.
    values: Vec<f64>,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    recorded: Vec<usize>,
    kept: Vec<(Place, Vec<f64>)>,
}

impl FunctionSlave {
    pub(super) fn new(function: &Arc<Function>, node: &Node) -> Self {
        Self {
            function: function.clone(),
            values: vec![0.0; function.description().variables.len()],
            inputs: node.inputs.clone(),
            outputs: node.outputs.clone(),
            recorded: node.recorded.clone(),
            kept: Vec::new(),
        }
    }

    fn evaluate(&mut self) {
        let ports = self.values.len() - self.function.dimension().unwrap_or(1);
        for output in ports..self.values.len() {
            self.values[output] = self.function.terms(output).map(|i| self.values[i]).sum();
        }
    }
}

fn pick(all: &[f64], positions: &[usize], values: &mut [Scalar]) {
    let pairs = values.iter_mut().zip(positions);
    pairs.for_each(|(value, &position)| *value = Scalar::real(all[position]));
}

impl Slave for FunctionSlave {
    fn enter_initialization(&mut self, _start: Time, _stop: Time) -> Result<()> {
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<()> {
        Ok(())
    }

    fn reset(&mut self, _now: Time, _stop: Time) -> Result<()> {
        Ok(())
    }

    fn set(&mut self, values: &[Scalar]) -> Result<()> {
        for (&position, &value) in self.inputs.iter().zip(values) {
            self.values[position] = value.as_real();
        }
        self.evaluate();
        Ok(())
    }

    fn ramp(&mut self, values: &[Scalar], _slopes: &[f64]) -> Result<()> {
        self.set(values)
    }

    fn step(&mut self, start: Time, step: Time) -> Result<Time> {
        Ok(start + step)
    }

    fn get(&mut self, values: &mut [Scalar]) -> Result<()> {
        pick(&self.values, &self.outputs, values);
        Ok(())
    }

    fn slopes(&mut self, _slopes: &mut [f64]) -> Result<bool> {
        Ok(false)
    }

    fn tangent(&mut self, seed: &[f64], outputs: &mut [f64]) -> Result<bool> {
        let of =
            |input: usize| self.inputs.iter().position(|&i| i == input).map_or(0.0, |p| seed[p]);
        for (slope, &output) in outputs.iter_mut().zip(&self.outputs) {
            *slope = self.function.terms(output).map(of).sum();
        }
        Ok(true)
    }

    fn read(&mut self, values: &mut [Scalar]) -> Result<()> {
        pick(&self.values, &self.recorded, values);
        Ok(())
    }

    fn give(&mut self, variable: usize, value: &Value) -> Result<()> {
        let Value::Real(value) = value else {
            return Err(Error::new(Code::Parameter, "the ports of a sum are Reals"));
        };
        self.values[variable] = *value;
        self.evaluate();
        Ok(())
    }

    fn look(&mut self, variable: usize) -> Result<Value> {
        Ok(Value::Real(self.values[variable]))
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }

    fn save(&mut self, place: Place) -> Result<()> {
        self.kept.retain(|(kept, _)| *kept != place);
        self.kept.push((place, self.values.clone()));
        Ok(())
    }

    fn restore(&mut self, place: Place, _time: Time) -> Result<()> {
        if let Some((_, values)) = self.kept.iter().find(|(kept, _)| *kept == place) {
            self.values.copy_from_slice(values);
        }
        Ok(())
    }

    fn serialize(&mut self) -> Result<Vec<u8>> {
        Ok(self.values.iter().flat_map(|value| value.to_le_bytes()).collect())
    }

    fn deserialize(&mut self, state: &[u8], _time: Time) -> Result<()> {
        if state.len() != 8 * self.values.len() {
            return Err(Error::new(Code::Snapshot, "the state of a sum has a different length"));
        }
        let (numbers, _) = state.as_chunks::<8>();
        for (value, bytes) in self.values.iter_mut().zip(numbers) {
            *value = f64::from_le_bytes(*bytes);
        }
        Ok(())
    }
}
