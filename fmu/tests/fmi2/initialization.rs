//! Importers set start values in different places; all must have the same effect.

use fmu_kit::kernel::Status;

use crate::driver::{CS, Fmu};

const HEAVY: i32 = 2;

fn started_with(
    before_setup: &[(&str, f64)],
    after: &[(&str, f64)],
    within: &[(&str, f64)],
) -> f64 {
    let mut fmu = Fmu::new("Spring", CS);
    let set = |fmu: &mut Fmu, values: &[(&str, f64)]| {
        for (name, value) in values {
            assert_eq!(fmu.set(name, *value), Status::Ok);
        }
    };
    set(&mut fmu, before_setup);
    fmu.setup(0.0);
    set(&mut fmu, after);
    fmu.enter();
    set(&mut fmu, within);
    assert_eq!(fmu.exit(), Status::Ok);
    for k in 0..10 {
        assert_eq!(fmu.step(f64::from(k) * 0.1, 0.1), Status::Ok);
    }
    fmu.get("position")
}

#[test]
fn start_values_count_wherever_they_arrive() {
    let values = [("mass", 2.0), ("start", 3.0), ("force", 1.5)];
    let first = started_with(&values, &[], &[]);
    assert_eq!(first, started_with(&[], &values, &[]));
    assert_eq!(first, started_with(&[], &[], &values));
    assert_ne!(first, started_with(&[], &[], &[]));
}

#[test]
fn an_explicit_parameter_wins_over_the_named_set_in_any_order() {
    for explicit_first in [true, false] {
        let mut fmu = Fmu::new("Spring", CS);
        if explicit_first {
            fmu.set("mass", 7.0);
        }
        assert_eq!(fmu.set_integer("parameter_set", HEAVY), Status::Ok);
        if !explicit_first {
            assert_eq!(fmu.get("mass"), 100.0);
            fmu.set("mass", 7.0);
        }
        fmu.setup(0.0);
        fmu.initialize();
        assert_eq!((fmu.get("mass"), fmu.get("stiffness")), (7.0, 400.0));
        assert_eq!((fmu.get("start"), fmu.get("position")), (2.0, 2.0));
    }
}

#[test]
fn setting_a_parameter_to_its_default_is_setting_it() {
    let mut fmu = Fmu::new("Spring", CS);
    fmu.set("mass", 1.0);
    fmu.set_integer("parameter_set", HEAVY);
    assert_eq!(fmu.get("mass"), 1.0);
}

#[test]
fn a_named_set_can_be_taken_back() {
    let mut fmu = Fmu::new("Spring", CS);
    fmu.set_integer("parameter_set", HEAVY);
    assert_eq!(fmu.get("stiffness"), 400.0);
    fmu.set_integer("parameter_set", 1);
    assert_eq!(fmu.get("stiffness"), 4.0);
}

#[test]
fn outputs_follow_inputs_and_parameters_in_initialization_mode() {
    let mut fmu = Fmu::new("Spring", CS);
    fmu.setup(0.0);
    fmu.enter();
    assert_eq!(fmu.get("acceleration"), -4.0);
    fmu.set("force", 10.0);
    assert_eq!(fmu.get("acceleration"), 6.0);
    fmu.set("start", 0.0);
    assert_eq!((fmu.get("acceleration"), fmu.get("der(state.v)")), (10.0, 10.0));
    fmu.set_integer("sign", -1);
    assert_eq!(fmu.get("acceleration"), -10.0);
}

#[test]
fn everything_is_readable_and_finite_right_after_instantiation() {
    for name in ["Spring", "Noise", "Clumsy"] {
        let mut fmu = Fmu::new(name, CS);
        let table = crate::components::REGISTRY.named(name).unwrap().table();
        for variable in table.variables() {
            if matches!(variable.start, fmu_kit::Start::Real(_)) {
                assert!(fmu.get(&variable.name).is_finite(), "{}", variable.name);
            }
        }
        assert_eq!(fmu.log(), []);
    }
}

#[test]
fn a_parameter_out_of_bounds_is_refused_and_named() {
    let mut fmu = Fmu::new("Spring", CS);
    assert_eq!(fmu.set("mass", -1.0), Status::Error);
    let line = fmu.line();
    assert!(line.contains("fmi2SetReal") && line.contains("mass = -1"), "{line}");
    assert_eq!(fmu.set_integer("parameter_set", 3), Status::Error);
    assert!(fmu.line().contains("parameter_set = 3"));
    assert_eq!(fmu.get("mass"), 1.0);
}

#[test]
fn a_parameter_the_component_refuses_fails_initialization_with_one_line() {
    let mut fmu = Fmu::new("Spring", CS);
    fmu.set("mass", 13.0);
    assert_eq!(fmu.try_get("position"), (Status::Ok, 1.0));
    fmu.setup(0.0);
    assert_eq!(fmu.initialize(), Status::Error);
    assert_eq!(
        fmu.line(),
        "fmi2ExitInitializationMode: mass: 13 kg brings bad luck; choose another"
    );
}

#[test]
fn reset_gives_a_fresh_instance() {
    let mut fmu = Fmu::started("Spring", CS);
    fmu.set("force", 3.0);
    fmu.step(0.0, 0.1);
    assert_eq!(unsafe { crate::components::fmi2::fmi2Reset(fmu.c) }, Status::Ok);
    assert_eq!((fmu.get("force"), fmu.get("time"), fmu.get("position")), (0.0, 0.0, 1.0));
    fmu.set("mass", 2.0);
    assert_eq!((fmu.setup(5.0), fmu.initialize()), (Status::Ok, Status::Ok));
    assert_eq!((fmu.get("time"), fmu.step(5.0, 0.1)), (5.0, Status::Ok));
}

#[test]
fn the_resource_folder_reaches_the_component_however_it_is_spelled() {
    let folder = std::env::temp_dir().join(format!("fmu kit \u{fc} {}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("label.txt"), "text").unwrap();
    let path = folder.to_str().unwrap();
    let encoded = path.replace(' ', "%20").replace('\u{fc}', "%C3%BC");
    for uri in [format!("file://{path}/"), format!("file:///{encoded}"), format!("file:{encoded}")]
    {
        let mut fmu = Fmu::with("Spring", CS, 0, Some(&uri)).unwrap();
        fmu.set_string("label", c"from file");
        fmu.setup(0.0);
        assert_eq!(fmu.initialize(), Status::Ok, "{uri}: {:?}", fmu.log());
    }
    std::fs::remove_dir_all(&folder).unwrap();
    let mut fmu = Fmu::new("Spring", CS);
    fmu.set_string("label", c"from file");
    fmu.setup(0.0);
    assert_eq!(fmu.initialize(), Status::Error);
    assert!(fmu.line().contains("label.txt"));
}
