//! Implausible steps and times: every component returns from them.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

mod host;

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;
use rexrov_fmu::{REGISTRY, fmi2};

fn started(name: &str, interface: fmi2Type) -> fmi2Component {
    let c = host::instantiate(name, interface);
    unsafe {
        assert_eq!(fmi2::fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2::fmi2ExitInitializationMode(c), Status::Ok);
    }
    c
}

#[test]
fn every_component_comes_back_from_every_step() {
    for entry in REGISTRY.entries() {
        let name = entry.info().name;
        for (t, h) in [(f64::NEG_INFINITY, 1e18), (0.0, 1e18), (0.0, f64::INFINITY), (1e300, 1.0)] {
            let c = started(name, 1);
            assert_eq!(unsafe { fmi2::fmi2DoStep(c, t, h, 1) }, Status::Error, "{name} {t} {h}");
            unsafe { fmi2::fmi2FreeInstance(c) };
        }
        let c = started(name, 1);
        let long = unsafe { fmi2::fmi2DoStep(c, 0.0, 8e9, 1) };
        assert_eq!(long, Status::Discard, "{name}");
        unsafe { fmi2::fmi2FreeInstance(c) };
    }
}

#[test]
fn every_component_comes_back_from_every_time_in_model_exchange() {
    for entry in REGISTRY.entries().filter(|entry| entry.info().model_exchange) {
        let name = entry.info().name;
        for time in [8e9, 1e12, 1e300] {
            let c = started(name, 0);
            let mut info = fmi2EventInfo::default();
            unsafe {
                let set = fmi2::fmi2SetTime(c, time);
                assert_eq!(set, if time < 9e9 { Status::Ok } else { Status::Error }, "{name}");
                for _ in 0..5 {
                    fmi2::fmi2NewDiscreteStates(c, &raw mut info);
                }
                fmi2::fmi2FreeInstance(c);
            }
        }
    }
}
