//! A slave with manipulated variables: overridden, biased, or faulty.
//!
//! Only manipulated components are wrapped, so the others cost nothing more. A connected input is
//! changed on its way into the slave, an output on its way out; a parameter or an unconnected input
//! is set.

use std::cell::RefCell;
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use super::plan::Node;
use super::slave::{Slave, passes_on};
use crate::fault::{Acting, Way};
use cosim_base::error::Result;
use cosim_base::time::Time;
use cosim_import::{Basic, Place, Scalar, Value};

/// A manipulation of a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Patch {
    Override(f64),
    Bias(f64),
    Fault(Box<Acting>),
}

impl Patch {
    pub(super) fn apply(&mut self, value: f64) -> f64 {
        match self {
            Patch::Override(instead) => *instead,
            Patch::Bias(bias) => value + *bias,
            Patch::Fault(fault) => fault.apply(value),
        }
    }

    fn slope(&self) -> f64 {
        match self {
            Patch::Override(_) => 0.0,
            Patch::Bias(_) => 1.0,
            Patch::Fault(fault) => fault.slope(),
        }
    }

    pub(super) fn is_fault(&self) -> bool {
        matches!(self, Patch::Fault(_))
    }
}

/// A variable of a component and one of its manipulations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Patched {
    /// Position of the variable, and its type.
    pub(crate) variable: usize,
    pub(crate) basic: Basic,
    pub(crate) way: Way,
    /// The value of a free variable without this, and the value that was set last.
    pub(crate) start: f64,
    pub(crate) given: f64,
    pub(crate) patch: Patch,
}

impl Patched {
    /// The value that was set last.
    pub(super) fn given(&self) -> Value {
        Scalar::of_number(self.basic, self.given).value(self.basic)
    }
}

/// The patches of one component; those of one variable act in order.
pub(crate) type Patches = Vec<Patched>;

/// They are shared with the engine, which changes them between steps.
pub(crate) type SharedPatches = Rc<RefCell<Patches>>;

/// Notifies faults whether a later one on the same variable has ended them.
pub(super) fn release(patches: &mut Patches) {
    for place in 0..patches.len() {
        let (before, after) = patches.split_at_mut(place + 1);
        let own = &mut before[place];
        let ends = |later: &Patched| {
            later.variable == own.variable
                && matches!(&later.patch, Patch::Fault(fault) if fault.releases())
        };
        let released = after.iter().any(ends);
        if let Patch::Fault(fault) = &mut own.patch {
            fault.release(released);
        }
    }
}

pub(super) struct PatchedSlave {
    inner: Box<dyn Slave>,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    recorded: Vec<usize>,
    patches: SharedPatches,
    /// The patches that belong to the saved states.
    kept: [Patches; Place::COUNT],
    /// Buffers for inputs and slopes.
    values: Vec<Scalar>,
    slopes: Vec<f64>,
}

impl PatchedSlave {
    pub(super) fn new(inner: Box<dyn Slave>, node: &Node, patches: SharedPatches) -> Self {
        let (inputs, outputs, recorded) =
            (node.inputs.clone(), node.outputs.clone(), node.recorded.clone());
        let (values, slopes, kept) = (Vec::new(), Vec::new(), Default::default());
        Self { inner, inputs, outputs, recorded, patches, kept, values, slopes }
    }

    fn places<'a>(
        patches: &'a mut Patches,
        way: Way,
        variables: &'a [usize],
    ) -> impl Iterator<Item = (usize, &'a mut Patched)> {
        patches.iter_mut().filter(move |patched| patched.way == way).filter_map(|patched| {
            Some((variables.iter().position(|&v| v == patched.variable)?, patched))
        })
    }

    fn patch(patches: &mut Patches, way: Way, variables: &[usize], values: &mut [Scalar]) {
        for (place, Patched { basic, patch, .. }) in Self::places(patches, way, variables) {
            let number = patch.apply(values[place].number(*basic));
            values[place] = Scalar::of_number(*basic, number);
        }
    }

    /// Slopes are patched too: an overridden value stays constant.
    fn slope(patches: &mut Patches, way: Way, variables: &[usize], slopes: &mut [f64]) {
        for (place, Patched { patch, .. }) in Self::places(patches, way, variables) {
            let factor = patch.slope();
            slopes[place] = if factor == 0.0 { 0.0 } else { slopes[place] * factor };
        }
    }

    fn has_faults(&self) -> bool {
        self.patches.borrow().iter().any(|patched| patched.patch.is_fault())
    }

    /// Sets free variables with faults to their values for the step that begins.
    fn give_free(&mut self) -> Result<()> {
        let mut patches = self.patches.borrow_mut();
        for place in 0..patches.len() {
            let Patched { variable, basic, way, start, given, .. } = patches[place];
            let own = |patched: &Patched| patched.variable == variable;
            let first = patches.iter().position(own) == Some(place);
            if way != Way::Free || !first {
                continue;
            }
            let all = patches.iter_mut().filter(|patched| own(patched));
            let value = all.fold(start, |value, patched| patched.patch.apply(value));
            if value.to_bits() != given.to_bits() {
                self.inner.give(variable, &Scalar::of_number(basic, value).value(basic))?;
                patches.iter_mut().filter(|p| own(p)).for_each(|p| p.given = value);
            }
        }
        Ok(())
    }

    /// A step was made: the faults advance.
    fn advance_faults(&mut self, begin: Time, end: Time) -> Result<()> {
        let mut patches = self.patches.borrow_mut();
        for patched in patches.iter_mut() {
            if let Patch::Fault(fault) = &mut patched.patch {
                fault.advance(begin, end);
            }
        }
        release(&mut patches);
        // Faults with memory see each value, also of outputs that are read only occasionally.
        for place in 0..patches.len() {
            let Patched { variable, way, .. } = patches[place];
            let looks_back =
                matches!(&patches[place].patch, Patch::Fault(fault) if fault.remembers());
            if way == Way::Output && looks_back && !self.outputs.contains(&variable) {
                let value = self.inner.look(variable)?.number();
                let all = patches.iter_mut().filter(|patched| patched.variable == variable);
                all.fold(value, |value, patched| patched.patch.apply(value));
            }
        }
        Ok(())
    }
}

impl Slave for PatchedSlave {
    passes_on!(inner);

    fn step(&mut self, start: Time, step: Time) -> Result<Time> {
        if !self.has_faults() {
            return self.inner.step(start, step);
        }
        self.give_free()?;
        let reached = self.inner.step(start, step)?;
        if reached == start + step {
            self.advance_faults(start, reached)?;
        }
        Ok(reached)
    }

    fn save(&mut self, place: Place) -> Result<()> {
        self.kept[place as usize].clone_from(&self.patches.borrow());
        self.inner.save(place)
    }

    fn restore(&mut self, place: Place, time: Time) -> Result<()> {
        self.patches.borrow_mut().clone_from(&self.kept[place as usize]);
        self.inner.restore(place, time)
    }

    fn set(&mut self, values: &[Scalar]) -> Result<()> {
        self.values.clear();
        self.values.extend_from_slice(values);
        Self::patch(&mut self.patches.borrow_mut(), Way::Input, &self.inputs, &mut self.values);
        self.inner.set(&self.values)
    }

    fn ramp(&mut self, values: &[Scalar], slopes: &[f64]) -> Result<()> {
        self.values.clear();
        self.values.extend_from_slice(values);
        self.slopes.clear();
        self.slopes.extend_from_slice(slopes);
        Self::patch(&mut self.patches.borrow_mut(), Way::Input, &self.inputs, &mut self.values);
        Self::slope(&mut self.patches.borrow_mut(), Way::Input, &self.inputs, &mut self.slopes);
        self.inner.ramp(&self.values, &self.slopes)
    }

    fn get(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.inner.get(values)?;
        Self::patch(&mut self.patches.borrow_mut(), Way::Output, &self.outputs, values);
        Ok(())
    }

    fn slopes(&mut self, slopes: &mut [f64]) -> Result<bool> {
        let known = self.inner.slopes(slopes)?;
        Self::slope(&mut self.patches.borrow_mut(), Way::Output, &self.outputs, slopes);
        Ok(known)
    }

    fn tangent(&mut self, seed: &[f64], outputs: &mut [f64]) -> Result<bool> {
        self.slopes.clear();
        self.slopes.extend_from_slice(seed);
        Self::slope(&mut self.patches.borrow_mut(), Way::Input, &self.inputs, &mut self.slopes);
        let known = self.inner.tangent(&self.slopes, outputs)?;
        Self::slope(&mut self.patches.borrow_mut(), Way::Output, &self.outputs, outputs);
        Ok(known)
    }

    fn read(&mut self, values: &mut [Scalar]) -> Result<()> {
        self.inner.read(values)?;
        Self::patch(&mut self.patches.borrow_mut(), Way::Output, &self.recorded, values);
        Ok(())
    }
}
