//! The example does what its equations say: both regimes have closed forms.

use depth_hold::{DRAG, GAIN, MASS, REGISTRY};
use fmu_kit::Resources;
use fmu_kit::kernel::{Category, Instance, Interface, Sink, Status};

/// Every message is a failure here.
struct Refuse;

impl Sink for Refuse {
    fn write(&self, _: Status, _: Category, text: &str) {
        panic!("{text}");
    }
}

/// A running instance, and the value references of its variables.
fn started(limit: f64, target: f64) -> (Instance, impl Fn(&str) -> u32) {
    let entry = REGISTRY.named("DepthHold").unwrap();
    let reference = |name: &str| entry.table().named(name).unwrap().reference;
    let (interface, sink) = (Interface::CoSimulation, Box::new(Refuse));
    let mut fmu = entry.instantiate(interface, Resources::none(), sink, false).unwrap();
    fmu.setup_experiment(None, 0.0, None);
    fmu.set_real(&[reference("limit"), reference("target")], &[limit, target]);
    fmu.enter_initialization_mode();
    fmu.exit_initialization_mode();
    (fmu, reference)
}

/// Depths after each second.
fn depths(limit: f64, target: f64, seconds: u32) -> Vec<f64> {
    let (mut fmu, reference) = started(limit, target);
    let mut depth = [0.0];
    (0..seconds)
        .map(|t| {
            fmu.do_step(f64::from(t), 1.0);
            fmu.get_real(&[reference("depth")], &mut depth);
            depth[0]
        })
        .collect()
}

/// `z + 2 D z' + W^2 z = W^2 target` from rest.
#[test]
fn with_thrust_to_spare_it_is_a_damped_oscillator() {
    let damping = (DRAG + GAIN[1]) / (2.0 * MASS);
    let frequency = (GAIN[0] / MASS - damping * damping).sqrt();
    for (second, depth) in (1..).zip(depths(1e6, 3.0, 10)) {
        let (sin, cos) = (frequency * f64::from(second)).sin_cos();
        let decay = (-damping * f64::from(second)).exp();
        let expected = 3.0 * (1.0 - decay * (cos + damping / frequency * sin));
        assert!((depth - expected).abs() < 1e-8, "{second} s: {depth} is not {expected}");
    }
}

/// `w = F/d (1 - exp(-d t/m))`, integrated once.
#[test]
fn at_full_thrust_it_approaches_its_terminal_velocity() {
    let (limit, lag) = (60.0, MASS / DRAG);
    for (second, depth) in (1..).zip(depths(limit, 100.0, 10)) {
        let t = f64::from(second);
        let expected = limit / DRAG * (t - lag * (1.0 - (-t / lag).exp()));
        assert!((depth - expected).abs() < 1e-8, "{second} s: {depth} is not {expected}");
    }
}

#[test]
fn it_leaves_the_limit_and_arrives() {
    let depth = depths(60.0, 10.0, 60);
    assert!((depth[59] - 10.0).abs() < 1e-9, "{depth:?}");
    assert!(depth.iter().all(|z| *z < 11.5), "{depth:?}");
}
