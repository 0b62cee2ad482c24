//! A cycle of a filter does not allocate.
#![allow(unsafe_code, reason = "counts what is allocated")]

#[path = "mission/mod.rs"]
mod mission;
#[path = "scoring/mod.rs"]
mod scoring;

use mission::{Kind, Options, delay, fly, jitter};
use rexrov::estimation::*;
use rexrov::guidance::Course;
use rexrov::vehicle::Parameters;
use scoring::set;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

std::thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: everything is forwarded to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of a mission after the construction of the memory.
fn allocations(filter: &impl Navigation) -> usize {
    let options = Options {
        duration_s: 20.0,
        lost_thruster: Some((4, 5.0)),
        ..Options::nominal(Course::BE3, 1)
    };
    let mut mission = fly(&options);
    delay(&mut mission.events, Kind::Fix, 2.0);
    jitter(&mut mission.events, Kind::Dvl, 2.0, 1);
    let (mut memory, mut measured) = (filter.memory(), Measurements::default());
    let before = COUNT.get();
    for event in &mission.events {
        set(&mut measured, event);
        filter.update(&mut memory, event.arrival, &measured);
    }
    // More at one instant than the capacity, and a long silence.
    for k in 0..3000 {
        measured.imu =
            Reading::at(20.0 + 1e-4 * f64::from(k), [0.0, 0.0, -9.81, 0.0, 0.0, f64::from(k)]);
        filter.update(&mut memory, 30.0, &measured);
    }
    filter.update(&mut memory, 1000.0, &measured);
    COUNT.get() - before
}

#[test]
fn a_cycle_does_not_allocate() {
    let p = NavigationParameters::default();
    let (vehicle, d) = (Parameters::default(), Disturbances::default());
    let planar = PlanarDynamic::new(&p, &vehicle, &d).unwrap();
    let inertial = InertialProcess::new(&p, None).unwrap();
    let constant = ConstantAcceleration::new(&p).unwrap();
    let counts = [
        allocations(&ConstantAccelerationFilter::new(constant, &p).unwrap()),
        allocations(&DynamicFilter::new(planar, &p).unwrap()),
        allocations(&InertialFilter::new(inertial, &p).unwrap()),
        allocations(&AidedFilter::new(&p, &vehicle, &ModelErrors::default()).unwrap()),
    ];
    assert_eq!(counts, [0; 4]);
}
