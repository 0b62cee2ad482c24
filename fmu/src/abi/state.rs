//! Functions this kit declares as not supported: saved states (FMI 2.0.4, section 2.1.8) and
//! directional derivatives (section 2.1.9).

use crate::kernel::Call;

use super::guard::call;
use super::types::*;

const NO_STATE: &str = "canGetAndSetFMUstate = false";
const NO_SERIALIZATION: &str = "canSerializeFMUstate = false";

/// `fmi2GetFMUstate`
pub unsafe fn fmi2GetFMUstate(c: fmi2Component, _state: *mut fmi2FMUstate) -> fmi2Status {
    call(c, Call::GetFmuState, |instance| {
        instance.unsupported(Call::GetFmuState, NO_STATE)
    })
}

/// `fmi2SetFMUstate`
pub unsafe fn fmi2SetFMUstate(c: fmi2Component, _state: fmi2FMUstate) -> fmi2Status {
    call(c, Call::SetFmuState, |instance| {
        instance.unsupported(Call::SetFmuState, NO_STATE)
    })
}

/// `fmi2FreeFMUstate`
pub unsafe fn fmi2FreeFMUstate(c: fmi2Component, _state: *mut fmi2FMUstate) -> fmi2Status {
    call(c, Call::FreeFmuState, |instance| {
        instance.unsupported(Call::FreeFmuState, NO_STATE)
    })
}

/// `fmi2SerializedFMUstateSize`
pub unsafe fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    _state: fmi2FMUstate,
    _size: *mut usize,
) -> fmi2Status {
    call(c, Call::SerializedFmuStateSize, |instance| {
        instance.unsupported(Call::SerializedFmuStateSize, NO_SERIALIZATION)
    })
}

/// `fmi2SerializeFMUstate`
pub unsafe fn fmi2SerializeFMUstate(
    c: fmi2Component,
    _state: fmi2FMUstate,
    _bytes: *mut fmi2Byte,
    _size: usize,
) -> fmi2Status {
    call(c, Call::SerializeFmuState, |instance| {
        instance.unsupported(Call::SerializeFmuState, NO_SERIALIZATION)
    })
}

/// `fmi2DeSerializeFMUstate`
pub unsafe fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    _bytes: *const fmi2Byte,
    _size: usize,
    _state: *mut fmi2FMUstate,
) -> fmi2Status {
    call(c, Call::DeSerializeFmuState, |instance| {
        instance.unsupported(Call::DeSerializeFmuState, NO_SERIALIZATION)
    })
}

/// `fmi2GetDirectionalDerivative`
pub unsafe fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    _unknowns: *const fmi2ValueReference,
    _n_unknown: usize,
    _knowns: *const fmi2ValueReference,
    _n_known: usize,
    _dv_known: *const fmi2Real,
    _dv_unknown: *mut fmi2Real,
) -> fmi2Status {
    call(c, Call::GetDirectionalDerivative, |instance| {
        let flag = "providesDirectionalDerivative = false";
        instance.unsupported(Call::GetDirectionalDerivative, flag)
    })
}
