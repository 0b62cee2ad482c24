//! Inputs and outputs other than Reals, and parameters that change during a simulation.

use fmu_kit::kernel::Status;

use crate::components::{REGISTRY, fmi2};
use crate::driver::{CS, Fmu, ME};

impl Fmu {
    fn set_boolean(&mut self, name: &str, value: bool) -> Status {
        let (reference, value) = (self.reference(name), i32::from(value));
        unsafe { fmi2::fmi2SetBoolean(self.c, &raw const reference, 1, &raw const value) }
    }

    fn integer(&mut self, name: &str) -> i32 {
        let (reference, mut value) = (self.reference(name), -1);
        let status =
            unsafe { fmi2::fmi2GetInteger(self.c, &raw const reference, 1, &raw mut value) };
        assert_eq!(status, Status::Ok);
        value
    }

    fn text(&mut self, name: &str) -> String {
        let (reference, mut value) = (self.reference(name), std::ptr::null());
        let status =
            unsafe { fmi2::fmi2GetString(self.c, &raw const reference, 1, &raw mut value) };
        assert_eq!(status, Status::Ok);
        unsafe { std::ffi::CStr::from_ptr(value) }.to_str().unwrap().to_owned()
    }

    fn boolean(&mut self, name: &str) -> bool {
        let (reference, mut value) = (self.reference(name), -1);
        let status =
            unsafe { fmi2::fmi2GetBoolean(self.c, &raw const reference, 1, &raw mut value) };
        assert_eq!(status, Status::Ok);
        value == 1
    }
}

#[test]
fn the_description_has_the_types() {
    let text = REGISTRY.named("Valve").unwrap().describe().unwrap();
    let variable = |name: &str| {
        let (_, rest) = text.split_once(&format!("name=\"{name}\"")).unwrap();
        rest.split_once("</ScalarVariable>").unwrap().0
    };
    for (name, parts) in [
        ("capacity", ["causality=\"parameter\"", "variability=\"tunable\"", "<Real"]),
        ("pulses", ["causality=\"parameter\"", "variability=\"tunable\"", "<Integer"]),
        ("first", ["causality=\"parameter\"", "variability=\"fixed\"", "start=\"0\""]),
        ("powered", ["causality=\"input\"", "variability=\"discrete\"", "<Boolean start=\"true\""]),
        ("mode", ["causality=\"input\"", "variability=\"discrete\"", "declaredType=\"Mode\""]),
        ("part", ["causality=\"input\"", "variability=\"continuous\"", "<Real"]),
        ("flowing", ["causality=\"output\"", "variability=\"discrete\"", "<Boolean"]),
        ("count", ["causality=\"output\"", "variability=\"discrete\"", "<Integer"]),
    ] {
        for part in parts {
            assert!(variable(name).contains(part), "{name}: {part} in {}", variable(name));
        }
    }
    // Only the flow affects an output: inputs are 7 to 10, outputs 11 to 14.
    let outputs = text.split_once("<Outputs>").unwrap().1.split_once("</Outputs>").unwrap().0;
    let knowns = |output: &str| {
        let index =
            text.split("<ScalarVariable").position(|v| v.contains(&format!("name=\"{output}\"")));
        let row = outputs.split_once(&format!("index=\"{}\"", index.unwrap())).unwrap().1;
        row.split_once("dependencies=\"").unwrap().1.split_once('"').unwrap().0.to_owned()
    };
    let index = |name: &str| {
        let place =
            text.split("<ScalarVariable").position(|v| v.contains(&format!("name=\"{name}\"")));
        place.unwrap().to_string()
    };
    assert_eq!(knowns("is"), index("mode"));
    assert_eq!(knowns("count"), format!("{} {}", index("others"), index("volume")));
}

#[test]
fn values_of_all_types_go_in_and_out() {
    let mut valve = Fmu::started("Valve", CS);
    assert_eq!((valve.boolean("flowing"), valve.integer("is")), (false, 1));
    assert_eq!(valve.set_integer("mode", 2), Status::Ok);
    assert!(valve.boolean("flowing"));
    assert_eq!(valve.step(0.0, 1.0), Status::Ok);
    assert_eq!((valve.integer("count"), valve.integer("is")), (20, 2));
    assert_eq!(valve.set_boolean("powered", false), Status::Ok);
    assert_eq!(valve.set_integer("others", 7), Status::Ok);
    assert_eq!(valve.step(1.0, 1.0), Status::Ok);
    assert_eq!((valve.boolean("flowing"), valve.integer("count")), (false, 27));
    assert_eq!(valve.set_integer("mode", 3), Status::Error);
    assert!(valve.line().contains("mode = 3 is not within"));
}

#[test]
fn tunable_parameters_act_at_once_and_fixed_ones_are_refused() {
    let mut valve = Fmu::started("Valve", CS);
    assert_eq!(valve.set_integer("mode", 2), Status::Ok);
    assert_eq!(valve.step(0.0, 1.0), Status::Ok);
    assert_eq!(valve.set("capacity", 5.0), Status::Ok);
    assert_eq!(valve.get("flow"), 5.0);
    assert_eq!(valve.step(1.0, 1.0), Status::Ok);
    assert!((valve.get("volume") - 7.0).abs() < 1e-12);
    assert_eq!(valve.set_integer("pulses", 100), Status::Ok);
    assert_eq!(valve.integer("count"), 700);
    assert_eq!(valve.set_integer("first", 3), Status::Error);
    assert!(valve.line().contains("first cannot be set: it is fixed"));
    let mut valve = Fmu::started("Valve", CS);
    assert_eq!(valve.set("capacity", -1.0), Status::Error);
    assert!(valve.line().contains("capacity = -1 is not within"));
}

#[test]
fn in_model_exchange_they_change_in_event_mode() {
    let mut valve = Fmu::started("Valve", ME);
    assert_eq!(valve.set_integer("mode", 2), Status::Ok);
    assert_eq!(valve.set("capacity", 3.0), Status::Ok);
    let mut rate = 0.0;
    unsafe { fmi2::fmi2GetDerivatives(valve.c, &raw mut rate, 1) };
    assert_eq!(rate, 3.0);
    unsafe { fmi2::fmi2EnterContinuousTimeMode(valve.c) };
    // FMPy sets discrete inputs there, too, but only to their present values.
    assert_eq!(valve.set_boolean("powered", true), Status::Ok);
    assert_eq!(valve.set_boolean("powered", false), Status::Error);
}

#[test]
fn a_saved_state_has_them() {
    let mut valve = Fmu::started("Valve", CS);
    let mut state = std::ptr::null_mut();
    assert_eq!(valve.set_integer("mode", 2), Status::Ok);
    assert_eq!(valve.set("capacity", 4.0), Status::Ok);
    unsafe { fmi2::fmi2GetFMUstate(valve.c, &raw mut state) };
    assert_eq!(valve.set_integer("mode", 1), Status::Ok);
    assert_eq!(valve.set("capacity", 1.0), Status::Ok);
    assert_eq!(valve.step(0.0, 1.0), Status::Ok);
    unsafe { fmi2::fmi2SetFMUstate(valve.c, state) };
    assert_eq!((valve.integer("is"), valve.get("flow")), (2, 4.0));
    assert_eq!(valve.step(0.0, 1.0), Status::Ok);
    assert_eq!(valve.integer("count"), 40);
    unsafe { fmi2::fmi2FreeFMUstate(valve.c, &raw mut state) };
}

#[test]
fn a_saved_state_has_them_when_no_parameter_changed_since() {
    let mut valve = Fmu::started("Valve", CS);
    let mut state = std::ptr::null_mut();
    assert_eq!(valve.set_integer("mode", 2), Status::Ok);
    assert_eq!(valve.set_string("by", c"pilot"), Status::Ok);
    assert_eq!(valve.step(0.0, 1.0), Status::Ok);
    let seen = |valve: &mut Fmu| {
        (valve.integer("is"), valve.boolean("flowing"), valve.integer("count"), valve.text("label"))
    };
    let before = seen(&mut valve);
    assert_eq!(before, (2, true, 20, "pilot: Open".to_owned()));
    for _ in 0..2 {
        unsafe { fmi2::fmi2GetFMUstate(valve.c, &raw mut state) };
        assert_eq!(valve.set_integer("mode", 1), Status::Ok);
        assert_eq!(valve.set_string("by", c"nobody at all"), Status::Ok);
        assert_eq!(valve.step(1.0, 1.0), Status::Ok);
        assert_eq!(seen(&mut valve), (1, false, 20, "nobody at all: Shut".to_owned()));
        unsafe { fmi2::fmi2SetFMUstate(valve.c, state) };
        assert_eq!(seen(&mut valve), before);
        assert_eq!(valve.step(1.0, 1.0), Status::Ok);
        assert_eq!(valve.integer("count"), 40);
        unsafe { fmi2::fmi2SetFMUstate(valve.c, state) };
    }
    unsafe { fmi2::fmi2FreeFMUstate(valve.c, &raw mut state) };
}

#[test]
fn texts_go_in_and_out_and_are_cut_at_a_character() {
    let mut valve = Fmu::started("Valve", CS);
    assert_eq!(valve.text("label"), ": Shut");
    assert_eq!(valve.set_string("by", c"a captain with a very long name"), Status::Ok);
    assert_eq!(valve.text("label"), "a captain with a: Shut");
}
