//! Derivatives: of inputs and outputs in time, and of outputs with respect to inputs
//! (FMI 2.0.5, 4.2.1 and 2.1.9).

use super::{Instance, State};
use crate::error::Result;

const STEPPING: &[State] = &[State::Ready];
const DIFFERENTIABLE: &[State] =
    &[State::Initialization, State::Ready, State::EventMode, State::ContinuousTime];

impl Instance {
    /// Gives the first time derivatives of Real inputs, valid during the next step.
    pub fn set_input_derivatives(&mut self, references: &[u32], values: &[f64]) -> Result<()> {
        self.check("fmi2SetRealInputDerivatives", STEPPING, references.len(), values.len())?;
        let (orders, function) = (vec![1; references.len()], self.optional.input_derivatives);
        self.call_optional("fmi2SetRealInputDerivatives", function, |function, c| {
            let (n, orders) = (references.len(), orders.as_ptr());
            // SAFETY: `c` is alive; the three arrays have that length.
            unsafe { function(c, references.as_ptr(), n, orders, values.as_ptr()) }
        })
    }

    /// Reads the first time derivatives of Real outputs at the end of the last step.
    pub fn get_output_derivatives(&mut self, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.check("fmi2GetRealOutputDerivatives", STEPPING, references.len(), values.len())?;
        let (orders, function) = (vec![1; references.len()], self.optional.output_derivatives);
        self.call_optional("fmi2GetRealOutputDerivatives", function, |function, c| {
            let (n, orders) = (references.len(), orders.as_ptr());
            // SAFETY: `c` is alive; the three arrays have that length.
            unsafe { function(c, references.as_ptr(), n, orders, values.as_mut_ptr()) }
        })
    }

    /// How `unknowns` change when `knowns` change by `seed`, everything else held.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        result: &mut [f64],
    ) -> Result<()> {
        let name = "fmi2GetDirectionalDerivative";
        self.check(name, DIFFERENTIABLE, knowns.len(), seed.len())?;
        self.check(name, DIFFERENTIABLE, unknowns.len(), result.len())?;
        let function = self.optional.directional;
        self.call_optional(name, function, |function, c| {
            // SAFETY: `c` is alive; each pair of arrays has its length.
            unsafe {
                function(
                    c,
                    unknowns.as_ptr(),
                    unknowns.len(),
                    knowns.as_ptr(),
                    knowns.len(),
                    seed.as_ptr(),
                    result.as_mut_ptr(),
                )
            }
        })
    }
}
