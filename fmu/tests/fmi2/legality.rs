//! Every function in every state: calls that the table allows are done, all others are an error
//! with one line and without effect.

use fmu_kit::abi::types::*;
use fmu_kit::kernel::{Call, Interface, Phase, Status, accepts};

use crate::components::{command, fmi2};
use crate::driver::{CS, Fmu, ME};

/// An instance in a state; none if its interface has no such state.
fn in_phase(interface: fmi2Type, phase: Phase) -> Option<Fmu> {
    let me = interface == ME;
    let mut fmu = match phase {
        Phase::Event | Phase::Continuous if !me => return None,
        Phase::Step | Phase::Failed if me => return None,
        Phase::Instantiated | Phase::Initialization => Fmu::new("Spring", interface),
        Phase::Error | Phase::Fatal | Phase::Failed => Fmu::started("Clumsy", interface),
        _ => Fmu::started("Spring", interface),
    };
    let mut fail = |command: f64| {
        fmu.set("command", command);
        if me {
            let mut info = fmi2EventInfo::default();
            unsafe {
                fmi2::fmi2SetTime(fmu.c, 1.0);
                fmi2::fmi2NewDiscreteStates(fmu.c, &raw mut info);
            }
        } else {
            fmu.step(0.0, 1.0);
        }
    };
    unsafe {
        match phase {
            Phase::Error => fail(command::FAULT),
            Phase::Fatal => fail(command::PANIC),
            Phase::Failed => fail(command::NOT_FINITE),
            Phase::Initialization => _ = fmu.enter(),
            Phase::Continuous => _ = fmi2::fmi2EnterContinuousTimeMode(fmu.c),
            Phase::Terminated => _ = fmi2::fmi2Terminate(fmu.c),
            _ => {}
        }
    }
    fmu.log();
    Some(fmu)
}

/// Calls a function with harmless arguments; `nx` is the number of states.
pub fn call(c: fmi2Component, nx: usize, function: Call) -> Status {
    use std::ptr::{null, null_mut};
    let (mut info, mut a, mut b) = (fmi2EventInfo::default(), 0, 0);
    let (mut state, mut size) = (null_mut(), 0);
    let mut real = [0.0; 2];
    unsafe {
        match function {
            Call::SetDebugLogging => fmi2::fmi2SetDebugLogging(c, 0, 0, null()),
            Call::FreeInstance => Status::Ok,
            Call::SetupExperiment => fmi2::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            Call::EnterInitializationMode => fmi2::fmi2EnterInitializationMode(c),
            Call::ExitInitializationMode => fmi2::fmi2ExitInitializationMode(c),
            Call::Terminate => fmi2::fmi2Terminate(c),
            Call::Reset => fmi2::fmi2Reset(c),
            Call::GetReal => fmi2::fmi2GetReal(c, null(), 0, null_mut()),
            Call::GetInteger => fmi2::fmi2GetInteger(c, null(), 0, null_mut()),
            Call::GetBoolean => fmi2::fmi2GetBoolean(c, null(), 0, null_mut()),
            Call::GetString => fmi2::fmi2GetString(c, null(), 0, null_mut()),
            Call::SetReal => fmi2::fmi2SetReal(c, null(), 0, null()),
            Call::SetInteger => fmi2::fmi2SetInteger(c, null(), 0, null()),
            Call::SetBoolean => fmi2::fmi2SetBoolean(c, null(), 0, null()),
            Call::SetString => fmi2::fmi2SetString(c, null(), 0, null()),
            Call::GetFmuState => fmi2::fmi2GetFMUstate(c, &raw mut state),
            Call::SetFmuState => fmi2::fmi2SetFMUstate(c, null_mut()),
            Call::FreeFmuState => fmi2::fmi2FreeFMUstate(c, null_mut()),
            Call::SerializedFmuStateSize => {
                fmi2::fmi2SerializedFMUstateSize(c, null_mut(), &raw mut size)
            }
            Call::SerializeFmuState => fmi2::fmi2SerializeFMUstate(c, null_mut(), null_mut(), 0),
            Call::DeSerializeFmuState => {
                fmi2::fmi2DeSerializeFMUstate(c, null(), 0, &raw mut state)
            }
            Call::GetDirectionalDerivative => {
                fmi2::fmi2GetDirectionalDerivative(c, null(), 0, null(), 0, null(), null_mut())
            }
            Call::EnterEventMode => fmi2::fmi2EnterEventMode(c),
            Call::NewDiscreteStates => fmi2::fmi2NewDiscreteStates(c, &raw mut info),
            Call::EnterContinuousTimeMode => fmi2::fmi2EnterContinuousTimeMode(c),
            Call::CompletedIntegratorStep => {
                fmi2::fmi2CompletedIntegratorStep(c, 1, &raw mut a, &raw mut b)
            }
            Call::SetTime => fmi2::fmi2SetTime(c, 0.0),
            Call::SetContinuousStates => fmi2::fmi2SetContinuousStates(c, real.as_ptr(), nx),
            Call::GetDerivatives => fmi2::fmi2GetDerivatives(c, real.as_mut_ptr(), nx),
            Call::GetEventIndicators => fmi2::fmi2GetEventIndicators(c, null_mut(), 0),
            Call::GetContinuousStates => fmi2::fmi2GetContinuousStates(c, real.as_mut_ptr(), nx),
            Call::GetNominals => fmi2::fmi2GetNominalsOfContinuousStates(c, real.as_mut_ptr(), nx),
            Call::SetRealInputDerivatives => {
                fmi2::fmi2SetRealInputDerivatives(c, null(), 0, null(), null())
            }
            Call::GetRealOutputDerivatives => {
                fmi2::fmi2GetRealOutputDerivatives(c, null(), 0, null(), null_mut())
            }
            Call::DoStep => fmi2::fmi2DoStep(c, 0.0, 0.1, 1),
            Call::CancelStep => fmi2::fmi2CancelStep(c),
            Call::GetStatus => fmi2::fmi2GetStatus(c, 0, null_mut()),
            Call::GetRealStatus => fmi2::fmi2GetRealStatus(c, 2, real.as_mut_ptr()),
            Call::GetIntegerStatus => fmi2::fmi2GetIntegerStatus(c, 0, null_mut()),
            Call::GetBooleanStatus => fmi2::fmi2GetBooleanStatus(c, 3, &raw mut a),
            Call::GetStringStatus => fmi2::fmi2GetStringStatus(c, 0, null_mut()),
        }
    }
}

/// The result of a function where it is legal, called as in [`call`].
fn when_legal(function: Call) -> Status {
    match function {
        // There is no state yet to set, measure or write; no bytes are not a state.
        Call::SetFmuState
        | Call::SerializedFmuStateSize
        | Call::SerializeFmuState
        | Call::DeSerializeFmuState => Status::Error,
        // There is never anything to report.
        Call::GetStatus | Call::GetIntegerStatus | Call::GetStringStatus => Status::Discard,
        // These components have no tangent.
        Call::GetDirectionalDerivative => Status::Error,
        _ => Status::Ok,
    }
}

#[test]
fn every_function_in_every_state_of_both_interfaces_does_as_the_table_says() {
    let mut walked = 0;
    for (number, interface) in [(ME, Interface::ModelExchange), (CS, Interface::CoSimulation)] {
        for (phase, function) in
            Phase::ALL.iter().flat_map(|p| Call::ALL.iter().map(move |f| (p, f)))
        {
            let Some(mut fmu) = in_phase(number, *phase) else {
                continue;
            };
            let legal = accepts(*phase, *function) && function.belongs_to(interface);
            let expected = match legal {
                true => when_legal(*function),
                false if *phase == Phase::Fatal => Status::Fatal,
                false => Status::Error,
            };
            let nx = if fmu.name == "Spring" { 2 } else { 0 };
            let status = call(fmu.c, nx, *function);
            let lines = fmu.log();
            let what = format!("{} {interface:?} {phase:?}: {lines:?}", function.name());
            assert_eq!(status, expected, "{what}");
            assert_eq!(lines.len(), usize::from(expected != Status::Ok), "{what}");
            if let Some(line) = lines.first() {
                assert!(line.text.starts_with(function.name()), "{what}");
                assert_eq!(line.status, status, "{what}");
                assert_eq!(line.text.contains("not allowed"), !legal, "{what}");
            }
            walked += 1;
        }
    }
    assert_eq!(walked, 14 * Call::ALL.len());
}

#[test]
fn two_rows_are_wider_than_the_standards() {
    for (phase, call) in Phase::ALL.iter().flat_map(|p| Call::ALL.iter().map(move |c| (*p, *c))) {
        let getter = [Call::GetReal, Call::GetInteger, Call::GetBoolean, Call::GetString];
        let wider = (phase == Phase::Instantiated && getter.contains(&call))
            || (phase == Phase::Event && call == Call::EnterEventMode);
        assert_eq!(accepts(phase, call) && !phase.allows(call), wider, "{call:?} {phase:?}");
        assert!(accepts(phase, call) || !phase.allows(call), "{call:?} {phase:?}");
    }
}

#[test]
fn only_inputs_can_be_set_once_the_simulation_runs() {
    let mut fmu = Fmu::started("Spring", CS);
    assert_eq!(fmu.set("force", 1.0), Status::Ok);
    for (name, why) in [
        ("mass", "fixed"),
        ("position", "calculated"),
        ("state.x", "calculated"),
        ("der(state.x)", "calculated"),
        ("time", "independent"),
    ] {
        assert_eq!(fmu.set(name, 2.0), Status::Error);
        let line = fmu.line();
        assert!(line.contains(name) && line.contains(why), "{line}");
    }
    assert_eq!(fmu.set_integer("sign", -1), Status::Error);
    assert!(fmu.line().contains("sign cannot be set"));
    assert_eq!(fmu.set_string("label", c"x"), Status::Error);
    assert_eq!(fmu.get("mass"), 1.0);
}
