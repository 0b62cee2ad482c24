//! The first slope of a step is taken from the outputs if they are up to date. This must have no
//! visible effect: of two identically driven vehicles, one is disturbed and restored before each
//! step, so that it has nothing cached and computes everything again.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

use std::ffi::CString;
use std::ptr::{null, null_mut};

use fmu_kit::abi::types::*;
use fmu_kit::kernel::{Group, Status, Table};
use rexrov_fmu::{REGISTRY, fmi2};

fn table() -> &'static Table {
    REGISTRY.named("RexROV").unwrap().table()
}

fn references(group: Group) -> Vec<u32> {
    table().group(group).map(|(_, variable)| variable.reference).collect()
}

/// The same choices in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963);
        (self.0 >> 33) as usize % n
    }

    /// Within +-`most`, including zeros of both signs.
    fn value(&mut self, most: f64) -> f64 {
        match self.below(4) {
            0 => 0.0,
            1 => -0.0,
            _ => most * (self.below(2001) as f64 / 1000.0 - 1.0),
        }
    }
}

/// Two identically driven vehicles.
struct Pair([fmi2Component; 2]);

impl Pair {
    fn each(&self, call: impl Fn(fmi2Component) -> Status) {
        self.0.iter().for_each(|c| assert_eq!(call(*c), Status::Ok));
    }

    /// In co-simulation, with thruster mode `mode` and integration method `method`.
    fn new(mode: i32, method: i32) -> Self {
        let guid = CString::new(REGISTRY.named("RexROV").unwrap().guid()).unwrap();
        let functions = fmi2CallbackFunctions {
            logger: None,
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: null_mut(),
        };
        let make = || unsafe {
            let f = &raw const functions;
            fmi2::fmi2Instantiate(c"test".as_ptr(), 1, guid.as_ptr(), null(), f, 0, 0)
        };
        let pair = Self([make(), make()]);
        pair.start(mode, method);
        pair
    }

    fn start(&self, mode: i32, method: i32) {
        let names = ["thruster_mode", "integrator.method"];
        let names = names.map(|name| table().named(name).unwrap().reference);
        let values = [mode, method];
        self.each(|c| unsafe { fmi2::fmi2SetInteger(c, names.as_ptr(), 2, values.as_ptr()) });
        self.each(|c| unsafe { fmi2::fmi2EnterInitializationMode(c) });
        self.each(|c| unsafe { fmi2::fmi2ExitInitializationMode(c) });
    }

    fn set(&self, reference: u32, value: f64) {
        self.each(|c| unsafe { fmi2::fmi2SetReal(c, &raw const reference, 1, &raw const value) });
    }

    /// The second one drops its cached values before it steps.
    fn step(&self, t: f64, h: f64) {
        let c = self.0[1];
        let input = references(Group::Input)[0];
        let mut value = 0.0;
        unsafe {
            assert_eq!(fmi2::fmi2GetReal(c, &raw const input, 1, &raw mut value), Status::Ok);
            for value in [value + 1.0, value] {
                fmi2::fmi2SetReal(c, &raw const input, 1, &raw const value);
            }
        }
        self.each(|c| unsafe { fmi2::fmi2DoStep(c, t, h, 1) });
    }

    fn bits(&self, references: &[u32]) -> [Vec<u64>; 2] {
        self.0.map(|c| {
            let mut values = vec![0.0; references.len()];
            let (vr, n) = (references.as_ptr(), references.len());
            assert_eq!(unsafe { fmi2::fmi2GetReal(c, vr, n, values.as_mut_ptr()) }, Status::Ok);
            values.into_iter().map(f64::to_bits).collect()
        })
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        self.0.iter().for_each(|c| unsafe { fmi2::fmi2FreeInstance(*c) });
    }
}

#[test]
fn what_is_known_at_the_beginning_of_a_step_changes_no_bit() {
    let inputs = references(Group::Input);
    let seen = [Group::State, Group::Output, Group::Derivative].map(references).concat();
    for run in 0..24 {
        let (mode, method) = (1 + run % 3, 1 + run / 3 % 2);
        let mut random = Random(run as u64);
        let pair = Pair::new(mode, method);
        let (mut t, mut saved, mut saved_at) = (0.0, [null_mut(); 2], None);
        for _ in 0..200 {
            match random.below(12) {
                0..2 => {
                    let input = random.below(inputs.len());
                    // The last three are the current.
                    let most = if input + 3 < inputs.len() { 1000.0 } else { 1.0 };
                    pair.set(inputs[input], random.value(most));
                }
                2..9 => {
                    let h = [0.01, 0.003, 0.025, 1e-9, 0.0, 0.1][random.below(6)];
                    pair.step(t, h);
                    t += h;
                }
                9 => {
                    for (c, state) in pair.0.iter().zip(&mut saved) {
                        let status = unsafe { fmi2::fmi2GetFMUstate(*c, state) };
                        assert_eq!(status, Status::Ok);
                    }
                    saved_at = Some(t);
                }
                10 => {
                    // Each continues from the other's state.
                    let Some(at) = saved_at else { continue };
                    for (c, state) in pair.0.iter().zip(saved.iter().rev()) {
                        assert_eq!(unsafe { fmi2::fmi2SetFMUstate(*c, *state) }, Status::Ok);
                    }
                    t = at;
                }
                _ if random.below(20) == 0 => {
                    pair.each(|c| unsafe { fmi2::fmi2Reset(c) });
                    pair.start(mode, method);
                    t = 0.0;
                }
                _ => {}
            }
            let [known, worked_out] = pair.bits(&seen);
            assert_eq!(known, worked_out, "run {run} at {t} s");
        }
    }
}
