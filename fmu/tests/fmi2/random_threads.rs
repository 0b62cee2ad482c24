//! Several threads that make arbitrary calls on the same instances and states, including freeing,
//! from any source of bytes; shared by the fuzz target and the ordinary tests. FMI forbids this; it
//! must give errors, not harm.

use std::ffi::CString;
use std::ptr::{null, null_mut, without_provenance_mut};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;

use crate::components::{REGISTRY, fmi2};
use crate::driver::callbacks;

const THREADS: usize = 4;
/// Bytes of one call.
const RECORD: usize = 4;

/// Shared by the threads: handles of instances and of states, live or not.
struct Shared {
    instances: [AtomicUsize; 4],
    states: [AtomicUsize; 4],
}

/// Each thread processes its part of the bytes; then everything is freed, and checked to be dead.
pub fn run(bytes: &[u8]) {
    let shared = Shared {
        instances: std::array::from_fn(|place| AtomicUsize::new(started(place))),
        states: Default::default(),
    };
    let ready = AtomicUsize::new(0);
    thread::scope(|scope| {
        let parts = bytes.chunks(bytes.len().div_ceil(THREADS).max(RECORD));
        let threads = parts.map(|part| {
            scope.spawn(|| {
                ready.fetch_add(1, Ordering::AcqRel);
                // All begin together, as far as there are processors for them.
                for _ in 0..1000 {
                    if ready.load(Ordering::Acquire) == THREADS {
                        break;
                    }
                    std::hint::spin_loop();
                }
                part.chunks_exact(RECORD).for_each(|record| call(&shared, record));
            })
        });
        // The end of a scope does not wait for what threads drop last, which a leak checker sees.
        let threads: Vec<_> = threads.collect();
        threads.into_iter().for_each(|thread| thread.join().unwrap());
    });
    for instance in shared.instances {
        let c = without_provenance_mut(instance.into_inner());
        unsafe { fmi2::fmi2FreeInstance(c) };
        assert_eq!(unsafe { fmi2::fmi2Reset(c) }, Status::Error);
    }
}

/// A new instance of one of the components, after initialization.
fn started(choice: usize) -> usize {
    let name = ["Spring", "Noise", "Ball", "Clumsy"][choice % 4];
    let guid = CString::new(REGISTRY.named(name).unwrap().guid()).unwrap();
    let functions = fmi2CallbackFunctions { logger: None, ..callbacks(null_mut()) };
    let (f, interface) = (&raw const functions, i32::from(choice % 8 < 4));
    unsafe {
        let c = fmi2::fmi2Instantiate(c"x".as_ptr(), interface, guid.as_ptr(), null(), f, 0, 0);
        fmi2::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
        fmi2::fmi2EnterInitializationMode(c);
        fmi2::fmi2ExitInitializationMode(c);
        c.addr()
    }
}

fn call(shared: &Shared, record: &[u8]) {
    let &[function, which, a, b] = record else { return };
    let instance = &shared.instances[usize::from(which) % 4];
    let kept = &shared.states[usize::from(which / 4) % 4];
    let c = without_provenance_mut(instance.load(Ordering::Relaxed));
    let mut state = without_provenance_mut(kept.load(Ordering::Relaxed));
    let vr = [u32::from(a) % 12, u32::from(b) % 12];
    let (mut reals, mut integers, mut texts) = ([f64::from(a), -1.0], [1, 0], [c"t".as_ptr(); 2]);
    let (v, r, i, s) = (vr.as_ptr(), reals.as_mut_ptr(), integers.as_mut_ptr(), texts.as_mut_ptr());
    let n = usize::from(b) % 3;
    let (mut info, mut status, mut size) = (fmi2EventInfo::default(), Status::Ok, 0);
    let (mut x, mut y, mut bytes) = (0, 0, [0; 4096]);
    unsafe {
        match function % 48 {
            0..3 => fmi2::fmi2FreeInstance(c),
            3..5 => {
                let new = started(usize::from(a));
                let old = without_provenance_mut(instance.swap(new, Ordering::Relaxed));
                fmi2::fmi2FreeInstance(old);
            }
            5 => _ = fmi2::fmi2SetDebugLogging(c, 0, 0, null()),
            6 => _ = fmi2::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            7 => _ = fmi2::fmi2EnterInitializationMode(c),
            8 => _ = fmi2::fmi2ExitInitializationMode(c),
            9 => _ = fmi2::fmi2Terminate(c),
            10 => _ = fmi2::fmi2Reset(c),
            11 => _ = fmi2::fmi2GetReal(c, v, n, r),
            12 => _ = fmi2::fmi2GetInteger(c, v, n, i),
            13 => _ = fmi2::fmi2GetBoolean(c, v, n, i),
            14 => _ = fmi2::fmi2GetString(c, v, n, s),
            15 => _ = fmi2::fmi2SetReal(c, v, n, r),
            16 => _ = fmi2::fmi2SetInteger(c, v, n, i),
            17 => _ = fmi2::fmi2SetBoolean(c, v, n, i),
            18 => _ = fmi2::fmi2SetString(c, v, n, s),
            19..22 => {
                state = if a < 128 { null_mut() } else { state };
                fmi2::fmi2GetFMUstate(c, &raw mut state);
                kept.store(state.addr(), Ordering::Relaxed);
            }
            22 => _ = fmi2::fmi2SetFMUstate(c, state),
            23..25 => _ = fmi2::fmi2FreeFMUstate(c, &raw mut state),
            25..27 => {
                let at = bytes.as_mut_ptr();
                fmi2::fmi2SerializedFMUstateSize(c, state, &raw mut size);
                if size <= bytes.len() {
                    fmi2::fmi2SerializeFMUstate(c, state, at, size);
                    let mut made = null_mut();
                    fmi2::fmi2DeSerializeFMUstate(c, at, size, &raw mut made);
                    kept.store(made.addr(), Ordering::Relaxed);
                }
            }
            27 => _ = fmi2::fmi2GetDirectionalDerivative(c, v, n, v, n, r, [0.0; 2].as_mut_ptr()),
            28 => _ = fmi2::fmi2EnterEventMode(c),
            29 => _ = fmi2::fmi2NewDiscreteStates(c, &raw mut info),
            30 => _ = fmi2::fmi2EnterContinuousTimeMode(c),
            31 => _ = fmi2::fmi2CompletedIntegratorStep(c, 1, &raw mut x, &raw mut y),
            32 => _ = fmi2::fmi2SetTime(c, f64::from(a) / 10.0),
            33 => _ = fmi2::fmi2SetContinuousStates(c, r, n),
            34 => _ = fmi2::fmi2GetDerivatives(c, r, n),
            35 => _ = fmi2::fmi2GetEventIndicators(c, r, n),
            36 => _ = fmi2::fmi2GetContinuousStates(c, r, n),
            37 => _ = fmi2::fmi2GetNominalsOfContinuousStates(c, r, n),
            38 => _ = fmi2::fmi2SetRealInputDerivatives(c, v, n, i, r),
            39 => _ = fmi2::fmi2GetRealOutputDerivatives(c, v, n, i, r),
            40 => _ = fmi2::fmi2CancelStep(c),
            41 => _ = fmi2::fmi2GetStatus(c, 0, &raw mut status),
            42 => _ = fmi2::fmi2GetRealStatus(c, 2, r),
            43 => _ = fmi2::fmi2GetIntegerStatus(c, 1, i),
            44 => _ = fmi2::fmi2GetBooleanStatus(c, 3, i),
            45 => _ = fmi2::fmi2GetStringStatus(c, 1, s),
            _ => {
                let mut t = 0.0;
                if fmi2::fmi2GetRealStatus(c, 2, &raw mut t) == Status::Ok {
                    fmi2::fmi2DoStep(c, t, f64::from(a) / 100.0, 1);
                }
            }
        }
    }
}
