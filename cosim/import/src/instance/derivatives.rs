//! Derivatives: of inputs and outputs in time, and of outputs with respect to inputs
//! (FMI 2.0.5, 4.2.1 and 2.1.9).

use fmu_standard::Call;

use super::{Followed, Instance, followed};
use crate::Kind;
use crate::status;
use cosim_base::error::Result;

impl Instance {
    /// Sets the first time derivatives of Real inputs, valid during the next step.
    pub fn set_input_derivatives(&mut self, references: &[u32], values: &[f64]) -> Result<()> {
        self.check(Call::SetRealInputDerivatives, references.len(), values.len())?;
        let orders = vec![1; references.len()];
        let function = self.stepping(Call::SetRealInputDerivatives)?.input_derivatives;
        let shown = |f: &Followed| f.pairs(&Kind::Real, references, values);
        self.call(Call::SetRealInputDerivatives, shown, |_, c| {
            let (n, orders) = (references.len(), orders.as_ptr());
            // SAFETY: `c` is alive; the three arrays have that length.
            unsafe { function(c, references.as_ptr(), n, orders, values.as_ptr()) }
        })
    }

    /// Reads the first time derivatives of Real outputs at the end of the last step.
    pub fn get_output_derivatives(&mut self, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.check(Call::GetRealOutputDerivatives, references.len(), values.len())?;
        let orders = vec![1; references.len()];
        let function = self.stepping(Call::GetRealOutputDerivatives)?.output_derivatives;
        let shown = |f: &Followed| f.names(&Kind::Real, references);
        self.get(Call::GetRealOutputDerivatives, shown, |_, c| {
            let (n, orders) = (references.len(), orders.as_ptr());
            // SAFETY: `c` is alive; the three arrays have that length.
            unsafe { function(c, references.as_ptr(), n, orders, values.as_mut_ptr()) }
        })?;
        self.show(|_| followed::values(values));
        Ok(())
    }

    /// How `unknowns` change when `knowns` change by `seed`, with everything else held. `false` if
    /// the FMU has no answer, whatever it declares: then differences are used instead.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        result: &mut [f64],
    ) -> Result<bool> {
        let name = Call::GetDirectionalDerivative;
        self.check(name, knowns.len(), seed.len())?;
        self.check(name, unknowns.len(), result.len())?;
        let shown = |f: &Followed| {
            let unknowns = f.names(&Kind::Real, unknowns);
            format!("{unknowns} by {}", f.pairs(&Kind::Real, knowns, seed))
        };
        let mut answer = status::OK;
        self.get(name, shown, |f, c| {
            // SAFETY: `c` is alive; each pair of arrays has its length.
            answer = unsafe {
                (f.directional)(
                    c,
                    unknowns.as_ptr(),
                    unknowns.len(),
                    knowns.as_ptr(),
                    knowns.len(),
                    seed.as_ptr(),
                    result.as_mut_ptr(),
                )
            };
            if answer == status::FATAL { answer } else { status::OK }
        })?;
        let known = matches!(answer, status::OK | status::WARNING);
        self.show(|_| match known {
            true => followed::values(result),
            false => format!("no answer: {}", status::name(answer)),
        });
        Ok(known && result.iter().all(|value| value.is_finite()))
    }
}
