//! Getting and setting values (FMI 2.0.4, section 2.1.7).

use crate::kernel::{Call, Served, spare};

use super::arguments::{array, array_mut, copies, plain_array, plain_array_mut};
use super::guard::{call, done_simply};
use super::handles::Library;
use super::types::*;

/// Both arrays of a get or set function, or the rejection.
macro_rules! arrays {
    ($instance:ident, $call:expr, $vr:ident, $value:ident, $n:ident, $array:ident) => {{
        // SAFETY: the importer passes arrays of `nvr` elements, as the standard requires, and
        // leaves them alone during the call.
        let arrays = unsafe { (array("vr", $vr, $n), $array("value", $value, $n)) };
        match arrays {
            (Ok(references), Ok(values)) => (references, values),
            (Err(wrong), _) | (_, Err(wrong)) => return $instance.refuse($call, &wrong),
        }
    }};
}

/// `fmi2GetReal`
#[inline]
pub unsafe fn fmi2GetReal<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    let simply = done_simply::<L>(c, |instance| {
        // SAFETY: the importer passes arrays of `nvr` elements, as the standard requires, and
        // leaves them alone during the call.
        let (references, values) = unsafe { (plain_array(vr, nvr)?, plain_array_mut(value, nvr)?) };
        instance.get_fresh(references, values)
    });
    if simply { fmi2Status::Ok } else { get_real::<L>(c, vr, nvr, value) }
}

#[inline(never)]
fn get_real<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    call::<L>(c, Call::GetReal, |instance| {
        let (references, values) = arrays!(instance, Call::GetReal, vr, value, nvr, array_mut);
        instance.get_real(references, values)
    })
}

/// `fmi2GetInteger`
pub unsafe fn fmi2GetInteger<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    call::<L>(c, Call::GetInteger, |instance| {
        let (references, values) = arrays!(instance, Call::GetInteger, vr, value, nvr, array_mut);
        instance.get_integer(references, values)
    })
}

/// `fmi2GetBoolean`
pub unsafe fn fmi2GetBoolean<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    call::<L>(c, Call::GetBoolean, |instance| {
        let (references, values) = arrays!(instance, Call::GetBoolean, vr, value, nvr, array_mut);
        instance.get_boolean(references, |index, truth| {
            if let Some(place) = values.get_mut(index) {
                *place = fmi2Boolean::from(truth);
            }
        })
    })
}

/// `fmi2GetString`; the strings stay valid until the next call on this instance.
pub unsafe fn fmi2GetString<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2String,
) -> fmi2Status {
    call::<L>(c, Call::GetString, |instance| {
        let (references, values) = arrays!(instance, Call::GetString, vr, value, nvr, array_mut);
        instance.get_string(references, |index, text| {
            if let Some(place) = values.get_mut(index) {
                *place = text.as_ptr();
            }
        })
    })
}

/// `fmi2SetReal`
#[inline]
pub unsafe fn fmi2SetReal<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    let simply = done_simply::<L>(c, |instance| {
        // SAFETY: as in `fmi2GetReal`.
        let (references, values) = unsafe { (plain_array(vr, nvr)?, plain_array(value, nvr)?) };
        instance.set_inputs(references, values)
    });
    if simply { fmi2Status::Ok } else { set_real::<L>(c, vr, nvr, value) }
}

#[inline(never)]
fn set_real<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    call::<L>(c, Call::SetReal, |instance| {
        let (references, values) = arrays!(instance, Call::SetReal, vr, value, nvr, array);
        instance.set_real(references, values)
    })
}

/// `fmi2SetInteger`
pub unsafe fn fmi2SetInteger<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    call::<L>(c, Call::SetInteger, |instance| {
        let (references, values) = arrays!(instance, Call::SetInteger, vr, value, nvr, array);
        instance.set_integer(references, values)
    })
}

/// `fmi2SetBoolean`
pub unsafe fn fmi2SetBoolean<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    call::<L>(c, Call::SetBoolean, |instance| {
        let (references, values) = arrays!(instance, Call::SetBoolean, vr, value, nvr, array);
        if let Err(trouble) = spare(values.len()) {
            return instance.refuse(Call::SetBoolean, &trouble.text);
        }
        let truths: Vec<bool> = values.iter().map(|value| *value != FMI2_FALSE).collect();
        instance.set_boolean(references, &truths)
    })
}

/// `fmi2SetString`
pub unsafe fn fmi2SetString<L: Library>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2String,
) -> fmi2Status {
    call::<L>(c, Call::SetString, |instance| {
        let (references, values) = arrays!(instance, Call::SetString, vr, value, nvr, array);
        // SAFETY: the importer passes NUL-terminated strings, as the standard requires.
        match unsafe { copies("value", values) } {
            Ok(texts) => instance.set_string(references, &texts),
            Err(wrong) => instance.refuse(Call::SetString, &wrong),
        }
    })
}
