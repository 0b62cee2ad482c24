//! Crashes must never happen: wrong pointers, handles, references, values, panics.

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;

use crate::components::{REGISTRY, command, fmi2};
use crate::driver::{CS, Fmu, Line, callbacks};

#[test]
fn version_and_platform_are_the_standards() {
    unsafe {
        assert_eq!(CStr::from_ptr(fmi2::fmi2GetVersion()), c"2.0");
        assert_eq!(CStr::from_ptr(fmi2::fmi2GetTypesPlatform()), c"default");
    }
}

fn instantiate(guid: fmi2String, functions: *const fmi2CallbackFunctions) -> fmi2Component {
    unsafe { fmi2::fmi2Instantiate(c"x".as_ptr(), CS, guid, null(), functions, 0, 0) }
}

#[test]
fn a_wrong_guid_gives_null_and_a_line_that_names_both() {
    let mut lines = Vec::<Line>::new();
    let functions = callbacks(&raw mut lines);
    assert!(instantiate(c"{wrong}".as_ptr(), &raw const functions).is_null());
    let text = lines[0].text.clone();
    assert!(text.contains("{wrong}"), "{text}");
    assert!(text.contains(REGISTRY.named("Spring").unwrap().guid()), "{text}");
    assert!(instantiate(null(), &raw const functions).is_null());
    assert_eq!(lines.len(), 2);
    assert!(instantiate(c"{wrong}".as_ptr(), null()).is_null());
}

#[test]
fn no_logger_is_fine() {
    let guid = CString::new(REGISTRY.named("Spring").unwrap().guid()).unwrap();
    let functions = fmi2CallbackFunctions { logger: None, ..callbacks(null_mut()) };
    let c = instantiate(guid.as_ptr(), &raw const functions);
    unsafe {
        assert_eq!(fmi2::fmi2DoStep(c, 0.0, 0.1, 0), Status::Error);
        fmi2::fmi2FreeInstance(c);
    }
}

#[test]
fn an_unknown_type_or_an_empty_name_is_refused() {
    let lines = Fmu::with("Spring", 7, 0, None).err().unwrap();
    assert!(lines[0].text.contains("fmuType = 7"));
    let guid = CString::new(REGISTRY.named("Spring").unwrap().guid()).unwrap();
    let mut lines = Vec::<Line>::new();
    let functions = callbacks(&raw mut lines);
    for name in [null(), c"".as_ptr()] {
        let f = &raw const functions;
        assert!(
            unsafe { fmi2::fmi2Instantiate(name, CS, guid.as_ptr(), null(), f, 0, 0) }.is_null()
        );
    }
    assert_eq!(lines.len(), 2);
}

#[test]
fn a_handle_is_not_given_out_again() {
    let freed = Fmu::started("Spring", CS).free();
    let another = Fmu::started("Spring", CS);
    assert_ne!(another.c, freed);
    assert_eq!(unsafe { fmi2::fmi2Reset(freed) }, Status::Error);
}

#[test]
fn thousands_of_instances_come_and_go() {
    for _ in 0..5000 {
        let mut fmu = Fmu::started("Noise", CS);
        assert_eq!(fmu.step(0.0, 0.1), Status::Ok);
    }
}

#[test]
fn null_is_fine_for_nothing_and_refused_for_something() {
    let mut fmu = Fmu::started("Spring", CS);
    let (c, reference, mut value) = (fmu.c, 0_u32, 0.0);
    unsafe {
        assert_eq!(fmi2::fmi2GetReal(c, null(), 0, null_mut()), Status::Ok);
        assert_eq!(fmi2::fmi2SetReal(c, null(), 0, null()), Status::Ok);
        assert_eq!(fmu.log(), []);
        assert_eq!(fmi2::fmi2GetReal(c, null(), 1, &raw mut value), Status::Error);
        assert!(fmu.line().contains("vr is NULL"));
        assert_eq!(fmi2::fmi2GetReal(c, &raw const reference, 1, null_mut()), Status::Error);
        assert!(fmu.line().contains("value is NULL"));
        let huge = usize::MAX - 1;
        let status = fmi2::fmi2GetReal(c, &raw const reference, huge, &raw mut value);
        assert_eq!((status, fmu.log().len()), (Status::Error, 1));
        assert_eq!(fmi2::fmi2GetRealStatus(c, 2, null_mut()), Status::Error);
        assert_eq!(fmi2::fmi2SetDebugLogging(c, 1, 3, null()), Status::Error);
    }
}

#[test]
fn unknown_references_are_named_and_nothing_is_set() {
    let mut fmu = Fmu::started("Spring", CS);
    let force = fmu.reference("force");
    let (references, values) = ([force, 999], [5.0, 5.0]);
    let status = unsafe { fmi2::fmi2SetReal(fmu.c, references.as_ptr(), 2, values.as_ptr()) };
    assert_eq!(status, Status::Error);
    assert!(fmu.line().contains("value reference 999"));
    assert_eq!(fmu.get("force"), 0.0);
    let (mut reals, mut integers) = ([0.0; 2], [0; 2]);
    unsafe {
        let (c, vr) = (fmu.c, references.as_ptr());
        assert_eq!(fmi2::fmi2GetReal(c, vr, 2, reals.as_mut_ptr()), Status::Error);
        assert_eq!(fmi2::fmi2GetInteger(c, vr, 2, integers.as_mut_ptr()), Status::Error);
    }
    assert_eq!(fmu.log().len(), 2);
}

#[test]
fn values_that_are_not_finite_are_refused_with_function_variable_and_reason() {
    let mut fmu = Fmu::new("Spring", CS);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(fmu.set("force", value), Status::Error);
        let line = fmu.line();
        assert!(line.contains("fmi2SetReal: force = ") && line.contains("not finite"), "{line}");
    }
    assert_eq!(fmu.set("mass", f64::NAN), Status::Error);
    assert_eq!(fmu.setup(f64::NAN), Status::Error);
    assert!(fmu.log()[1].text.contains("startTime"));
}

#[test]
fn a_panic_ends_the_instance_and_nothing_else() {
    let mut other = Fmu::started("Clumsy", CS);
    let mut fmu = Fmu::started("Clumsy", CS);
    fmu.set("command", command::PANIC);
    assert_eq!(fmu.step(0.0, 0.2), Status::Fatal);
    let line = fmu.line();
    assert!(line.contains("fmi2DoStep: panicked: told to, 1"), "{line}");
    assert_eq!(fmu.try_get("echo").0, Status::Fatal);
    assert!(fmu.line().contains("fatal"));
    assert_eq!(other.step(0.0, 0.2), Status::Ok);
    fmu.free();
}

#[test]
fn messages_are_arguments_and_never_formats() {
    let mut lines = Vec::<Line>::new();
    let functions = callbacks(&raw mut lines);
    assert!(instantiate(c"%s%n%d".as_ptr(), &raw const functions).is_null());
    assert!(lines[0].text.contains("%s%n%d"));
}

#[test]
fn debug_messages_come_on_request_and_by_category() {
    let mut fmu = Fmu::with("Noise", CS, FMI2_TRUE, None).unwrap();
    fmu.setup(0.0);
    fmu.initialize();
    fmu.step(0.0, 1.0);
    let lines = fmu.log();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines.iter().all(|l| l.category == "logEvents" && l.status == Status::Ok));
    let names = [c"logStatusError".as_ptr()];
    assert_eq!(unsafe { fmi2::fmi2SetDebugLogging(fmu.c, 1, 1, names.as_ptr()) }, Status::Ok);
    fmu.step(1.0, 1.0);
    assert_eq!(fmu.log(), []);
    let names = [c"logEverything".as_ptr()];
    assert_eq!(unsafe { fmi2::fmi2SetDebugLogging(fmu.c, 1, 1, names.as_ptr()) }, Status::Error);
    let line = fmu.line();
    assert!(line.contains("logEverything") && line.contains("logEvents"), "{line}");
}

#[test]
fn texts_keep_their_utf8_and_booleans_any_truth() {
    let mut fmu = Fmu::new("Spring", CS);
    let (label, mut text) = (fmu.reference("label"), null());
    assert_eq!(fmu.set_string("label", c"\xc3\xbc %s"), Status::Ok);
    unsafe { fmi2::fmi2GetString(fmu.c, &raw const label, 1, &raw mut text) };
    assert_eq!(unsafe { CStr::from_ptr(text) }, c"\xc3\xbc %s");
    assert_eq!(fmu.set_string("label", c"\xff"), Status::Error);
    assert!(fmu.line().contains("UTF-8"));
    let (sprung, mut value) = (fmu.reference("sprung"), 42);
    unsafe {
        assert_eq!(fmi2::fmi2SetBoolean(fmu.c, &raw const sprung, 1, &raw const value), Status::Ok);
        fmi2::fmi2GetBoolean(fmu.c, &raw const sprung, 1, &raw mut value);
    }
    assert_eq!(value, 1);
}
