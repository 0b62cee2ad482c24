//! Every function with arguments that a faulty importer may pass: NULL, absurd sizes, dead handles.

use std::ptr::{dangling, dangling_mut, null, null_mut, without_provenance_mut};

use fmu_kit::abi::types::*;
use fmu_kit::kernel::{Call, Interface, Status};

use crate::components::{command, fmi2};
use crate::driver::{CS, Fmu, ME};
use crate::legality::call;

/// Calls a function with NULL for each array and output, and `n` for each number of elements; none
/// if it takes neither.
fn call_with_null(c: fmi2Component, function: Call, n: usize) -> Option<Status> {
    let real = dangling_mut::<f64>();
    let done = unsafe {
        match function {
            Call::SetDebugLogging => fmi2::fmi2SetDebugLogging(c, 0, n, null()),
            Call::GetReal => fmi2::fmi2GetReal(c, null(), n, null_mut()),
            Call::GetInteger => fmi2::fmi2GetInteger(c, null(), n, null_mut()),
            Call::GetBoolean => fmi2::fmi2GetBoolean(c, null(), n, null_mut()),
            Call::GetString => fmi2::fmi2GetString(c, null(), n, null_mut()),
            Call::SetReal => fmi2::fmi2SetReal(c, null(), n, null()),
            Call::SetInteger => fmi2::fmi2SetInteger(c, null(), n, null()),
            Call::SetBoolean => fmi2::fmi2SetBoolean(c, null(), n, null()),
            Call::SetString => fmi2::fmi2SetString(c, null(), n, null()),
            Call::GetFmuState => fmi2::fmi2GetFMUstate(c, null_mut()),
            Call::SetFmuState => fmi2::fmi2SetFMUstate(c, null_mut()),
            Call::SerializedFmuStateSize => {
                fmi2::fmi2SerializedFMUstateSize(c, null_mut(), null_mut())
            }
            Call::SerializeFmuState => fmi2::fmi2SerializeFMUstate(c, null_mut(), null_mut(), n),
            Call::DeSerializeFmuState => fmi2::fmi2DeSerializeFMUstate(c, null(), n, null_mut()),
            Call::GetDirectionalDerivative => {
                fmi2::fmi2GetDirectionalDerivative(c, null(), n, null(), n, null(), null_mut())
            }
            Call::NewDiscreteStates => fmi2::fmi2NewDiscreteStates(c, null_mut()),
            Call::CompletedIntegratorStep => {
                fmi2::fmi2CompletedIntegratorStep(c, 1, null_mut(), null_mut())
            }
            Call::SetContinuousStates => fmi2::fmi2SetContinuousStates(c, null(), n),
            Call::GetDerivatives => fmi2::fmi2GetDerivatives(c, null_mut(), n),
            Call::GetEventIndicators => fmi2::fmi2GetEventIndicators(c, null_mut(), n),
            Call::GetContinuousStates => fmi2::fmi2GetContinuousStates(c, null_mut(), n),
            Call::GetNominals => fmi2::fmi2GetNominalsOfContinuousStates(c, null_mut(), n),
            Call::SetRealInputDerivatives => {
                fmi2::fmi2SetRealInputDerivatives(c, null(), n, null(), real)
            }
            Call::GetRealOutputDerivatives => {
                fmi2::fmi2GetRealOutputDerivatives(c, null(), n, null(), real)
            }
            Call::GetRealStatus => fmi2::fmi2GetRealStatus(c, 2, null_mut()),
            Call::GetBooleanStatus => fmi2::fmi2GetBooleanStatus(c, 3, null_mut()),
            _ => return None,
        }
    };
    Some(done)
}

/// An instance on which most functions of its interface are legal.
fn running(interface: fmi2Type, function: Call) -> Fmu {
    let fmu = Fmu::started("Pendulum", interface);
    let continuous = matches!(function, Call::SetContinuousStates | Call::CompletedIntegratorStep);
    if interface == ME && continuous {
        unsafe { fmi2::fmi2EnterContinuousTimeMode(fmu.c) };
    }
    fmu
}

const INTERFACES: [(fmi2Type, Interface); 2] =
    [(ME, Interface::ModelExchange), (CS, Interface::CoSimulation)];

#[test]
fn null_for_something_is_an_error_with_one_line_of_every_function() {
    let mut refused = 0;
    for (number, interface) in INTERFACES {
        for function in Call::ALL.iter().filter(|call| call.belongs_to(interface)) {
            for n in [1, 3, usize::MAX] {
                let mut fmu = running(number, *function);
                let Some(status) = call_with_null(fmu.c, *function, n) else {
                    continue;
                };
                let lines = fmu.log();
                assert_eq!(status, Status::Error, "{function:?}: {lines:?}");
                let [line] = &lines[..] else { panic!("{function:?}: {lines:?}") };
                let start = format!("{}: ", function.name());
                assert!(line.text.starts_with(&start), "{line:?}");
                assert!(line.text.contains("NULL") || line.text.contains("FMUstate"), "{line:?}");
                refused += 1;
            }
        }
    }
    assert!(refused > 100, "{refused}");
}

#[test]
fn absurd_sizes_are_refused_before_anything_is_read() {
    let mut fmu = Fmu::started("Spring", CS);
    let (vr, value) = (dangling::<u32>(), dangling_mut::<f64>());
    let (integer, c) = (dangling_mut::<i32>(), fmu.c);
    for n in [usize::MAX, usize::MAX - 7, usize::MAX / 8, 1 << 61, 1 << 32, 1 << 21] {
        unsafe {
            for status in [
                fmi2::fmi2GetReal(c, vr, n, value),
                fmi2::fmi2SetReal(c, vr, n, value),
                fmi2::fmi2GetInteger(c, vr, n, integer),
                fmi2::fmi2SetInteger(c, vr, n, integer),
                fmi2::fmi2GetBoolean(c, vr, n, integer),
                fmi2::fmi2SetBoolean(c, vr, n, integer),
                fmi2::fmi2GetString(c, vr, n, dangling_mut()),
                fmi2::fmi2SetString(c, vr, n, dangling()),
                fmi2::fmi2SetRealInputDerivatives(c, vr, n, integer, value),
                fmi2::fmi2GetRealOutputDerivatives(c, vr, n, integer, value),
                fmi2::fmi2SetDebugLogging(c, 1, n, dangling()),
                fmi2::fmi2DeSerializeFMUstate(c, dangling(), n, dangling_mut()),
            ] {
                assert_eq!(status, Status::Error);
            }
        }
        let lines = fmu.log();
        assert_eq!(lines.len(), 12);
        assert!(lines.iter().all(|line| line.text.contains(&n.to_string())), "{lines:?}");
    }
}

#[test]
fn every_function_refuses_handles_that_lead_nowhere() {
    let freed = Fmu::started("Spring", CS).free();
    let state = {
        let (fmu, mut state) = (Fmu::started("Spring", CS), null_mut());
        unsafe { fmi2::fmi2GetFMUstate(fmu.c, &raw mut state) };
        state
    };
    for bad in [0, 1, 8, 0xdead_beef_cafe, usize::MAX, freed.addr(), state.addr()] {
        let c = without_provenance_mut(bad);
        for function in Call::ALL.iter().filter(|function| **function != Call::FreeInstance) {
            assert_eq!(call(c, 2, *function), Status::Error, "{function:?} of {bad:#x}");
        }
        unsafe { fmi2::fmi2FreeInstance(c) };
        unsafe { fmi2::fmi2FreeInstance(c) };
    }
}

#[test]
fn the_same_reference_twice_gets_the_last_value_and_gives_it_twice() {
    let fmu = Fmu::started("Spring", CS);
    let references = [fmu.reference("force"); 2];
    let (values, mut got) = ([1.0, 2.0], [0.0; 2]);
    unsafe {
        let vr = references.as_ptr();
        assert_eq!(fmi2::fmi2SetReal(fmu.c, vr, 2, values.as_ptr()), Status::Ok);
        assert_eq!(fmi2::fmi2GetReal(fmu.c, vr, 2, got.as_mut_ptr()), Status::Ok);
    }
    assert_eq!(got, [2.0, 2.0]);
}

#[test]
fn a_null_text_is_told_with_its_variable() {
    let mut fmu = Fmu::new("Spring", CS);
    let (label, text) = (fmu.reference("label"), null());
    let status = unsafe { fmi2::fmi2SetString(fmu.c, &raw const label, 1, &raw const text) };
    assert_eq!(status, Status::Error);
    assert_eq!(fmu.line(), "fmi2SetString: label: the text is NULL");
    let status = unsafe { fmi2::fmi2SetDebugLogging(fmu.c, 1, 1, &raw const text) };
    assert_eq!(status, Status::Error);
    assert!(fmu.line().contains("unknown log category \"NULL\""));
}

#[test]
fn a_panic_of_many_lines_is_one_line() {
    let mut fmu = Fmu::started("Clumsy", CS);
    fmu.set("command", command::PANIC_AT_LENGTH);
    assert_eq!(fmu.step(0.0, 0.2), Status::Fatal);
    let line = fmu.line();
    assert!(line.contains("panicked: assertion") && !line.contains(char::is_control), "{line}");
}
