//! All navigation filters through the C interface: the same inputs, any of them absent, late or
//! invalid.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]
#![allow(unreachable_pub, reason = "shared with the tests of the kit")]

mod components {
    pub use rexrov_fmu::{REGISTRY, fmi2};
}
#[expect(dead_code, reason = "shared with the tests of the kit")]
#[path = "../../tests/fmi2/driver.rs"]
mod driver;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ptr::null_mut;

use driver::{CS, Fmu, ME};
use fmu_kit::abi::types::fmi2EventInfo;
use fmu_kit::kernel::{Group, Status};
use rexrov_fmu::{REGISTRY, fmi2};

const FILTERS: [&str; 6] = [
    "EkfDynamic",
    "EkfKinematic",
    "NavConstantAcceleration",
    "NavDynamic",
    "NavInertial",
    "NavModelAided",
];
const CHANNELS: [&str; 5] = ["tilt", "heading", "depth", "dvl", "fix"];

struct Counting;

thread_local! {
    /// For this thread, because the test harness has its own.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: forwards everything to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Steps of 10 ms.
struct Run {
    fmu: Fmu,
    tick: u32,
}

impl Run {
    fn new(name: &'static str) -> Self {
        Self { fmu: Fmu::started(name, CS), tick: 0 }
    }

    fn now(&self) -> f64 {
        f64::from(self.tick) * 0.01
    }

    fn step(&mut self) {
        assert_eq!(self.fmu.step(self.now(), 0.01), Status::Ok);
        self.tick += 1;
    }

    fn set(&mut self, values: &[(&str, f64)]) {
        for (name, value) in values {
            assert_eq!(self.fmu.set(name, *value), Status::Ok, "{name}");
        }
    }

    /// Sensor readings of a vehicle that drifts north at 0.3 m/s, 20 m deep, with a little noise so
    /// that no value repeats: inertial unit and thrust at 50 Hz, attitude at 10 Hz, fix and log
    /// late.
    fn sense(&mut self) {
        let t = self.now();
        let noise = |k: f64| 1e-3 * (k * t).sin();
        if self.tick.is_multiple_of(2) {
            self.set(&[
                ("imu.specific_force.x", noise(91.0)),
                ("imu.specific_force.z", -9.81 + noise(57.0)),
                ("imu.rate.r", noise(83.0)),
                ("imu.stamp", t),
                ("imu.valid", 1.0),
                ("propulsion.stamp", t),
                ("propulsion.valid", 1.0),
            ]);
        }
        if self.tick.is_multiple_of(10) {
            self.set(&[
                ("ahrs.attitude.yaw", noise(31.0)),
                ("ahrs.stamp", t),
                ("ahrs.valid", 1.0),
                ("pressure.depth", 19.15 + noise(29.0)),
                ("pressure.stamp", t),
                ("pressure.valid", 1.0),
            ]);
        }
        if self.tick.is_multiple_of(14) && t > 0.3 {
            let velocity = 0.3 + noise(23.0);
            self.set(&[("dvl.velocity.u", velocity), ("dvl.stamp", t - 0.15), ("dvl.valid", 1.0)]);
        }
        if self.tick.is_multiple_of(100) && t > 1.0 {
            let north = 0.3 * (t - 0.5) + 100.0 * noise(13.0);
            self.set(&[("fix.position.x", north), ("fix.stamp", t - 0.5), ("fix.valid", 1.0)]);
        }
    }

    fn travel(&mut self, seconds: f64) {
        let end = self.now() + seconds;
        while self.now() < end - 1e-9 {
            self.sense();
            self.step();
        }
    }

    fn outputs(&mut self) -> Vec<u64> {
        let table = REGISTRY.named(self.fmu.name).unwrap().table();
        let references: Vec<u32> = table.group(Group::Output).map(|(_, v)| v.reference).collect();
        let mut values = vec![0.0; references.len()];
        let (vr, n) = (references.as_ptr(), references.len());
        assert_eq!(
            unsafe { fmi2::fmi2GetReal(self.fmu.c, vr, n, values.as_mut_ptr()) },
            Status::Ok
        );
        values.into_iter().map(f64::to_bits).collect()
    }
}

#[test]
fn all_filters_have_the_same_ports() {
    let ports = |name: &str| {
        let table = REGISTRY.named(name).unwrap().table();
        let of = |group| table.group(group).map(|(_, v)| v.name.clone()).collect::<Vec<_>>();
        [of(Group::Input), of(Group::Output)]
    };
    for name in FILTERS {
        assert_eq!(ports(name), ports(FILTERS[0]), "{name}");
    }
}

#[test]
fn an_input_left_alone_is_never_fused() {
    for name in FILTERS {
        let mut run = Run::new(name);
        // Some importers set every input to zero.
        for input in REGISTRY.named(name).unwrap().table().group(Group::Input) {
            run.set(&[(&input.1.name, 0.0)]);
        }
        for _ in 0..1100 {
            run.step();
        }
        for channel in CHANNELS {
            for count in ["used", "rejected", "late"] {
                let count = run.fmu.get(&format!("count.{channel}.{count}"));
                assert_eq!(count, 0.0, "{name} {channel}");
            }
        }
        assert_eq!(run.fmu.get("pose.x"), 0.0, "{name}");
        assert_eq!(run.fmu.get("health"), 1.0, "{name}: nothing bounds the position");
    }
}

#[test]
fn every_filter_follows_the_vehicle_and_its_uncertainty_shrinks() {
    for name in FILTERS {
        let mut run = Run::new(name);
        run.travel(60.0);
        let (x, u) = (run.fmu.get("pose.x"), run.fmu.get("velocity.u"));
        assert!((x - 18.0).abs() < 0.3, "{name}: {x}");
        assert!((u - 0.3).abs() < 0.02, "{name}: {u}");
        let sigma = run.fmu.get("sigma.x");
        assert!((1e-3..0.5).contains(&sigma), "{name}: {sigma}");
        assert!(run.fmu.get("count.fix.used") >= 57.0, "{name}");
        assert_eq!(run.fmu.get("health"), 0.0, "{name}");
    }
}

#[test]
fn a_change_of_health_is_logged_with_its_reason() {
    for name in FILTERS {
        let mut run = Run::new(name);
        run.travel(15.0);
        run.fmu.log();
        // Silence.
        for _ in 0..1500 {
            run.step();
        }
        let line = run.fmu.line();
        assert!(line.contains("health: starved: neither velocity log nor fix"), "{name}: {line}");
        run.travel(3.0);
        let line = run.fmu.line();
        assert!(line.contains("s: health: good again"), "{name}: {line}");
    }
}

#[test]
fn what_is_not_a_number_is_counted_and_the_filter_continues() {
    for name in FILTERS {
        let mut run = Run::new(name);
        run.travel(10.0);
        let before = run.fmu.get("count.dvl.rejected");
        for bad in [f64::NAN, f64::INFINITY] {
            run.travel(0.5);
            let stamp = run.now();
            run.set(&[("dvl.velocity.v", bad), ("dvl.stamp", stamp)]);
            (0..10).for_each(|_| run.step());
            run.set(&[("dvl.velocity.v", 0.0)]);
        }
        assert_eq!(run.fmu.get("count.dvl.rejected"), before + 2.0, "{name}");
        run.travel(5.0);
        assert!(run.outputs().into_iter().all(|bits| f64::from_bits(bits).is_finite()), "{name}");
    }
}

#[test]
fn a_cycle_does_not_allocate() {
    for name in FILTERS {
        let mut run = Run::new(name);
        run.travel(8.0);
        let end = run.now() + 8.0;
        while run.now() < end {
            // Setting by name allocates.
            run.sense();
            let before = ALLOCATIONS.get();
            run.step();
            assert_eq!(ALLOCATIONS.get(), before, "{name} at {} s", run.now());
        }
        if name.starts_with("Nav") {
            assert!(run.fmu.get("count.fix.late") > 5.0, "{name} went back in time");
        }
    }
}

#[test]
fn a_run_goes_on_from_its_serialized_state_with_the_same_bits() {
    for name in FILTERS {
        let mut run = Run::new(name);
        run.travel(6.0);
        let tick = run.tick;
        let (c, mut state, mut size) = (run.fmu.c, null_mut(), 0);
        let mut bytes = Vec::new();
        unsafe {
            assert_eq!(fmi2::fmi2GetFMUstate(c, &raw mut state), Status::Ok);
            assert_eq!(fmi2::fmi2SerializedFMUstateSize(c, state, &raw mut size), Status::Ok);
            bytes.resize(size, 0);
            let place = bytes.as_mut_ptr().cast();
            assert_eq!(fmi2::fmi2SerializeFMUstate(c, state, place, size), Status::Ok);
        }
        run.travel(6.0);
        let expected = run.outputs();

        let mut other = Run { fmu: Fmu::started(name, CS), tick };
        let (c, mut state) = (other.fmu.c, null_mut());
        unsafe {
            let place = bytes.as_ptr().cast();
            assert_eq!(
                fmi2::fmi2DeSerializeFMUstate(c, place, size, &raw mut state),
                Status::Ok,
                "{name}"
            );
            assert_eq!(fmi2::fmi2SetFMUstate(c, state), Status::Ok, "{name}");
        }
        other.travel(6.0);
        assert!(other.outputs() == expected, "{name}");
    }
}

#[test]
fn in_model_exchange_the_same_cycles_run() {
    for name in FILTERS {
        let mut stepped = Run::new(name);
        stepped.travel(3.0);
        let mut run = Run { fmu: Fmu::started(name, ME), tick: 0 };
        let (c, mut info) = (run.fmu.c, fmi2EventInfo::default());
        while run.tick < stepped.tick {
            run.sense();
            run.tick += 1;
            unsafe {
                assert_eq!(fmi2::fmi2EnterContinuousTimeMode(c), Status::Ok);
                assert_eq!(fmi2::fmi2SetTime(c, run.now()), Status::Ok);
                assert_eq!(fmi2::fmi2EnterEventMode(c), Status::Ok);
                assert_eq!(fmi2::fmi2NewDiscreteStates(c, &raw mut info), Status::Ok);
            }
        }
        assert!(run.outputs() == stepped.outputs(), "{name}");
    }
}

#[test]
fn parameters_without_sense_are_refused_by_name() {
    for (name, parameter, value) in [
        ("NavInertial", "dvl_sigma", 0.0),
        ("NavDynamic", "initial.sigma.z", 0.0),
        ("NavModelAided", "disturbance.correlation_time", 0.0),
        ("NavConstantAcceleration", "prediction_interval", 2.0),
        ("EkfKinematic", "heading_sigma", 0.0),
        ("NavInertial", "mounting.dvl.x", f64::NAN),
        ("NavDynamic", "model.mass", 0.0),
    ] {
        let mut fmu = Fmu::new(name, CS);
        assert_eq!(fmu.set(parameter, value), Status::Error);
        assert!(fmu.line().contains(&format!("{parameter} = ")), "{name}");
    }
    let mut fmu = Fmu::new("NavDynamic", CS);
    // Values that are wrong only in combination with other parameters are detected once all are
    // known.
    assert_eq!(fmu.set("model.inertia.zz", 0.0), Status::Ok);
    assert_eq!(fmu.setup(0.0), Status::Ok);
    assert_eq!(fmu.initialize(), Status::Error);
    let line = fmu.line();
    assert!(line.contains("model.inertia"), "{line}");
}

#[test]
fn a_grade_gives_the_noise_that_is_not_set() {
    let mut fmu = Fmu::new("NavDynamic", CS);
    assert_eq!(fmu.set_integer("imu_grade", 3), Status::Ok);
    assert_eq!(fmu.set("gyro.random_walk", 7e-6), Status::Ok);
    assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
    assert_eq!(fmu.get("accelerometer.turn_on_sigma"), 0.005);
    assert_eq!(fmu.get("gyro.random_walk"), 7e-6);
    assert_eq!(fmu.get("tilt_sigma"), 5e-4);
    assert_eq!(fmu.get("disturbance.moment_density"), 5.0);
}
