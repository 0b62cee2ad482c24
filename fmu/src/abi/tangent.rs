//! Directional derivatives (FMI 2.0.4, section 2.1.9).

use crate::kernel::{Call, Served};

use super::arguments::{array, array_mut, plain_array, plain_array_mut};
use super::guard::call;
use super::handles::Library;
use super::types::*;

/// `fmi2GetDirectionalDerivative`
pub unsafe fn fmi2GetDirectionalDerivative<L: Library>(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    call::<L>(c, Call::GetDirectionalDerivative, |instance| {
        // SAFETY: the importer passes arrays of these lengths, as the standard requires.
        let plain = unsafe {
            (
                plain_array(vUnknown_ref, nUnknown),
                plain_array(vKnown_ref, nKnown),
                plain_array(dvKnown, nKnown),
                plain_array_mut(dvUnknown, nUnknown),
            )
        };
        if let (Some(unknowns), Some(knowns), Some(along), Some(into)) = plain {
            return instance.directional_derivative(unknowns, knowns, along, into);
        }
        // SAFETY: as above.
        let arrays = unsafe {
            (
                array("vUnknown_ref", vUnknown_ref, nUnknown),
                array("vKnown_ref", vKnown_ref, nKnown),
                array("dvKnown", dvKnown, nKnown),
                array_mut("dvUnknown", dvUnknown, nUnknown),
            )
        };
        match arrays {
            (Ok(unknowns), Ok(knowns), Ok(along), Ok(into)) => {
                instance.directional_derivative(unknowns, knowns, along, into)
            }
            (Err(wrong), ..) | (_, Err(wrong), ..) | (_, _, Err(wrong), _) | (.., Err(wrong)) => {
                instance.refuse(Call::GetDirectionalDerivative, &wrong)
            }
        }
    })
}
