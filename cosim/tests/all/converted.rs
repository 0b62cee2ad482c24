//! Conversions with the other things that happen to inputs: manipulation, linear inputs.

use cosim::master::{Controls, Manipulator};
use cosim::system::Input;
use cosim::{Overrides, Recording, Run, System, Time};

use crate::formats::{Folder, component, connection, last, ssd, system};
use crate::models::Model;
use crate::ssd::run;

const LINEAR: &str = "<ssc:LinearTransformation factor='3' offset='1'/>";

/// A clock, tripled plus one, drives a model.
fn converted(model: Model, folder: &Folder, overrides: &Overrides) -> System {
    let ports = "u:input:Real y:output:Real";
    let elements = [
        component("c", &Model::Clock.fmu(), "y:output:Real", ""),
        component("x", &model.fmu(), ports, ""),
    ];
    let text = ssd(&system(&elements.concat(), &connection("c.y", "x.u", LINEAR)), "");
    System::load(folder.write("test.ssd", &text), overrides).unwrap()
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
    let mut fault = Fault(Some(Time::from_nanoseconds(500_000_000)));
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
    // x' = 3 t + 1, but 1 in the first step, when nobody knows the slope of the clock yet:
    // 1.5 t^2 + t less 1.5 * 0.1^2.
    let linear = last(&run(&system), "x.y");
    assert!((linear - 2.485).abs() < 1e-6, "{linear}");
    let overrides = Overrides::new().start_value("x.k", 0);
    let held = last(&run(&converted(Model::Lag, &Folder::new(), &overrides)), "x.y");
    assert!((held - 2.5).abs() > 0.1, "{held}");
}
