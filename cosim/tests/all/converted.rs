//! Conversions combined with other operations on inputs: manipulation, linear inputs.

use std::path::PathBuf;

use cosim::master::{Controls, Manipulator};
use cosim::system::Input;
use cosim::{Algorithm, Overrides, Recording, Run, System, Time};

use crate::formats::{Folder, component, connection, last, ssd, system};
use crate::models::Model;
use crate::osp;
use crate::ssd::{assert_near, run};

const LINEAR: &str = "<ssc:LinearTransformation factor='3' offset='1'/>";

/// A clock, tripled plus one, drives a model.
pub(crate) fn converted(model: Model, folder: &Folder, overrides: &Overrides) -> System {
    let ports = "u:input:Real y:output:Real";
    let elements = [
        component("c", &Model::Clock.fmu(), "y:output:Real", ""),
        component("x", &model.fmu(), ports, ""),
    ];
    let text = ssd(&system(&elements.concat(), &connection("c.y", "x.u", LINEAR)), "");
    System::load(folder.write("test.ssd", &text), overrides).unwrap()
}

/// An affine FMU with directional derivatives.
fn with_derivatives(folder: &Folder) -> PathBuf {
    let flag = "canGetAndSetFMUstate=\"true\"";
    let able = format!("{flag} providesDirectionalDerivative=\"true\"");
    folder.fmu(Model::Affine, "affine", &[(flag, &able)])
}

/// The loop of the system is solved at each step by one exact Newton step, after which a.y =
/// `slope` t + `offset`.
fn assert_newton_is_exact(system: &System, slope: f64, offset: f64) {
    let mut recording = Recording::new();
    let summary = system.run(&mut [&mut recording]).unwrap();
    let reported = &summary.notes[0];
    assert!(reported.contains("Jacobians by directional derivatives"), "{reported}");
    assert!(!reported.contains("by differences") && reported.contains("at most 2,"), "{reported}");
    let exact: Vec<f64> = recording.time().iter().map(|t| slope * t + offset).collect();
    assert_near(recording.column("a.y").unwrap(), &exact);
}

#[test]
fn the_derivatives_of_a_loop_go_through_its_conversions() {
    let folder = Folder::new();
    let affine = with_derivatives(&folder);
    let ports = "u:input:Real y:output:Real";
    let elements = [component("a", &affine, ports, ""), component("b", &affine, ports, "")];
    let connections = [connection("a.y", "b.u", LINEAR), connection("b.y", "a.u", "")];
    let text = ssd(&system(&elements.concat(), &connections.concat()), "");
    let overrides =
        Overrides::new().algorithm(Algorithm::Iterative).start_value("b.k", 2).stop_time(1.0);
    let system = System::load(folder.write("loop.ssd", &text), &overrides).unwrap();
    // a = b + t, b = 2 (3 a + 1) + t.
    assert_newton_is_exact(&system, -0.4, -0.4);
}

#[test]
fn the_derivatives_of_a_loop_go_through_its_sums() {
    let folder = Folder::new();
    let simulators = [
        osp::simulator("a", &with_derivatives(&folder), ""),
        osp::simulator("c", &Model::Clock.fmu(), ""),
    ];
    let connections = [
        osp::signal(("a", "y"), ("s", "in[0]")),
        osp::signal(("a", "y"), ("s", "in[1]")),
        osp::signal(("c", "y"), ("s", "in[2]")),
        osp::signal(("a", "u"), ("s", "out")),
    ];
    let text = osp::structure(&format!(
        "<Simulators>{}</Simulators><Functions><Sum name='s' inputCount='3'/></Functions>\
         <Connections>{}</Connections>",
        simulators.concat(),
        connections.concat()
    ));
    let overrides = Overrides::new().algorithm(Algorithm::Iterative);
    let system = System::load(folder.write("loop.xml", &text), &overrides).unwrap();
    // a = (a + a + t) + t.
    assert_newton_is_exact(&system, -2.0, 0.0);
}

/// Overrides an input at 0.5 s.
struct Fault(Option<Time>);

impl Manipulator for Fault {
    fn next(&self) -> Option<Time> {
        self.0
    }

    fn act(&mut self, _now: Time, controls: &mut Controls<'_>) -> cosim::Result<()> {
        self.0 = None;
        controls.set("x.u", 7.0)
    }
}

#[test]
fn a_manipulated_input_is_in_the_units_of_its_component() {
    let system = converted(Model::Gain, &Folder::new(), &Overrides::new());
    let mut fault = Fault(Some(Time::from_ns(500_000_000)));
    let mut recording = Recording::new();
    Run::new(&system).observe(&mut recording).manipulate(&mut fault).go().unwrap();
    let values = recording.column("x.y").unwrap();
    assert!((values[5] - 2.5).abs() < 1e-12, "{values:?}");
    assert_eq!(values[6..], [7.0; 5]);
}

#[test]
fn a_linear_input_moves_by_the_converted_slope() {
    let overrides = Overrides::new().input("", Input::Linear).start_value("x.k", 0);
    let system = converted(Model::Lag, &Folder::new(), &overrides);
    // x' = 3 t + 1, but 1 in the first step, when the slope of the clock is not known yet: 1.5 t^2
    // + t minus 1.5 * 0.1^2.
    let linear = last(&run(&system), "x.y");
    assert!((linear - 2.485).abs() < 1e-6, "{linear}");
    let overrides = Overrides::new().start_value("x.k", 0);
    let held = last(&run(&converted(Model::Lag, &Folder::new(), &overrides)), "x.y");
    assert!((held - 2.5).abs() > 0.1, "{held}");
}
