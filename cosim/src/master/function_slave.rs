//! A function of a system as a slave: its outputs follow its inputs at once.

use std::sync::Arc;

use super::plan::Node;
use super::slave::Slave;
use crate::error::Result;
use crate::system::Function;
use crate::time::Time;

/// A function and its present inputs; what is not connected is 0. It has no state but them, and
/// they are set again before every use.
pub(super) struct FunctionSlave {
    function: Arc<Function>,
    /// By position in its description.
    values: Vec<f64>,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    recorded: Vec<usize>,
}

impl FunctionSlave {
    pub(super) fn new(function: &Arc<Function>, node: &Node) -> Self {
        Self {
            function: function.clone(),
            values: vec![0.0; function.description().variables.len()],
            inputs: node.inputs.clone(),
            outputs: node.outputs.clone(),
            recorded: node.recorded.clone(),
        }
    }

    fn evaluate(&mut self) {
        let ports = self.values.len() - self.function.dimension().unwrap_or(1);
        for output in ports..self.values.len() {
            self.values[output] = self.function.terms(output).map(|i| self.values[i]).sum();
        }
    }
}

fn pick(all: &[f64], positions: &[usize], values: &mut [f64]) {
    values.iter_mut().zip(positions).for_each(|(value, &position)| *value = all[position]);
}

impl Slave for FunctionSlave {
    fn enter_initialization(&mut self, _start: Time, _stop: Time) -> Result<()> {
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<()> {
        Ok(())
    }

    fn set(&mut self, values: &[f64]) -> Result<()> {
        for (&position, &value) in self.inputs.iter().zip(values) {
            self.values[position] = value;
        }
        self.evaluate();
        Ok(())
    }

    fn step(&mut self, _start: Time, _step: Time) -> Result<()> {
        Ok(())
    }

    fn get(&mut self, values: &mut [f64]) -> Result<()> {
        pick(&self.values, &self.outputs, values);
        Ok(())
    }

    fn read(&mut self, values: &mut [f64]) -> Result<()> {
        pick(&self.values, &self.recorded, values);
        Ok(())
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }

    fn save(&mut self) -> Result<()> {
        Ok(())
    }

    fn restore(&mut self, _time: Time) -> Result<()> {
        Ok(())
    }
}
