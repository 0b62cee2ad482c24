//! Random sequences of calls of all 44 functions, from any source of bytes; shared by the fuzz
//! target and the ordinary tests.
//!
//! Handles may be valid, freed or invented; arrays are as long as the call says, or NULL; numbers
//! of elements may be absurd if that must be rejected before anything is read. Every call must
//! return; on a live instance every status but `fmi2OK` must come with exactly one line that begins
//! with the function's name, and `fmi2OK` with none; a dead handle must give `fmi2Error`.
//!
//! Each call is made from a record of fixed length, so that a fuzzer can exchange and repeat calls.

use std::ffi::CString;
use std::ptr::{null, null_mut, without_provenance_mut};

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;

use crate::components::{REGISTRY, fmi2};
use crate::driver::{Line, callbacks};

/// Bytes of one call.
const RECORD: usize = 32;

/// Bytes to make choices from; zeros when they are used up.
pub struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    /// The bytes of the next call, if there is one.
    fn record(&mut self) -> Option<Bytes<'a>> {
        let (record, rest) = self.0.split_at(RECORD.min(self.0.len()));
        self.0 = rest;
        (!record.is_empty()).then_some(Bytes(record))
    }

    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    fn below(&mut self, n: usize) -> usize {
        (usize::from(self.byte()) << 8 | usize::from(self.byte())) % n.max(1)
    }

    fn real(&mut self) -> f64 {
        match self.byte() % 16 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => -1.0,
            3 => {
                let sign = if self.byte() < 128 { 1.0 } else { -1.0 };
                sign * 10_f64.powi(i32::from(self.byte()))
            }
            4 => 1e-16,
            5 => f64::from(self.byte()),
            _ => f64::from(self.byte()) / 100.0,
        }
    }

    fn references(&mut self, n: usize) -> Vec<u32> {
        (0..n).map(|_| if self.byte() == 0 { u32::MAX } else { self.byte() as u32 % 20 }).collect()
    }
}

/// An instance, and whether it has not been freed yet.
struct Handle {
    c: fmi2Component,
    live: bool,
}

/// What the calls work with.
struct World {
    components: Vec<Handle>,
    states: Vec<fmi2FMUstate>,
    serialized: Vec<u8>,
    /// Time of the last step, so that some steps are consecutive.
    time: f64,
    #[expect(clippy::box_collection, reason = "the logger knows the address of the Vec itself")]
    lines: Box<Vec<Line>>,
}

/// Runs calls until the bytes are used up; returns how many there were.
pub fn run(mut bytes: Bytes<'_>) -> usize {
    let mut world = World {
        components: Vec::new(),
        states: vec![null_mut()],
        serialized: Vec::new(),
        time: 0.0,
        lines: Box::default(),
    };
    let mut calls = 0;
    while let Some(mut bytes) = bytes.record() {
        world.lines.clear();
        // Instances and initialization occur more often than by chance alone.
        if world.components.is_empty() || bytes.byte() < 6 {
            calls += world.instantiate(&mut bytes);
            continue;
        }
        calls += 1;
        let (status, live) = world.call(&mut bytes);
        let (expected, lines) = (usize::from(live && status != Status::Ok), &world.lines);
        assert_eq!(lines.len(), expected, "{status:?} {lines:?}");
        for line in &**lines {
            assert!(line.status == status && line.text.starts_with("fmi2"), "{status:?} {line:?}");
        }
    }
    for handle in world.components {
        unsafe { fmi2::fmi2FreeInstance(handle.c) };
    }
    calls
}

impl World {
    /// Makes an instance and usually starts it; returns how many calls that took.
    fn instantiate(&mut self, bytes: &mut Bytes<'_>) -> usize {
        let entries: Vec<_> = REGISTRY.entries().collect();
        let guid = CString::new(entries[bytes.below(entries.len())].guid()).unwrap();
        let functions = callbacks(&raw mut *self.lines);
        let guid = if bytes.byte() == 0 { null() } else { guid.as_ptr() };
        let (interface, location) = (i32::from(bytes.byte() % 2), c"file:///nowhere".as_ptr());
        let c = unsafe {
            let f = &raw const functions;
            fmi2::fmi2Instantiate(c"random".as_ptr(), interface, guid, location, f, 0, 0)
        };
        if c.is_null() {
            assert_eq!(self.lines.len(), 1);
        } else if self.components.len() < 8 {
            self.components.push(Handle { c, live: true });
        } else {
            unsafe { fmi2::fmi2FreeInstance(c) };
            return 2;
        }
        if c.is_null() || bytes.byte() >= 200 {
            return 1;
        }
        unsafe {
            fmi2::fmi2SetupExperiment(c, 1, 1e-4, 0.0, 0, 0.0);
            fmi2::fmi2EnterInitializationMode(c);
            fmi2::fmi2ExitInitializationMode(c);
        }
        self.time = 0.0;
        4
    }

    /// Calls one function; returns its status and whether there is a live instance to report it.
    fn call(&mut self, bytes: &mut Bytes<'_>) -> (Status, bool) {
        let slot = bytes.below(self.components.len());
        let c = match bytes.byte() {
            0 => without_provenance_mut(bytes.below(1 << 16) | bytes.below(1 << 16) << 32),
            _ => self.components[slot].c,
        };
        // An invented handle may be valid.
        let handle = self.components.iter().position(|handle| handle.c == c && handle.live);
        let live = handle.is_some();
        let n = bytes.below(5);
        let vr = bytes.references(n);
        let mut reals: Vec<f64> = (0..n).map(|_| bytes.real()).collect();
        let mut integers: Vec<i32> = (0..n).map(|_| i32::from(bytes.byte() % 6) - 1).collect();
        let mut texts = [c"text".as_ptr(); 5];
        if bytes.byte() < 20 {
            texts[bytes.below(5)] = null();
        }
        let nothing = bytes.byte() < 8;
        let vr = if nothing { null() } else { vr.as_ptr() };
        let real = if bytes.byte() < 4 { null_mut() } else { reals.as_mut_ptr() };
        let (integer, text) = (integers.as_mut_ptr(), texts.as_mut_ptr());
        // An absurd number is rejected by its size or because the array is NULL.
        let n = if bytes.byte() == 0 { usize::MAX - 3 } else { n };
        let (mut info, mut a, mut b) = (fmi2EventInfo::default(), 0, 0);
        let (mut status, mut one) = (Status::Ok, 0.0);
        let pick = bytes.below(self.states.len());
        let mut state = self.states[pick];
        let (x, h) = (bytes.real(), bytes.real());
        // Usually plausible values, because steps of a million events are slow.
        let h = if bytes.byte() < 4 { 1e9 * h } else { h.clamp(-1.0, 3.0) };
        let t = if bytes.byte() < 20 { x } else { self.time };
        let result = unsafe {
            match bytes.below(45) {
                0 => fmi2::fmi2SetDebugLogging(c, 0, n.min(2) / 2, text),
                1 if bytes.byte() < 40 => {
                    fmi2::fmi2FreeInstance(c);
                    // The handle stays in the list: any call with it must be rejected.
                    if let Some(handle) = handle {
                        self.components[handle].live = false;
                    }
                    return (Status::Ok, live);
                }
                2 => fmi2::fmi2SetupExperiment(c, a, x, t, b, h),
                3 => fmi2::fmi2EnterInitializationMode(c),
                4 => fmi2::fmi2ExitInitializationMode(c),
                5 if bytes.byte() < 40 => fmi2::fmi2Terminate(c),
                6 => fmi2::fmi2Reset(c),
                7 => fmi2::fmi2GetReal(c, vr, n, real),
                8 => fmi2::fmi2GetInteger(c, vr, n, integer),
                9 => fmi2::fmi2GetBoolean(c, vr, n, integer),
                10 => fmi2::fmi2GetString(c, vr, n, text),
                11 => fmi2::fmi2SetReal(c, vr, n, real),
                12 => fmi2::fmi2SetInteger(c, vr, n, integer),
                13 => fmi2::fmi2SetBoolean(c, vr, n, integer),
                14 => fmi2::fmi2SetString(c, vr, n, text),
                15 => {
                    let status = fmi2::fmi2GetFMUstate(c, &raw mut state);
                    if status == Status::Ok && self.states.len() < 20 {
                        self.states.push(state);
                    }
                    status
                }
                16 => fmi2::fmi2SetFMUstate(c, state),
                17 => fmi2::fmi2FreeFMUstate(c, &raw mut state),
                18 => {
                    let mut size = 0;
                    let status = fmi2::fmi2SerializedFMUstateSize(c, state, &raw mut size);
                    if status != Status::Ok {
                        return (status, live);
                    }
                    self.serialized = vec![0; size];
                    let place = self.serialized.as_mut_ptr().cast();
                    fmi2::fmi2SerializeFMUstate(c, state, place, size)
                }
                19 => {
                    let mut copy = self.serialized.clone();
                    if bytes.byte() < 128 && !copy.is_empty() {
                        let place = bytes.below(copy.len());
                        copy[place] ^= bytes.byte();
                    }
                    let mut made = null_mut();
                    let place = &raw mut made;
                    let status =
                        fmi2::fmi2DeSerializeFMUstate(c, copy.as_ptr().cast(), copy.len(), place);
                    if status == Status::Ok && self.states.len() < 20 {
                        self.states.push(made);
                    }
                    status
                }
                20 => {
                    let mut into = [0.0; 8];
                    let into = into.as_mut_ptr();
                    fmi2::fmi2GetDirectionalDerivative(c, vr, n, vr, n, real, into)
                }
                21 => fmi2::fmi2EnterEventMode(c),
                22 => fmi2::fmi2NewDiscreteStates(c, &raw mut info),
                23 => fmi2::fmi2EnterContinuousTimeMode(c),
                24 => fmi2::fmi2CompletedIntegratorStep(c, 1, &raw mut a, &raw mut b),
                25 if bytes.byte() < 4 => fmi2::fmi2SetTime(c, 1e9 * x),
                25 => fmi2::fmi2SetTime(c, x.min(1e3)),
                26 => fmi2::fmi2SetContinuousStates(c, real, n),
                27 => fmi2::fmi2GetDerivatives(c, real, n),
                28 => fmi2::fmi2GetEventIndicators(c, real, n),
                29 => fmi2::fmi2GetContinuousStates(c, real, n),
                30 => fmi2::fmi2GetNominalsOfContinuousStates(c, real, n),
                31 => fmi2::fmi2SetRealInputDerivatives(c, vr, n, integer, real),
                32 => fmi2::fmi2GetRealOutputDerivatives(c, vr, n, integer, real),
                33 => fmi2::fmi2CancelStep(c),
                34 => fmi2::fmi2GetStatus(c, a, &raw mut status),
                35 => fmi2::fmi2GetRealStatus(c, 2, &raw mut one),
                36 => fmi2::fmi2GetIntegerStatus(c, 1, &raw mut a),
                37 => fmi2::fmi2GetBooleanStatus(c, 3, &raw mut a),
                38 => fmi2::fmi2GetStringStatus(c, 1, text),
                39 => {
                    let texts = [fmi2::fmi2GetVersion(), fmi2::fmi2GetTypesPlatform()];
                    assert!(texts.iter().all(|text| !text.is_null()));
                    return (Status::Ok, live);
                }
                _ => {
                    let status = fmi2::fmi2DoStep(c, t, h, 1);
                    if status == Status::Ok {
                        self.time = t + h;
                    }
                    status
                }
            }
        };
        assert!(live || result == Status::Error, "{result:?} of nothing");
        (result, live)
    }
}
