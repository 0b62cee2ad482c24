//! The vehicle's directional derivatives against central differences, through the C interface: each
//! state and input against each derivative and output.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

use std::ffi::CString;
use std::ptr::null;

use fmu_kit::abi::types::*;
use fmu_kit::kernel::{Group, Status};
use rexrov_fmu::{REGISTRY, fmi2};

fn ok(status: Status) {
    assert_eq!(status, Status::Ok);
}

/// An instance in continuous-time mode.
fn started() -> fmi2Component {
    let guid = CString::new(REGISTRY.named("RexROV").unwrap().guid()).unwrap();
    let functions = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: std::ptr::null_mut(),
    };
    unsafe {
        let f = &raw const functions;
        let c = fmi2::fmi2Instantiate(c"test".as_ptr(), 0, guid.as_ptr(), null(), f, 0, 0);
        ok(fmi2::fmi2EnterInitializationMode(c));
        ok(fmi2::fmi2ExitInitializationMode(c));
        ok(fmi2::fmi2EnterContinuousTimeMode(c));
        c
    }
}

#[test]
fn every_column_of_the_jacobian_is_that_of_the_functions() {
    let (c, table) = (started(), REGISTRY.named("RexROV").unwrap().table());
    let group = |group| table.group(group).map(|(_, v)| v.reference).collect::<Vec<u32>>();
    let (states, inputs) = (group(Group::State), group(Group::Input));
    let unknowns = [group(Group::Derivative), group(Group::Output)].concat();
    // Somewhere without symmetries, off every limit and off zero.
    let x: Vec<f64> = (0..states.len())
        .map(|i| match i {
            3 => 0.9,
            4..7 => 0.1 * i as f64 - 0.4,
            7..13 => 0.3 * (i as f64 - 9.4),
            13.. => 60.0 + 7.0 * i as f64,
            _ => i as f64,
        })
        .collect();
    let u: Vec<f64> = (0..inputs.len()).map(|i| 40.0 + 9.0 * i as f64).collect();
    let evaluate = |x: &[f64], u: &[f64]| unsafe {
        let mut y = vec![0.0; unknowns.len()];
        ok(fmi2::fmi2SetContinuousStates(c, x.as_ptr(), x.len()));
        ok(fmi2::fmi2SetReal(c, inputs.as_ptr(), u.len(), u.as_ptr()));
        ok(fmi2::fmi2GetReal(c, unknowns.as_ptr(), y.len(), y.as_mut_ptr()));
        y
    };
    for (index, known) in states.iter().chain(&inputs).enumerate() {
        let point = x.iter().chain(&u).nth(index).unwrap();
        let h = 1e-6 * point.abs().max(1.0);
        let moved = |by: f64| {
            let (mut x, mut u) = (x.clone(), u.clone());
            *x.iter_mut().chain(&mut u).nth(index).unwrap() += by;
            evaluate(&x, &u)
        };
        let (ahead, behind) = (moved(h), moved(-h));
        let here = evaluate(&x, &u);
        let (one, mut column) = (1.0, vec![0.0; unknowns.len()]);
        ok(unsafe {
            let (z, v, n) = (unknowns.as_ptr(), known, unknowns.len());
            fmi2::fmi2GetDirectionalDerivative(c, z, n, v, 1, &raw const one, column.as_mut_ptr())
        });
        for (k, analytic) in column.iter().enumerate() {
            let difference = (ahead[k] - behind[k]) / (2.0 * h);
            let scale = 1.0 + analytic.abs() + 1e-3 * here[k].abs();
            assert!(
                (analytic - difference).abs() < 1e-6 * scale,
                "unknown {k} along {known}: {analytic} {difference}"
            );
        }
    }
}
