//! The importer's floating-point environment: traps, roundings, flush-to-zero and flags change no
//! result, and are restored after each call.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![cfg(target_arch = "x86_64")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

mod host;

use std::arch::asm;
use std::ptr::null_mut;

use fmu_kit::kernel::Status;
use rexrov_fmu::{REGISTRY, fmi2};

/// MXCSR: the default; all traps; rounding down, up, to zero; flush-to-zero and denormals-are-zero;
/// all flags raised.
const DEFAULT: u32 = 0x1F80;
const STRANGE: [u32; 6] = [0x0000, 0x3F80, 0x5F80, 0x7F80, 0x9FC0, 0x1FBF];

fn environment() -> u32 {
    let mut word = 0_u32;
    unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut word) };
    word
}

fn change(word: u32) {
    unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const word) };
}

/// Makes one call in an environment.
fn under<R>(word: u32, call: impl FnOnce() -> R) -> R {
    change(word);
    let result = call();
    let after = environment();
    change(DEFAULT);
    assert_eq!(after, word, "the environment is another after the call");
    result
}

/// All Reals after some steps with changing inputs, and a state saved, serialized and restored.
fn run(name: &str, word: u32) -> Vec<u64> {
    let table = REGISTRY.named(name).unwrap().table();
    let layout = table.layout();
    let ok = |call: &dyn Fn() -> Status| assert_eq!(under(word, call), Status::Ok, "{name}");
    let c = under(word, || host::instantiate(name, 1));
    ok(&|| unsafe { fmi2::fmi2SetupExperiment(c, 1, 1e-6, 0.0, 1, 1e3) });
    ok(&|| unsafe { fmi2::fmi2EnterInitializationMode(c) });
    ok(&|| unsafe { fmi2::fmi2ExitInitializationMode(c) });
    let inputs: Vec<u32> = layout.inputs.clone().map(|reference| reference as u32).collect();
    let all: Vec<u32> = (0..=layout.time as u32).collect();
    let mut reals = vec![0.0; all.len()];
    let mut state = null_mut();
    for step in 0..150_u32 {
        let wave = |input: &u32| (f64::from(step) * 0.37 + f64::from(*input)).sin() / 3.0;
        let values: Vec<f64> = inputs.iter().map(wave).collect();
        let (vr, n) = (inputs.as_ptr(), inputs.len());
        ok(&|| unsafe { fmi2::fmi2SetReal(c, vr, n, values.as_ptr()) });
        let t = f64::from(step) / 64.0;
        ok(&|| unsafe { fmi2::fmi2DoStep(c, t, 1.0 / 64.0, 1) });
        if step == 75 {
            let place = &raw mut state;
            ok(&|| unsafe { fmi2::fmi2GetFMUstate(c, place) });
            ok(&|| unsafe { fmi2::fmi2SetFMUstate(c, *place) });
        }
    }
    let (vr, n, place) = (all.as_ptr(), all.len(), reals.as_mut_ptr());
    ok(&|| unsafe { fmi2::fmi2GetReal(c, vr, n, place) });
    under(word, || unsafe { fmi2::fmi2FreeInstance(c) });
    reals.iter().map(|real| real.to_bits()).collect()
}

#[test]
fn no_environment_changes_a_result_or_is_changed() {
    for entry in REGISTRY.entries() {
        let name = entry.info().name;
        let wanted = run(name, DEFAULT | 0x3F);
        for word in STRANGE {
            assert_eq!(run(name, word), wanted, "{name} under {word:#x}");
        }
    }
}
