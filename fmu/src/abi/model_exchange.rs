//! Model exchange (FMI 2.0.4, section 3.2).

use crate::kernel::{Call, EventOutcome, Served, Status};

use super::arguments::{Wrong, array, array_mut, place};
use super::environment::from_here;
use super::guard::call;
use super::handles::Library;
use super::types::*;

/// `fmi2EnterEventMode`
pub unsafe fn fmi2EnterEventMode<L: Library>(c: fmi2Component) -> fmi2Status {
    call::<L>(c, Call::EnterEventMode, |instance| instance.enter_event_mode())
}

/// `fmi2NewDiscreteStates`
pub unsafe fn fmi2NewDiscreteStates<L: Library>(
    c: fmi2Component,
    fmi2eventInfo: *mut fmi2EventInfo,
) -> fmi2Status {
    call::<L>(c, Call::NewDiscreteStates, |instance| {
        // SAFETY: the importer passes one struct to fill, as the standard requires.
        let info = match unsafe { place("fmi2eventInfo", fmi2eventInfo) } {
            Ok(info) => info,
            Err(wrong) => return instance.refuse(Call::NewDiscreteStates, &wrong),
        };
        let mut outcome = EventOutcome::default();
        let status = instance.new_discrete_states(&mut outcome);
        if status == Status::Ok {
            *info = fmi2EventInfo {
                newDiscreteStatesNeeded: outcome.again.into(),
                valuesOfContinuousStatesChanged: outcome.states_changed.into(),
                nextEventTimeDefined: outcome.next_event.is_some().into(),
                nextEventTime: outcome.next_event.unwrap_or_default().seconds(),
                ..fmi2EventInfo::default()
            };
        }
        status
    })
}

/// `fmi2EnterContinuousTimeMode`
pub unsafe fn fmi2EnterContinuousTimeMode<L: Library>(c: fmi2Component) -> fmi2Status {
    call::<L>(c, Call::EnterContinuousTimeMode, |instance| instance.enter_continuous_time_mode())
}

/// `fmi2CompletedIntegratorStep`
pub unsafe fn fmi2CompletedIntegratorStep<L: Library>(
    c: fmi2Component,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
    enterEventMode: *mut fmi2Boolean,
    terminateSimulation: *mut fmi2Boolean,
) -> fmi2Status {
    call::<L>(c, Call::CompletedIntegratorStep, |instance| {
        // SAFETY: the importer passes two flags to fill, as the standard requires.
        let flags = unsafe {
            (
                place("enterEventMode", enterEventMode),
                place("terminateSimulation", terminateSimulation),
            )
        };
        let (event, end) = match flags {
            (Ok(event), Ok(end)) => (event, end),
            (Err(wrong), _) | (_, Err(wrong)) => {
                return instance.refuse(Call::CompletedIntegratorStep, &wrong);
            }
        };
        (*event, *end) = (FMI2_FALSE, FMI2_FALSE);
        instance.completed_integrator_step()
    })
}

/// `fmi2SetTime`
pub unsafe fn fmi2SetTime<L: Library>(c: fmi2Component, time: fmi2Real) -> fmi2Status {
    call::<L>(c, Call::SetTime, |instance| {
        let (time, _) = from_here(time, 0.0);
        instance.set_time(time)
    })
}

/// `fmi2SetContinuousStates`
pub unsafe fn fmi2SetContinuousStates<L: Library>(
    c: fmi2Component,
    x: *const fmi2Real,
    nx: usize,
) -> fmi2Status {
    call::<L>(c, Call::SetContinuousStates, |instance| {
        // SAFETY: the importer passes an array of `nx` elements, as the standard requires.
        match unsafe { array("x", x, nx) } {
            Ok(x) => instance.set_continuous_states(x),
            Err(wrong) => instance.refuse(Call::SetContinuousStates, &wrong),
        }
    })
}

/// A function that fills one array of Reals.
fn fill<L: Library>(
    c: fmi2Component,
    function: Call,
    into: Result<&mut [fmi2Real], Wrong>,
    get: fn(&mut L::Instance, &mut [fmi2Real]) -> Status,
) -> fmi2Status {
    call::<L>(c, function, |instance| match into {
        Ok(into) => get(instance, into),
        Err(wrong) => instance.refuse(function, &wrong),
    })
}

/// `fmi2GetDerivatives`
pub unsafe fn fmi2GetDerivatives<L: Library>(
    c: fmi2Component,
    derivatives: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    // SAFETY: the importer passes an array of `nx` elements, as the standard requires.
    let into = unsafe { array_mut("derivatives", derivatives, nx) };
    fill::<L>(c, Call::GetDerivatives, into, L::Instance::get_derivatives)
}

/// `fmi2GetEventIndicators`
pub unsafe fn fmi2GetEventIndicators<L: Library>(
    c: fmi2Component,
    eventIndicators: *mut fmi2Real,
    ni: usize,
) -> fmi2Status {
    // SAFETY: the importer passes an array of `ni` elements, as the standard requires.
    let into = unsafe { array_mut("eventIndicators", eventIndicators, ni) };
    fill::<L>(c, Call::GetEventIndicators, into, L::Instance::get_event_indicators)
}

/// `fmi2GetContinuousStates`
pub unsafe fn fmi2GetContinuousStates<L: Library>(
    c: fmi2Component,
    x: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    // SAFETY: the importer passes an array of `nx` elements, as the standard requires.
    let into = unsafe { array_mut("x", x, nx) };
    fill::<L>(c, Call::GetContinuousStates, into, L::Instance::get_continuous_states)
}

/// `fmi2GetNominalsOfContinuousStates`
pub unsafe fn fmi2GetNominalsOfContinuousStates<L: Library>(
    c: fmi2Component,
    x_nominal: *mut fmi2Real,
    nx: usize,
) -> fmi2Status {
    // SAFETY: the importer passes an array of `nx` elements, as the standard requires.
    let into = unsafe { array_mut("x_nominal", x_nominal, nx) };
    fill::<L>(c, Call::GetNominals, into, L::Instance::get_nominals)
}
