//! Prepared signals as a slave: no inputs, and outputs from a file.

use std::sync::Arc;

use super::plan::Node;
use super::slave::Slave;
use crate::signals::Signals;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::{Place, Scalar, Value};

/// Signals at the current time. Its state is the time.
pub(super) struct SignalSlave {
    signals: Arc<Signals>,
    outputs: Vec<usize>,
    recorded: Vec<usize>,
    time: Time,
}

impl SignalSlave {
    pub(super) fn new(signals: &Arc<Signals>, node: &Node) -> Self {
        Self {
            signals: signals.clone(),
            outputs: node.outputs.clone(),
            recorded: node.recorded.clone(),
            time: Time::ZERO,
        }
    }
}

impl Slave for SignalSlave {
    fn enter_initialization(&mut self, start: Time, _stop: Time) -> Result<()> {
        self.time = start;
        Ok(())
    }

    fn exit_initialization(&mut self) -> Result<()> {
        Ok(())
    }

    fn reset(&mut self, _now: Time, _stop: Time) -> Result<()> {
        Ok(())
    }

    fn set(&mut self, _values: &[Scalar]) -> Result<()> {
        Ok(())
    }

    fn ramp(&mut self, _values: &[Scalar], _slopes: &[f64]) -> Result<()> {
        Ok(())
    }

    fn step(&mut self, start: Time, step: Time) -> Result<Time> {
        self.time = start + step;
        Ok(self.time)
    }

    fn get(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.signals.values_at(self.time, &self.outputs, values);
        Ok(())
    }

    fn slopes(&mut self, slopes: &mut [f64]) -> Result<bool> {
        self.signals.slopes_at(self.time, &self.outputs, slopes);
        Ok(true)
    }

    fn tangent(&mut self, _seed: &[f64], outputs: &mut [f64]) -> Result<bool> {
        outputs.fill(0.0);
        Ok(true)
    }

    fn read(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.signals.values_at(self.time, &self.recorded, values);
        Ok(())
    }

    fn give(&mut self, _variable: usize, _value: &Value) -> Result<()> {
        Err(Error::new(Code::Parameter, "signals of a file cannot be set"))
    }

    fn look(&mut self, variable: usize) -> Result<Value> {
        let mut value = [Scalar::default()];
        self.signals.values_at(self.time, &[variable], &mut value);
        Ok(value[0].value(self.signals.kind(variable).basic()))
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }

    fn save(&mut self, _place: Place) -> Result<()> {
        Ok(())
    }

    fn restore(&mut self, _place: Place, time: Time) -> Result<()> {
        self.time = time;
        Ok(())
    }

    fn serialize(&mut self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }

    fn deserialize(&mut self, _state: &[u8], time: Time) -> Result<()> {
        self.time = time;
        Ok(())
    }
}
