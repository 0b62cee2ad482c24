//! A slave some of whose variables are manipulated: overridden or biased.
//!
//! Only manipulated components are wrapped, so the others cost nothing more. A connected input is
//! changed on its way into the slave, an output on its way out of it; a parameter or an input
//! that is not connected is set.

use std::cell::RefCell;
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use super::plan::Node;
use super::slave::{Slave, passes_on};
use crate::error::Result;
use crate::fmi::{Place, Value};
use crate::time::Time;

/// What is done to a value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) enum Patch {
    Override(f64),
    Bias(f64),
}

impl Patch {
    pub(super) fn of(self, value: f64) -> f64 {
        match self {
            Patch::Override(instead) => instead,
            Patch::Bias(bias) => value + bias,
        }
    }
}

/// The patches of one component, by position of the variable.
pub(crate) type Patches = Vec<(usize, Patch)>;

/// They are shared with the engine, which changes them between steps.
pub(crate) type SharedPatches = Rc<RefCell<Patches>>;

pub(super) struct PatchedSlave {
    inner: Box<dyn Slave>,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    recorded: Vec<usize>,
    patches: SharedPatches,
    /// Room for inputs and slopes.
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl PatchedSlave {
    pub(super) fn new(inner: Box<dyn Slave>, node: &Node, patches: SharedPatches) -> Self {
        let (inputs, outputs, recorded) =
            (node.inputs.clone(), node.outputs.clone(), node.recorded.clone());
        Self { inner, inputs, outputs, recorded, patches, values: Vec::new(), slopes: Vec::new() }
    }

    fn places<'a>(
        patches: &'a Patches,
        variables: &'a [usize],
    ) -> impl Iterator<Item = (usize, Patch)> + 'a {
        patches.iter().filter_map(|&(variable, patch)| {
            Some((variables.iter().position(|&v| v == variable)?, patch))
        })
    }

    fn patch(patches: &Patches, variables: &[usize], values: &mut [f64]) {
        for (place, patch) in Self::places(patches, variables) {
            values[place] = patch.of(values[place]);
        }
    }

    /// What has slopes is patched too: an overridden value stays where it is.
    fn flatten(patches: &Patches, variables: &[usize], slopes: &mut [f64]) {
        for (place, patch) in Self::places(patches, variables) {
            if matches!(patch, Patch::Override(_)) {
                slopes[place] = 0.0;
            }
        }
    }
}

impl Slave for PatchedSlave {
    passes_on!(inner);

    fn set(&mut self, values: &[f64]) -> Result<()> {
        self.values.clear();
        self.values.extend_from_slice(values);
        Self::patch(&self.patches.borrow(), &self.inputs, &mut self.values);
        self.inner.set(&self.values)
    }

    fn ramp(&mut self, values: &[f64], slopes: &[f64]) -> Result<()> {
        self.values.clear();
        self.values.extend_from_slice(values);
        self.slopes.clear();
        self.slopes.extend_from_slice(slopes);
        Self::patch(&self.patches.borrow(), &self.inputs, &mut self.values);
        Self::flatten(&self.patches.borrow(), &self.inputs, &mut self.slopes);
        self.inner.ramp(&self.values, &self.slopes)
    }

    fn get(&mut self, values: &mut [f64]) -> Result<()> {
        self.inner.get(values)?;
        Self::patch(&self.patches.borrow(), &self.outputs, values);
        Ok(())
    }

    fn slopes(&mut self, slopes: &mut [f64]) -> Result<bool> {
        let told = self.inner.slopes(slopes)?;
        Self::flatten(&self.patches.borrow(), &self.outputs, slopes);
        Ok(told)
    }

    fn tangent(&mut self, seed: &[f64], outputs: &mut [f64]) -> Result<bool> {
        self.slopes.clear();
        self.slopes.extend_from_slice(seed);
        Self::flatten(&self.patches.borrow(), &self.inputs, &mut self.slopes);
        let told = self.inner.tangent(&self.slopes, outputs)?;
        Self::flatten(&self.patches.borrow(), &self.outputs, outputs);
        Ok(told)
    }

    fn read(&mut self, values: &mut [f64]) -> Result<()> {
        self.inner.read(values)?;
        Self::patch(&self.patches.borrow(), &self.recorded, values);
        Ok(())
    }
}
