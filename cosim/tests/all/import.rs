//! One FMU and one instance: descriptions, states, callbacks.

use cosim::Time;
use cosim::fmi::{Fmu, Instance, Logging, Phase, Place};
use tempfile::TempDir;

use crate::models::{Model, pack};

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

fn ready(model: Model) -> Instance {
    let fmu = Fmu::open(&model.fmu()).unwrap();
    let mut instance = Instance::new(fmu, "it", &Logging::default()).unwrap();
    instance.enter_initialization(Time::ZERO, seconds(1.0)).unwrap();
    instance.exit_initialization().unwrap();
    instance
}

#[test]
fn calls_out_of_order_are_refused_before_they_reach_the_fmu() {
    let fmu = Fmu::open(&Model::Gain.fmu()).unwrap();
    let mut instance = Instance::new(fmu, "it", &Logging::default()).unwrap();
    let error = instance.do_step(Time::ZERO, seconds(0.1)).unwrap_err().to_string();
    assert!(error.contains("fmi2DoStep of 'it' is not allowed after instantiation"), "{error}");
    assert!(instance.exit_initialization().is_err());
    assert!(instance.get_real(&[2], &mut [0.0]).is_err());
    assert!(instance.set_real(&[0, 1], &[0.0]).is_err());
}

#[test]
fn a_fatal_status_ends_the_instance_and_shows_its_log() {
    let mut instance = ready(Model::Logging);
    let step = seconds(0.1);
    let mut time = Time::ZERO;
    let error = loop {
        match instance.do_step(time, step) {
            Ok(()) => time = time + step,
            Err(error) => break error.to_string(),
        }
    };
    assert_eq!(time, seconds(0.2));
    assert_eq!(instance.phase(), Phase::Fatal);
    for part in ["returned Fatal", "step 3 of it", "level 0.500000", "at step 3"] {
        assert!(error.contains(part), "{part} in {error}");
    }
    assert!(instance.get_real(&[2], &mut [0.0]).is_err());
}

#[test]
fn a_saved_state_comes_back() {
    let mut instance = ready(Model::Integrator);
    let step = seconds(0.5);
    let mut y = [0.0];
    instance.set_real(&[0], &[1.0]).unwrap();
    instance.do_step(Time::ZERO, step).unwrap();
    assert!(instance.restore(Place::Iteration, Time::ZERO).is_err());
    instance.save(Place::Iteration).unwrap();
    instance.do_step(step, step).unwrap();
    instance.get_real(&[2], &mut y).unwrap();
    assert_eq!(y, [1.0]);
    instance.restore(Place::Iteration, step).unwrap();
    instance.get_real(&[2], &mut y).unwrap();
    assert_eq!(y, [0.5]);
}

/// Opens a gain whose description was changed, up to the instance.
fn changed(from: &str, to: &str) -> String {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.fmu");
    let description = Model::Gain.description();
    assert!(description.contains(from));
    let library = std::fs::read(crate::models::compile(Model::Gain)).unwrap();
    let entries = [
        ("modelDescription.xml", description.replace(from, to).into_bytes()),
        ("binaries/x86_64-linux/GAIN.so", library),
    ];
    pack(&path, &entries);
    let made = Fmu::open(&path).and_then(|fmu| {
        fmu.interface(cosim::fmi::InterfaceType::CoSimulation)?;
        Instance::new(fmu, "it", &Logging::default())
    });
    made.err().map_or("made".to_owned(), |e| e.to_string())
}

#[test]
fn the_folder_named_by_the_tuple_is_found_too() {
    assert_eq!(changed("cc", "gcc"), "made");
}

#[test]
fn wrong_descriptions_name_file_and_line() {
    for (from, to, parts) in [
        ("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\"", &["x.fmu/modelDescription.xml:2", "3.0"][..]),
        ("guid=\"{test}\"", "guid=\"{other}\"", &["returned NULL", "wrong GUID {other}"]),
        ("name=\"k\"", "name=\"u\"", &[":10", "declared twice", "line 9"]),
        ("valueReference=\"3\"", "valueReference=\"x\"", &[":12", "valueReference=\"x\""]),
        ("causality=\"output\"><Real", "causality=\"sideways\"><Real", &[":11", "sideways"]),
        ("start=\"0\" unit", "start=\"zero\" unit", &[":9", "'zero' is not a finite Real"]),
        ("index=\"6\"", "index=\"66\"", &[":23", "'66'", "10 variables"]),
        ("<CoSimulation", "<ModelExchange", &["no co-simulation part"]),
        ("modelIdentifier=\"GAIN\"", "modelIdentifier=\"LOSS\"", &["x86_64-linux", "LOSS.so"]),
        ("modelIdentifier=\"GAIN\"", "modelIdentifier=\"../GAIN\"", &[":3", "../GAIN"]),
        ("<?xml version=\"1.0\" encoding=\"UTF-8\"?>", "<!DOCTYPE x>", &["E103", ":1", "DTD"]),
        ("</ModelStructure>", "", &["E103", ":27"]),
    ] {
        let error = changed(from, to);
        for part in parts {
            assert!(error.contains(part), "{part} in {error}");
        }
    }
}

#[test]
fn a_file_that_is_no_library_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.fmu");
    let entries = [
        ("modelDescription.xml", Model::Gain.description().into_bytes()),
        ("binaries/linux64/GAIN.so", b"not a library".to_vec()),
    ];
    pack(&path, &entries);
    let error = Fmu::open(&path)
        .unwrap()
        .load(cosim::fmi::InterfaceType::CoSimulation)
        .unwrap_err()
        .to_string();
    assert!(error.contains("E105") && error.contains("x.fmu"), "{error}");
}
