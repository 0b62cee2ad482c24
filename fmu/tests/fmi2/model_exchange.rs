//! Model exchange: an importer's solver must get the same motion as the kit's own stepper.

use fmu_kit::abi::types::fmi2EventInfo;
use fmu_kit::kernel::Status;

use crate::components::fmi2;
use crate::driver::{CS, Fmu, ME};

fn derivatives(fmu: &Fmu, t: f64, x: [f64; 2]) -> [f64; 2] {
    let mut k = [f64::NAN; 2];
    unsafe {
        assert_eq!(fmi2::fmi2SetTime(fmu.c, t), Status::Ok);
        assert_eq!(fmi2::fmi2SetContinuousStates(fmu.c, x.as_ptr(), 2), Status::Ok);
        assert_eq!(fmi2::fmi2GetDerivatives(fmu.c, k.as_mut_ptr(), 2), Status::Ok);
    }
    k
}

fn started(name: &'static str) -> (Fmu, fmi2EventInfo) {
    let fmu = Fmu::started(name, ME);
    let mut info = fmi2EventInfo { newDiscreteStatesNeeded: 9, ..Default::default() };
    unsafe {
        assert_eq!(fmi2::fmi2NewDiscreteStates(fmu.c, &raw mut info), Status::Ok);
        assert_eq!(fmi2::fmi2EnterContinuousTimeMode(fmu.c), Status::Ok);
    }
    assert_eq!((info.newDiscreteStatesNeeded, info.terminateSimulation), (0, 0));
    (fmu, info)
}

#[test]
fn the_same_method_outside_gives_the_same_bits_as_inside() {
    let (me, _) = started("Spring");
    let mut cs = Fmu::started("Spring", CS);
    let (mut x, h) = ([1.0, 0.0], 0.001);
    for k in 0..200 {
        let t = f64::from(k) * h;
        let ahead = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
        let k1 = derivatives(&me, t, x);
        let k2 = derivatives(&me, t + 0.5 * h, ahead(k1, 0.5 * h));
        let k3 = derivatives(&me, t + 0.5 * h, ahead(k2, 0.5 * h));
        let k4 = derivatives(&me, t + h, ahead(k3, h));
        for i in 0..2 {
            x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
        assert_eq!(cs.step(t, h), Status::Ok);
        assert_eq!([cs.get("state.x"), cs.get("state.v")], x);
    }
}

#[test]
fn states_are_given_back_and_outputs_follow_them() {
    let (mut fmu, info) = started("Spring");
    assert_eq!(info.nextEventTimeDefined, 0);
    let (mut x, mut nominal) = ([0.0; 2], [0.0; 2]);
    unsafe {
        fmi2::fmi2SetContinuousStates(fmu.c, [0.5, 2.0].as_ptr(), 2);
        fmi2::fmi2GetContinuousStates(fmu.c, x.as_mut_ptr(), 2);
        fmi2::fmi2GetNominalsOfContinuousStates(fmu.c, nominal.as_mut_ptr(), 2);
    }
    assert_eq!((x, nominal), ([0.5, 2.0], [1.0, 2.0]));
    fmu.set("force", 3.0);
    assert_eq!((fmu.get("position"), fmu.get("acceleration")), (0.5, 1.0));
}

#[test]
fn time_events_happen_when_announced_and_once() {
    let (mut me, info) = started("Noise");
    let mut cs = Fmu::started("Noise", CS);
    let mut next = info.nextEventTime;
    for k in 0..20 {
        let instant = ((f64::from(k) + 1.0) * 1e9 / 7.0).round() / 1e9;
        assert_eq!(next, instant);
        let mut info = fmi2EventInfo::default();
        let (mut enter, mut end) = (9, 9);
        unsafe {
            assert_eq!(fmi2::fmi2SetTime(me.c, next), Status::Ok);
            let c = me.c;
            fmi2::fmi2CompletedIntegratorStep(c, 1, &raw mut enter, &raw mut end);
            assert_eq!((enter, end), (0, 0));
            assert_eq!(fmi2::fmi2EnterEventMode(me.c), Status::Ok);
            assert_eq!(fmi2::fmi2NewDiscreteStates(me.c, &raw mut info), Status::Ok);
            assert_eq!(fmi2::fmi2NewDiscreteStates(me.c, &raw mut info), Status::Ok);
            assert_eq!(fmi2::fmi2EnterContinuousTimeMode(me.c), Status::Ok);
        }
        let t = cs.get("time");
        assert_eq!(cs.step(t, next - t), Status::Ok);
        assert_eq!(me.get("count"), f64::from(k) + 2.0);
        for name in ["value", "count", "stamp"] {
            assert_eq!(me.get(name), cs.get(name), "{name}");
        }
        assert!(info.nextEventTime > next && info.nextEventTimeDefined == 1);
        next = info.nextEventTime;
    }
}

#[test]
fn what_is_not_finite_is_discarded_so_that_the_solver_can_try_again() {
    let (mut fmu, _) = started("Spring");
    let status = unsafe { fmi2::fmi2SetContinuousStates(fmu.c, [0.0, f64::NAN].as_ptr(), 2) };
    assert_eq!(status, Status::Discard);
    assert!(fmu.line().contains("state.v = NaN"));
    assert_eq!(fmu.set("force", f64::INFINITY), Status::Discard);
    assert!(fmu.line().contains("force = inf"));
    assert_eq!(fmu.get("force"), 0.0);
}

#[test]
fn wrong_numbers_of_states_are_refused() {
    let (mut fmu, _) = started("Spring");
    let mut x = [0.0; 3];
    unsafe {
        assert_eq!(fmi2::fmi2GetDerivatives(fmu.c, x.as_mut_ptr(), 3), Status::Error);
        assert_eq!(fmi2::fmi2GetEventIndicators(fmu.c, x.as_mut_ptr(), 1), Status::Error);
        assert_eq!(fmi2::fmi2GetEventIndicators(fmu.c, std::ptr::null_mut(), 0), Status::Ok);
    }
    assert_eq!(fmu.log().len(), 2);
}

#[test]
fn an_interface_that_is_not_offered_is_refused() {
    let lines = Fmu::with("Solitary", ME, 0, None).err().unwrap();
    assert!(lines[0].text.contains("co-simulation only"), "{lines:?}");
}
