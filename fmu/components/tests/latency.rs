//! Delayed samples: exactly after their latency, with the stamp of their instant, in order; and the
//! switch.

use fmu_kit::Resources;
use fmu_kit::kernel::{Category, Instance, Interface, Sink, Status};
use rexrov_fmu::REGISTRY;

struct Silence;

impl Sink for Silence {
    fn write(&self, _: Status, _: Category, _: &str) {}
}

/// A sensor before initialization.
fn sensor(name: &str) -> Instance {
    let entry = REGISTRY.named(name).unwrap();
    entry.instantiate(Interface::CoSimulation, Resources::none(), Box::new(Silence), false).unwrap()
}

fn reference(name: &str, variable: &str) -> u32 {
    REGISTRY.named(name).unwrap().table().named(variable).unwrap().reference
}

/// A sensor in a run of 1 ms steps.
struct Run {
    name: &'static str,
    instance: Instance,
    ms: u32,
}

impl Run {
    fn new(name: &'static str, parameters: &[(&str, f64)]) -> Self {
        let mut run = Self { name, instance: sensor(name), ms: 0 };
        parameters.iter().for_each(|(variable, value)| run.set(variable, *value));
        assert_eq!(run.instance.enter_initialization_mode(), Status::Ok);
        assert_eq!(run.instance.exit_initialization_mode(), Status::Ok);
        run
    }

    fn set(&mut self, variable: &str, value: f64) {
        let vr = [reference(self.name, variable)];
        assert_eq!(self.instance.set_real(&vr, &[value]), Status::Ok, "{variable}");
    }

    fn get(&mut self, variable: &str) -> f64 {
        let (vr, mut value) = ([reference(self.name, variable)], [f64::NAN]);
        assert_eq!(self.instance.get_real(&vr, &mut value), Status::Ok, "{variable}");
        value[0]
    }

    fn step(&mut self) {
        let t = f64::from(self.ms) * 1e-3;
        assert_eq!(self.instance.do_step(t, 1e-3), Status::Ok);
        self.ms += 1;
    }
}

/// At 10 Hz: the milliseconds at which the stamp changes, and the stamps.
fn shown(latency: f64, until_ms: u32) -> Vec<(u32, f64)> {
    let mut run = Run::new("Gps", &[("rate_hz", 10.0), ("latency", latency)]);
    let mut shown = Vec::new();
    let mut last = None;
    while run.ms <= until_ms {
        let newest = (run.get("valid") == 1.0).then(|| run.get("stamp"));
        if newest != last {
            shown.push((run.ms, newest.unwrap()));
            last = newest;
        }
        run.step();
    }
    shown
}

#[test]
fn a_sample_shows_exactly_after_its_latency_with_the_stamp_of_its_instant() {
    let stamps = |late: u32| -> Vec<(u32, f64)> {
        (0..4).map(|k| (100 * k + late, f64::from(k) * 0.1)).collect()
    };
    // None, part of a period, a whole one, several and a part.
    for late in [0, 37, 100, 250, 1234] {
        let found = shown(f64::from(late) * 1e-3, 300 + late);
        assert_eq!(found.len(), 4, "{late} ms: {found:?}");
        for ((ms, stamp), (want_ms, want)) in found.iter().zip(stamps(late)) {
            assert_eq!(*ms, want_ms, "{late} ms");
            assert!((stamp - want).abs() < 1e-9);
        }
    }
}

#[test]
fn a_late_sample_is_the_one_that_was_taken_then() {
    let position = |latency: f64| {
        let mut run = Run::new("Gps", &[("rate_hz", 10.0), ("latency", latency), ("sigma", 0.0)]);
        let mut seen = Vec::new();
        for ms in 0..2000_u32 {
            run.set("vehicle.pose.x", f64::from(ms) * 1e-3);
            run.step();
            if run.get("valid") == 1.0 {
                seen.push((run.get("stamp"), run.get("position.x")));
            }
        }
        seen.dedup();
        seen
    };
    let (now, late) = (position(0.0), position(0.43));
    assert_eq!(late, now[..late.len()]);
    assert_eq!(late.len(), now.len() - 5);
}

#[test]
fn all_sensors_have_it() {
    for name in ["Imu", "Ahrs", "Dvl", "Gps", "PressureSensor", "Tachometer"] {
        let mut run = Run::new(name, &[("rate_hz", 10.0), ("latency", 0.15)]);
        for ms in 1..=400_u32 {
            run.step();
            let newest = (f64::from(ms) - 150.0) / 100.0;
            let (valid, stamp) = (run.get("valid"), run.get("stamp"));
            assert_eq!(valid == 1.0, newest >= 0.0, "{name} at {ms} ms");
            assert!((stamp - 0.1 * newest.max(0.0).floor()).abs() < 1e-9, "{name} at {ms} ms");
        }
    }
}

#[test]
fn a_latency_beyond_64_samples_is_refused() {
    for (latency, accepted) in [(6.4, true), (6.41, false), (1e300, false)] {
        let mut gps = sensor("Gps");
        gps.set_real(&[reference("Gps", "latency")], &[latency]);
        gps.enter_initialization_mode();
        assert_eq!(gps.exit_initialization_mode() == Status::Ok, accepted, "{latency} s");
    }
}

#[test]
fn a_sensor_that_is_off_keeps_its_last_sample_and_those_on_their_way_arrive() {
    let mut run = Run::new("Gps", &[("rate_hz", 10.0), ("latency", 0.25)]);
    (0..350).for_each(|_| run.step());
    assert!((run.get("stamp") - 0.1).abs() < 1e-9);
    run.set("off", 1.0);
    (0..600).for_each(|_| run.step());
    assert!((run.get("stamp") - 0.3).abs() < 1e-9);
    let held = run.get("position.x");
    (0..300).for_each(|_| run.step());
    assert_eq!((run.get("valid"), run.get("position.x")), (1.0, held));
    run.set("off", 0.0);
    (0..300).for_each(|_| run.step());
    assert!((run.get("stamp") - 1.3).abs() < 1e-9);
}

/// A run continues from a saved state with the samples that were in transit.
#[test]
fn samples_on_their_way_are_part_of_the_state() {
    let mut run = Run::new("Gps", &[("rate_hz", 10.0), ("latency", 0.55)]);
    (0..1000).for_each(|_| run.step());
    let mut state = None;
    assert_eq!(run.instance.get_state(&mut state), Status::Ok);
    let mut go_on = || {
        (0..400).for_each(|_| run.step());
        let seen = [run.get("stamp"), run.get("position.x"), run.get("position.y")];
        assert_eq!(run.instance.set_state(state.as_ref().unwrap()), Status::Ok);
        run.ms = 1000;
        seen
    };
    assert_eq!(go_on(), go_on());
}

/// Lets a velocity log lose the bottom and find it again.
#[test]
fn a_log_without_bottom_lock_shows_its_last_sample() {
    let parameters = [("seabed_depth", 100.0), ("max_altitude", 50.0), ("rate_hz", 10.0)];
    let mut run = Run::new("Dvl", &parameters);
    assert_eq!(run.get("valid"), 0.0);
    run.set("vehicle.pose.z", 60.0);
    (0..150).for_each(|_| run.step());
    assert_eq!((run.get("valid"), run.get("beam[3].valid")), (1.0, 1.0));
    assert!((run.get("altitude") - 39.688).abs() < 1e-9);
    run.set("vehicle.pose.z", 40.0);
    (0..300).for_each(|_| run.step());
    assert!((run.get("stamp") - 0.1).abs() < 1e-9);
    run.set("vehicle.pose.z", 60.0);
    (0..100).for_each(|_| run.step());
    assert!((run.get("stamp") - 0.5).abs() < 1e-9);
}

/// A preset gives the values that are not set, in any order.
#[test]
fn grades_and_models_are_presets() {
    let choose = |name, choice, item, set: (&str, f64), ask: &str| {
        let mut instance = sensor(name);
        assert_eq!(instance.set_integer(&[reference(name, choice)], &[item]), Status::Ok);
        assert_eq!(instance.set_real(&[reference(name, set.0)], &[set.1]), Status::Ok);
        instance.enter_initialization_mode();
        assert_eq!(instance.exit_initialization_mode(), Status::Ok);
        let mut values = [f64::NAN; 2];
        let references = [reference(name, set.0), reference(name, ask)];
        assert_eq!(instance.get_real(&references, &mut values), Status::Ok);
        values
    };
    let imu = ("gyro.noise_density", 0.5);
    assert_eq!(choose("Imu", "grade", 3, imu, "accelerometer.turn_on_sigma"), [0.5, 0.005]);
    assert_eq!(choose("Imu", "grade", 2, imu, "attitude_sigma"), [0.5, 0.003]);
    let dvl = ("sigma", 0.25);
    assert_eq!(choose("Dvl", "model", 5, dvl, "beam_angle_deg"), [0.25, 25.0]);
    assert_eq!(choose("Dvl", "model", 1, dvl, "rate_hz"), [0.25, 7.0]);
}
