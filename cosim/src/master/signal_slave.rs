//! Prepared signals as a slave: no inputs, outputs that follow a file.

use std::sync::Arc;

use super::plan::Node;
use super::slave::Slave;
use crate::error::Result;
use crate::signals::Signals;
use crate::time::Time;

/// Signals at the present time. Its state is the time.
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

    fn set(&mut self, _values: &[f64]) -> Result<()> {
        Ok(())
    }

    fn step(&mut self, start: Time, step: Time) -> Result<()> {
        self.time = start + step;
        Ok(())
    }

    fn get(&mut self, values: &mut [f64]) -> Result<()> {
        self.signals.values_at(self.time, &self.outputs, values);
        Ok(())
    }

    fn read(&mut self, values: &mut [f64]) -> Result<()> {
        self.signals.values_at(self.time, &self.recorded, values);
        Ok(())
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }

    fn save(&mut self) -> Result<()> {
        Ok(())
    }

    fn restore(&mut self, time: Time) -> Result<()> {
        self.time = time;
        Ok(())
    }
}
