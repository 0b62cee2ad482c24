//! A slave whose inputs are converted before they reach it: units, transformations, maps.
//!
//! The scheduler passes values on unchanged; only components with such connections cost more.

use super::patched_slave::{PatchedSlave, SharedPatches};
use super::plan::Node;
use super::slave::{Slave, passes_on, passes_steps_on};
use crate::system::{Conversion, System};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;
use cosim_import::{Place, Scalar, Value};

/// A converted input: its position among the inputs, the conversion, and the name of the connection
/// for messages.
pub type Converted = (usize, Conversion, String);

impl System {
    /// The inputs of a component that are converted.
    pub fn converted(&self, component: usize, node: &Node) -> Vec<Converted> {
        let own = self.connections().iter().filter(|c| c.to.component == component);
        let converted = own.filter_map(|connection| {
            let slot = node.inputs.iter().position(|&v| v == connection.to.variable)?;
            let (from, to) = (self.port_name(connection.from), self.port_name(connection.to));
            Some((slot, connection.conversion.clone()?, format!("{from} -> {to}")))
        });
        converted.collect()
    }
}

/// A slave behind its conversions.
pub(super) struct ConvertingSlave {
    inner: Box<dyn Slave>,
    conversions: Vec<Converted>,
    buffer: Vec<Scalar>,
    slopes: Vec<f64>,
}

impl ConvertingSlave {
    /// The slave itself if none of its inputs is converted. Otherwise, what manipulates its values
    /// is between the conversions and the slave: it uses the component's own units.
    pub(super) fn around(
        inner: Box<dyn Slave>,
        conversions: Vec<Converted>,
        node: &Node,
    ) -> (Box<dyn Slave>, Option<SharedPatches>) {
        if conversions.is_empty() {
            return (inner, None);
        }
        let patches = SharedPatches::default();
        let inner = Box::new(PatchedSlave::new(inner, node, patches.clone()));
        let count = node.inputs.len();
        let (buffer, slopes) = (vec![Scalar::default(); count], vec![0.0; count]);
        let slave = Self { inner, conversions, buffer, slopes };
        (Box::new(slave), Some(patches))
    }
}

impl ConvertingSlave {
    /// Fills the buffer with the values for the inputs.
    fn convert(&mut self, values: &[Scalar]) -> Result<()> {
        self.buffer.copy_from_slice(values);
        for (slot, conversion, name) in &self.conversions {
            let value = self.buffer[*slot];
            self.buffer[*slot] = conversion.of_scalar(value).ok_or_else(|| {
                let what = format!("the mapping of {name} has no {}", value.as_integer());
                Error::new(Code::Connection, what)
                    .help("add a <ssc:MapEntry> for it to the connection")
            })?;
        }
        Ok(())
    }

    /// Fills the slopes with the derivatives of the inputs.
    fn scale(&mut self, slopes: &[f64]) {
        self.slopes.copy_from_slice(slopes);
        for (slot, conversion, _) in &self.conversions {
            self.slopes[*slot] *= conversion.slope();
        }
    }
}

impl Slave for ConvertingSlave {
    passes_on!(inner);
    passes_steps_on!(inner);

    fn set(&mut self, values: &[Scalar]) -> Result<()> {
        self.convert(values)?;
        self.inner.set(&self.buffer)
    }

    fn ramp(&mut self, values: &[Scalar], slopes: &[f64]) -> Result<()> {
        self.convert(values)?;
        self.scale(slopes);
        self.inner.ramp(&self.buffer, &self.slopes)
    }

    fn tangent(&mut self, seed: &[f64], outputs: &mut [f64]) -> Result<bool> {
        self.scale(seed);
        self.inner.tangent(&self.slopes, outputs)
    }

    fn get(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.inner.get(values)
    }

    fn slopes(&mut self, slopes: &mut [f64]) -> Result<bool> {
        self.inner.slopes(slopes)
    }

    fn read(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.inner.read(values)
    }
}
