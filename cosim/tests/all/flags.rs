//! Capability flags: those that are set are respected, wrong ones are survived.

use std::path::{Path, PathBuf};

use cosim::fmi::{Fmu, Instance, InterfaceType, Logging, Phase, Place};
use cosim::{Algorithm, Code, Overrides, System, Time};
use tempfile::TempDir;

use crate::models::Model;
use crate::ssd::{Ssd, assert_near, run};

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

/// An FMU in a folder of its own; `flags` are attributes of its CoSimulation element.
fn gain(folder: &TempDir, defines: &[&str], flags: &str) -> PathBuf {
    Model::Gain.variant(&folder.path().join("gain.fmu"), defines, |description| {
        let (before, rest) = description.split_once(" canGetAndSetFMUstate").unwrap();
        let (_, after) = rest.split_once("/>").unwrap();
        format!("{before}{flags}/>{after}")
    })
}

fn ready(fmu: &Path) -> Instance {
    let fmu = Fmu::open(fmu).unwrap();
    let mut instance = Instance::new(fmu, "it", &Logging::default()).unwrap();
    instance.enter_initialization(Time::ZERO, seconds(1.0)).unwrap();
    instance.exit_initialization().unwrap();
    instance
}

/// y after one step with u = 3.
fn steps(instance: &mut Instance) -> f64 {
    let mut y = [0.0];
    instance.set_real(&[0], &[3.0]).unwrap();
    instance.do_step(Time::ZERO, seconds(0.1)).unwrap();
    instance.get_real(&[2], &mut y).unwrap();
    y[0]
}

#[test]
fn flags_are_read() {
    let folder = TempDir::new().unwrap();
    let flags = " canHandleVariableCommunicationStepSize='true' canInterpolateInputs='1' \
                 maxOutputDerivativeOrder='2' canRunAsynchronuously='true' \
                 canSerializeFMUstate='true' canNotUseMemoryManagementFunctions='true'";
    let fmu = Fmu::open(&gain(&folder, &[], flags)).unwrap();
    let interface = fmu.interface(InterfaceType::CoSimulation).unwrap();
    assert!(interface.variable_step && interface.interpolates_inputs && interface.asynchronous);
    assert!(interface.serialize_state && interface.own_memory && !interface.get_and_set_state);
    assert_eq!(interface.output_derivative_order, 2);
}

#[test]
fn an_fmu_of_which_there_may_be_one_is_refused_twice_and_may_come_again() {
    let folder = TempDir::new().unwrap();
    let path = gain(&folder, &[], " canBeInstantiatedOnlyOncePerProcess='true'");
    let first = ready(&path);
    // A copy has the same content: it is the same FMU.
    let copy = folder.path().join("copy.fmu");
    std::fs::copy(&path, &copy).unwrap();
    for path in [&path, &copy] {
        let second = Instance::new(Fmu::open(path).unwrap(), "second", &Logging::default());
        let error = second.err().unwrap().to_string();
        assert!(error.contains("'second'") && error.contains("one instance"), "{error}");
    }
    drop(first);
    assert_eq!(steps(&mut ready(&path)), 3.0);
}

#[test]
fn memory_is_the_fmus_own_or_ours_whatever_it_declares() {
    for (defines, flags) in [
        (&["OWN_MEMORY"][..], " canNotUseMemoryManagementFunctions='true'"),
        (&["OWN_MEMORY"], ""),
        (&[], " canNotUseMemoryManagementFunctions='true'"),
    ] {
        let folder = TempDir::new().unwrap();
        assert_eq!(steps(&mut ready(&gain(&folder, defines, flags))), 3.0);
    }
}

#[test]
fn a_tool_that_is_needed_is_named_and_may_be_here() {
    let folder = TempDir::new().unwrap();
    let path = gain(&folder, &[], " needsExecutionTool='true'");
    let load = |overrides: &Overrides| System::single(&path, overrides, None).map(|_| ());
    let error = load(&Overrides::new()).unwrap_err();
    let text = error.to_string();
    assert_eq!(error.code(), Code::Library);
    assert!(text.contains("'GAIN' needs a tool") && text.contains("the tool is cc"), "{text}");
    load(&Overrides::new().execution_tools(true)).unwrap();
}

#[test]
fn steps_are_equal_where_the_fmu_wants_it() {
    let folder = TempDir::new().unwrap();
    let path = gain(&folder, &["EQUAL_STEPS"], " canHandleVariableCommunicationStepSize='false'");
    let overrides = Overrides::new().step("", 0.3).output_interval(0.3).stop_time(1.0);
    // 0.3 s does not divide one second: the run ends with whole steps, or is refused before it
    // starts.
    match System::single(&path, &overrides, None) {
        Ok(system) => assert_eq!(system.run(&mut []).unwrap().steps, 3),
        Err(error) => assert_eq!(error.code(), Code::Timing),
    }
}

#[test]
fn a_state_that_cannot_be_saved_is_an_error_and_not_the_end() {
    for (defines, flags, part) in [
        (&["STATE_NULL"][..], " canGetAndSetFMUstate='true'", "gave no state"),
        (&["STATE_ERROR"], " canGetAndSetFMUstate='true'", "returned Error"),
        (&["LACKS_OPTIONAL"], " canGetAndSetFMUstate='true'", "has no fmi2GetFMUstate"),
        (&[], "", "does not declare canGetAndSetFMUstate"),
    ] {
        let folder = TempDir::new().unwrap();
        let mut instance = ready(&gain(&folder, defines, flags));
        let error = instance.save(Place::Retry).unwrap_err().to_string();
        assert!(error.contains("'it'") && error.contains(part), "{part} in {error}");
        assert!(instance.restore(Place::Retry, Time::ZERO).is_err());
    }
}

#[test]
fn derivatives_that_were_promised_and_do_not_come_are_replaced_by_differences() {
    for defines in [&["TANGENT_MISSING"], &["TANGENT_ERROR"], &["TANGENT_NAN"]] {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("affine.fmu");
        let fmu = Model::Affine.variant(&path, defines, |description| {
            description.replace(" canGet", " providesDirectionalDerivative=\"true\" canGet")
        });
        // a = 2 b + t, b = 3 a + t, which diverges in fixed-point passes.
        let ssd = Ssd::new()
            .add_with("a", Model::Affine, &[("k", 2.0)], None)
            .add_with("b", Model::Affine, &[("k", 3.0)], None)
            .connect("b.y", "a.u")
            .connect("a.y", "b.u")
            .stop(0.2);
        let overrides = Overrides::new().algorithm(Algorithm::Iterative);
        let overrides = overrides.replace("a", &fmu).replace("b", &fmu);
        let results = run(&ssd.load(&overrides).unwrap());
        assert_near(results.column("a.y").unwrap(), &[0.0, 0.1, 0.2].map(|t| -3.0 * t / 5.0));
    }
}

#[test]
fn a_library_may_lack_what_is_never_called() {
    let folder = TempDir::new().unwrap();
    let mut instance = ready(&gain(&folder, &["LACKS_OPTIONAL"], ""));
    assert_eq!(steps(&mut instance), 3.0);
    let error = instance.get_integer(&[0], &mut [0]).unwrap_err().to_string();
    assert!(error.contains("has no fmi2GetInteger") && error.contains("gain.fmu"), "{error}");
    // Nothing was called, so nothing is broken.
    assert_eq!(instance.phase(), Phase::Step);
}

#[test]
fn a_step_in_the_background_is_waited_for() {
    let folder = TempDir::new().unwrap();
    let path = gain(&folder, &["PENDING"], " canRunAsynchronuously='true'");
    let begun = std::time::Instant::now();
    assert_eq!(steps(&mut ready(&path)), 3.0);
    assert!(begun.elapsed().as_millis() >= 25);
}

#[test]
fn a_step_in_the_background_that_was_not_declared_is_refused_by_name() {
    let folder = TempDir::new().unwrap();
    let mut instance = ready(&gain(&folder, &["PENDING"], ""));
    let error = instance.do_step(Time::ZERO, seconds(0.1)).unwrap_err().to_string();
    for part in ["fmi2DoStep of 'it'", "returned Pending", "canRunAsynchronuously"] {
        assert!(error.contains(part), "{part} in {error}");
    }
    // Its thread still writes into the instance: neither that nor its code may be released.
    drop(instance);
    drop(folder);
    while works() {
        std::thread::yield_now();
    }
}

/// Whether a thread of such a step is at work in this process.
fn works() -> bool {
    let threads = std::fs::read_dir("/proc/self/task").unwrap().flatten();
    let mut names = threads.flat_map(|thread| std::fs::read_to_string(thread.path().join("comm")));
    names.any(|name| name.trim_end() == "works")
}

#[test]
fn the_library_is_the_one_whose_header_fits() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x.fmu");
    let library = std::fs::read(crate::models::compile(Model::Gain)).unwrap();
    let mut foreign = library.clone();
    // e_machine: AArch64.
    foreign[18] = 183;
    let pack = |entries: &[(&str, &[u8])]| {
        let description = Model::Gain.description().into_bytes();
        let mut all = vec![("modelDescription.xml", description)];
        all.extend(entries.iter().map(|(name, bytes)| (*name, bytes.to_vec())));
        crate::models::pack(&path, &all);
        Fmu::open(&path).unwrap().load(InterfaceType::CoSimulation)
    };
    let (name, tuple) = ("binaries/linux64/GAIN.so", "binaries/x86_64-linux/GAIN.so");
    let error = pack(&[(name, &foreign)]).unwrap_err().to_string();
    assert!(error.contains("built for aarch64, this machine is x86_64"), "{error}");
    pack(&[(name, &foreign), (tuple, &library)]).unwrap();
    let error = pack(&[("binaries/win64/GAIN.dll", b"MZ")]).unwrap_err().to_string();
    assert!(error.contains("binaries for: win64") && error.contains(name), "{error}");
}
