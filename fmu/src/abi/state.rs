//! Saved states (FMI 2.0.4, section 2.1.8).
//!
//! `fmi2FMUstate` is a number like a component handle. A state may be restored into any instance of
//! its component; it is removed when it is freed, or with the instance it was made from.

use std::ffi::c_void;

use crate::kernel::{Call, Served, Status};

use super::arguments::{Wrong, array, array_mut, place};
use super::guard::call_live;
use super::handles::{Library, Live, Nothing};
use super::types::*;

/// The message for an invalid state handle.
const fn why(nothing: Nothing) -> &'static str {
    match nothing {
        Nothing::Dead => "FMUstate is not a saved state; it was freed, or never given out",
        Nothing::Busy => "another call is using the FMUstate; let it return first",
    }
}

const TOO_MANY: &str = "there are too many saved states, or no memory for more; free some";

/// Gives a state a handle that its instance remembers.
fn keep<L: Library>(
    live: &mut Live<L::Instance>,
    state: Box<<L::Instance as Served>::State>,
    call: Call,
    into: &mut fmi2FMUstate,
) -> Status {
    // Handles freed through another instance are removed when the list would have to grow.
    if live.states.len() == live.states.capacity() {
        live.states.retain(|old| L::shelf().states.lives(std::ptr::without_provenance_mut(*old)));
    }
    let room = live.states.try_reserve(1);
    let Some(handle) = room.ok().and_then(|()| L::shelf().states.insert(state)) else {
        return live.instance.refuse(call, TOO_MANY);
    };
    live.states.push(handle.addr());
    *into = handle;
    Status::Ok
}

/// Runs `work` on a saved state.
fn with_state<L: Library>(
    instance: &mut L::Instance,
    call: Call,
    handle: *mut c_void,
    work: impl FnOnce(&mut L::Instance, &mut <L::Instance as Served>::State) -> Status,
) -> Status {
    L::shelf()
        .states
        .with(handle, |state| work(instance, state))
        .unwrap_or_else(|nothing| instance.refuse(call, why(nothing)))
}

/// `fmi2GetFMUstate`: a new state if `*FMUstate` is NULL, else that state is overwritten.
pub unsafe fn fmi2GetFMUstate<L: Library>(
    c: fmi2Component,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    let this = Call::GetFmuState;
    call_live::<L>(c, this, |live| {
        // SAFETY: the importer passes one handle to fill, as the standard requires.
        let handle = match unsafe { place("FMUstate", FMUstate) } {
            Ok(handle) => handle,
            Err(wrong) => return live.instance.refuse(this, &wrong),
        };
        if !handle.is_null() {
            let instance = &mut live.instance;
            return with_state::<L>(instance, this, *handle, |me, state| me.get_state_again(state));
        }
        let mut state = None;
        match (live.instance.get_state(&mut state), state) {
            (Status::Ok, Some(state)) => keep::<L>(live, state, this, handle),
            (status, _) => status,
        }
    })
}

/// `fmi2SetFMUstate`
pub unsafe fn fmi2SetFMUstate<L: Library>(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status {
    let this = Call::SetFmuState;
    call_live::<L>(c, this, |live| {
        with_state::<L>(&mut live.instance, this, FMUstate, |me, state| me.set_state(state))
    })
}

/// `fmi2FreeFMUstate`: NULL is ignored, and a freed handle becomes NULL.
pub unsafe fn fmi2FreeFMUstate<L: Library>(
    c: fmi2Component,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    let this = Call::FreeFmuState;
    call_live::<L>(c, this, |live| {
        let status = live.instance.may(this);
        if status != Status::Ok || FMUstate.is_null() {
            return status;
        }
        // SAFETY: the importer passes one handle, as the standard requires.
        let handle = match unsafe { place("FMUstate", FMUstate) } {
            Ok(handle) if handle.is_null() => return Status::Ok,
            Ok(handle) => handle,
            Err(wrong) => return live.instance.refuse(this, &wrong),
        };
        if let Err(nothing) = L::shelf().states.remove(*handle) {
            return live.instance.refuse(this, why(nothing));
        }
        let freed = handle.addr();
        live.states.retain(|state| *state != freed);
        *handle = std::ptr::null_mut();
        Status::Ok
    })
}

/// `fmi2SerializedFMUstateSize`
pub unsafe fn fmi2SerializedFMUstateSize<L: Library>(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    let this = Call::SerializedFmuStateSize;
    call_live::<L>(c, this, |live| {
        // SAFETY: the importer passes one size to fill, as the standard requires.
        match unsafe { place("size", size) } {
            Ok(size) => with_state::<L>(&mut live.instance, this, FMUstate, |me, state| {
                me.serialized_size(state, size)
            }),
            Err(wrong) => live.instance.refuse(this, &wrong),
        }
    })
}

/// `fmi2SerializeFMUstate`
pub unsafe fn fmi2SerializeFMUstate<L: Library>(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    let this = Call::SerializeFmuState;
    call_live::<L>(c, this, |live| {
        // SAFETY: the importer passes `size` bytes to fill, as the standard requires.
        match unsafe { array_mut("serializedState", serializedState.cast::<u8>(), size) } {
            Ok(bytes) => with_state::<L>(&mut live.instance, this, FMUstate, |me, state| {
                me.serialize_state(state, bytes)
            }),
            Err(wrong) => live.instance.refuse(this, &wrong),
        }
    })
}

/// `fmi2DeSerializeFMUstate`: always a new state.
pub unsafe fn fmi2DeSerializeFMUstate<L: Library>(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    let this = Call::DeSerializeFmuState;
    call_live::<L>(c, this, |live| {
        // SAFETY: the importer passes `size` bytes and one handle to fill, as the standard requires.
        let arguments: Result<_, Wrong> = unsafe {
            array("serializedState", serializedState.cast::<u8>(), size)
                .and_then(|bytes| Ok((bytes, place("FMUstate", FMUstate)?)))
        };
        let (bytes, handle) = match arguments {
            Ok(arguments) => arguments,
            Err(wrong) => return live.instance.refuse(this, &wrong),
        };
        let mut state = None;
        match (live.instance.deserialize_state(bytes, &mut state), state) {
            (Status::Ok, Some(state)) => keep::<L>(live, state, this, handle),
            (status, _) => status,
        }
    })
}
