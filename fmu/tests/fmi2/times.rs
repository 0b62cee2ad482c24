//! Implausible times and steps: every call returns, and reports what was wrong.

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;

use crate::components::fmi2;
use crate::driver::{CS, Fmu, ME};

const STRANGE: [f64; 9] =
    [f64::NEG_INFINITY, f64::INFINITY, f64::NAN, -1e300, 1e300, 1e18, -1e18, 1e10, f64::MAX];

#[test]
fn a_step_begins_and_ends_at_times_that_can_be() {
    let mut fmu = Fmu::started("Spring", CS);
    for strange in STRANGE {
        for (t, h) in [(strange, 0.1), (0.0, strange), (strange, strange), (strange, 0.0)] {
            assert_eq!(fmu.step(t, h), Status::Error, "{t} {h}");
            let line = fmu.line();
            assert!(
                line.contains("currentCommunicationPoint") || line.contains("StepSize"),
                "{line}"
            );
            assert_eq!(fmu.get("time"), 0.0, "{t} {h}");
        }
    }
    assert_eq!(fmu.step(0.0, 0.1), Status::Ok);
}

#[test]
fn a_step_that_is_too_much_work_is_discarded_where_it_got_to() {
    for name in ["Spring", "Noise"] {
        let mut fmu = Fmu::started(name, CS);
        assert_eq!(fmu.step(0.0, 8e9), Status::Discard, "{name}");
        let line = fmu.line();
        assert!(line.contains("1000000") && line.contains("shorter communication steps"), "{line}");
        let reached = fmu.get("time");
        assert!((0.0..8e9).contains(&reached), "{name} {reached}");
    }
    let mut adaptive = Fmu::new("Pendulum", CS);
    adaptive.set_integer("integrator.method", 2);
    assert_eq!((adaptive.setup(0.0), adaptive.initialize()), (Status::Ok, Status::Ok));
    assert_eq!(adaptive.step(0.0, 8e9), Status::Discard);
}

#[test]
fn in_model_exchange_time_is_bounded_and_so_are_the_events_of_one_call() {
    let mut fmu = Fmu::started("Noise", ME);
    let set = |fmu: &Fmu, time| unsafe { fmi2::fmi2SetTime(fmu.c, time) };
    for strange in STRANGE {
        assert_eq!(set(&fmu, strange), Status::Error, "{strange}");
        assert!(fmu.line().contains("time = "));
    }
    assert_eq!(set(&fmu, 8e9), Status::Ok);
    let mut info = fmi2EventInfo::default();
    assert_eq!(unsafe { fmi2::fmi2NewDiscreteStates(fmu.c, &raw mut info) }, Status::Error);
    let line = fmu.line();
    assert!(line.contains("1000000 time events") && line.contains("nextEventTime"), "{line}");
}
