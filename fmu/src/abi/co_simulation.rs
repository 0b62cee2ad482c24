//! Co-simulation (FMI 2.0.4, section 4.2).

use fmu_standard::StatusKind;

use crate::kernel::{Call, Served};

use super::arguments::{array, array_mut, place};
use super::environment::from_here;
use super::guard::call;
use super::handles::Library;
use super::types::*;

/// `fmi2SetRealInputDerivatives`
pub unsafe fn fmi2SetRealInputDerivatives<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    call::<L>(c, Call::SetRealInputDerivatives, |instance| {
        // SAFETY: the importer passes arrays of `nvr` elements, as the standard requires.
        let arrays = unsafe {
            (array("vr", vr, nvr), array("order", order, nvr), array("value", value, nvr))
        };
        match arrays {
            (Ok(vr), Ok(order), Ok(value)) => instance.set_input_derivatives(vr, order, value),
            (Err(wrong), ..) | (_, Err(wrong), _) | (.., Err(wrong)) => {
                instance.refuse(Call::SetRealInputDerivatives, &wrong)
            }
        }
    })
}

/// `fmi2GetRealOutputDerivatives`
pub unsafe fn fmi2GetRealOutputDerivatives<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status {
    call::<L>(c, Call::GetRealOutputDerivatives, |instance| {
        // SAFETY: the importer passes arrays of `nvr` elements, as the standard requires.
        let arrays = unsafe {
            (array("vr", vr, nvr), array("order", order, nvr), array_mut("value", value, nvr))
        };
        match arrays {
            (Ok(vr), Ok(order), Ok(value)) => instance.output_derivatives(vr, order, value),
            (Err(wrong), ..) | (_, Err(wrong), _) | (.., Err(wrong)) => {
                instance.refuse(Call::GetRealOutputDerivatives, &wrong)
            }
        }
    })
}

/// `fmi2DoStep`
#[inline]
pub unsafe fn fmi2DoStep<L: Library>(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    call::<L>(c, Call::DoStep, |instance| {
        let (t, h) = from_here(currentCommunicationPoint, communicationStepSize);
        instance.do_step(t, h)
    })
}

/// `fmi2CancelStep`: no step is ever pending, so it is never legal.
pub unsafe fn fmi2CancelStep<L: Library>(c: fmi2Component) -> fmi2Status {
    call::<L>(c, Call::CancelStep, |instance| {
        instance.unsupported(Call::CancelStep, "canRunAsynchronuously = false")
    })
}

/// `fmi2GetStatus`: there is no pending step to report.
pub unsafe fn fmi2GetStatus<L: Library>(
    c: fmi2Component,
    s: fmi2StatusKind,
    _value: *mut fmi2Status,
) -> fmi2Status {
    call::<L>(c, Call::GetStatus, |instance| instance.no_status(Call::GetStatus, s))
}

/// `fmi2GetRealStatus`: the time of the last successful step.
pub unsafe fn fmi2GetRealStatus<L: Library>(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    call::<L>(c, Call::GetRealStatus, |instance| {
        // SAFETY: the importer passes one Real to fill, as the standard requires.
        match unsafe { place("value", value) } {
            Ok(value) if s == StatusKind::LastSuccessfulTime as fmi2StatusKind => {
                instance.last_successful_time(value)
            }
            Ok(_) => instance.no_status(Call::GetRealStatus, s),
            Err(wrong) => instance.refuse(Call::GetRealStatus, &wrong),
        }
    })
}

/// `fmi2GetIntegerStatus`: there is no status of this type.
pub unsafe fn fmi2GetIntegerStatus<L: Library>(
    c: fmi2Component,
    s: fmi2StatusKind,
    _value: *mut fmi2Integer,
) -> fmi2Status {
    call::<L>(c, Call::GetIntegerStatus, |instance| instance.no_status(Call::GetIntegerStatus, s))
}

/// `fmi2GetBooleanStatus`: a component never ends the simulation by itself.
pub unsafe fn fmi2GetBooleanStatus<L: Library>(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    call::<L>(c, Call::GetBooleanStatus, |instance| {
        // SAFETY: the importer passes one Boolean to fill, as the standard requires.
        match unsafe { place("value", value) } {
            Ok(value) if s == StatusKind::Terminated as fmi2StatusKind => {
                let mut end = false;
                let status = instance.wants_to_end(&mut end);
                *value = end.into();
                status
            }
            Ok(_) => instance.no_status(Call::GetBooleanStatus, s),
            Err(wrong) => instance.refuse(Call::GetBooleanStatus, &wrong),
        }
    })
}

/// `fmi2GetStringStatus`: there is no pending step to report.
pub unsafe fn fmi2GetStringStatus<L: Library>(
    c: fmi2Component,
    s: fmi2StatusKind,
    _value: *mut fmi2String,
) -> fmi2Status {
    call::<L>(c, Call::GetStringStatus, |instance| instance.no_status(Call::GetStringStatus, s))
}
