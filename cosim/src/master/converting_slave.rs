//! A slave whose inputs are converted before they reach it: units, transformations, maps.
//!
//! The scheduler passes values on as they are; only components with such connections pay.

use super::plan::Node;
use super::slave::Slave;
use crate::error::{Code, Error, Result};
use crate::system::{Conversion, System};
use crate::time::Time;

/// A slave behind its conversions.
pub(super) struct ConvertingSlave {
    inner: Box<dyn Slave>,
    /// Position among the inputs, what is done there, and the connection's name for messages.
    conversions: Vec<(usize, Conversion, String)>,
    buffer: Vec<f64>,
}

impl ConvertingSlave {
    /// The slave itself when none of its inputs is converted.
    pub(super) fn around(
        inner: Box<dyn Slave>,
        system: &System,
        component: usize,
        node: &Node,
    ) -> Box<dyn Slave> {
        let own = system.connections().iter().filter(|c| c.to.component == component);
        let conversions: Vec<_> = own
            .filter_map(|connection| {
                let slot = node.inputs.iter().position(|&v| v == connection.to.variable)?;
                let (from, to) =
                    (system.port_name(connection.from), system.port_name(connection.to));
                Some((slot, connection.conversion.clone()?, format!("{from} -> {to}")))
            })
            .collect();
        if conversions.is_empty() {
            return inner;
        }
        Box::new(Self { inner, conversions, buffer: vec![0.0; node.inputs.len()] })
    }
}

impl Slave for ConvertingSlave {
    fn set(&mut self, values: &[f64]) -> Result<()> {
        self.buffer.copy_from_slice(values);
        for (slot, conversion, name) in &self.conversions {
            let value = self.buffer[*slot];
            self.buffer[*slot] = conversion.apply(value).ok_or_else(|| {
                Error::new(Code::Connection, format!("the mapping of {name} has no {value}"))
                    .help("add a <ssc:MapEntry> for it to the connection")
            })?;
        }
        self.inner.set(&self.buffer)
    }

    fn enter_initialization(&mut self, start: Time, stop: Time) -> Result<()> {
        self.inner.enter_initialization(start, stop)
    }

    fn exit_initialization(&mut self) -> Result<()> {
        self.inner.exit_initialization()
    }

    fn step(&mut self, start: Time, step: Time) -> Result<()> {
        self.inner.step(start, step)
    }

    fn get(&mut self, values: &mut [f64]) -> Result<()> {
        self.inner.get(values)
    }

    fn read(&mut self, values: &mut [f64]) -> Result<()> {
        self.inner.read(values)
    }

    fn messages(&mut self) -> Vec<String> {
        self.inner.messages()
    }

    fn save(&mut self) -> Result<()> {
        self.inner.save()
    }

    fn restore(&mut self, time: Time) -> Result<()> {
        self.inner.restore(time)
    }
}
