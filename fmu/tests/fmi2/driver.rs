//! An importer for tests: calls the exported C functions and collects log messages.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

use fmu_kit::abi::types::*;
use fmu_kit::abi::{Library, fmi2Instantiate};
use fmu_kit::kernel::{Registry, Status};

use crate::components::{REGISTRY, fmi2};

/// A message as the logger received it.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub status: Status,
    pub category: String,
    pub text: String,
}

// The logger's C signature is variadic, which stable Rust cannot define; every caller of it here
// passes exactly one text after "%s", and on the platforms tested a variadic call with pointer
// arguments is laid out as an ordinary one.
unsafe extern "C" fn collect(
    environment: fmi2ComponentEnvironment,
    _name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    format: fmi2String,
    text: *const c_char,
) {
    // SAFETY: the kit passes texts, and the environment is the list of the instance below.
    unsafe {
        assert_eq!(CStr::from_ptr(format), c"%s");
        let lines = &mut *environment.cast::<Vec<Line>>();
        let owned = |text: *const c_char| CStr::from_ptr(text).to_str().unwrap().to_owned();
        lines.push(Line { status, category: owned(category), text: owned(text) });
    }
}

/// The logger as called with one text.
type OneText = unsafe extern "C" fn(
    fmi2ComponentEnvironment,
    fmi2String,
    fmi2Status,
    fmi2String,
    fmi2String,
    *const c_char,
);

/// The callbacks with a logger that appends to `lines`.
pub fn callbacks(lines: *mut Vec<Line>) -> fmi2CallbackFunctions {
    let logger: OneText = collect;
    // SAFETY: see `collect`.
    let logger = unsafe { std::mem::transmute::<OneText, fmi2CallbackLogger>(logger) };
    fmi2CallbackFunctions {
        logger: Some(logger),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: lines.cast::<c_void>(),
    }
}

pub const ME: fmi2Type = 0;
pub const CS: fmi2Type = 1;

/// An instance under test.
pub struct Fmu {
    pub c: fmi2Component,
    /// Boxed, because the logger has its address.
    #[expect(clippy::box_collection, reason = "the address of the Vec itself must not change")]
    lines: Box<Vec<Line>>,
    pub name: &'static str,
    registry: &'static Registry,
}

impl Fmu {
    pub fn new(name: &'static str, interface: fmi2Type) -> Self {
        Self::with(name, interface, FMI2_FALSE, None).expect("instantiates")
    }

    pub fn with(
        name: &'static str,
        interface: fmi2Type,
        logging: fmi2Boolean,
        location: Option<&str>,
    ) -> Result<Self, Vec<Line>> {
        Self::made(&REGISTRY, name, location, |guid, location, callbacks| unsafe {
            let name = c"under test".as_ptr();
            fmi2::fmi2Instantiate(name, interface, guid, location, callbacks, FMI2_TRUE, logging)
        })
    }

    /// An instance from another library than that of the [`components`](crate::components), with
    /// the same storage.
    pub fn of<L: Library>(
        registry: &'static Registry,
        name: &'static str,
        interface: fmi2Type,
    ) -> Self {
        let made = Self::made(registry, name, None, |guid, location, callbacks| unsafe {
            let name = c"under test".as_ptr();
            fmi2Instantiate::<L>(name, interface, guid, location, callbacks, 0, 0)
        });
        made.expect("instantiates")
    }

    fn made(
        registry: &'static Registry,
        name: &'static str,
        location: Option<&str>,
        make: impl FnOnce(fmi2String, fmi2String, *const fmi2CallbackFunctions) -> fmi2Component,
    ) -> Result<Self, Vec<Line>> {
        let guid = CString::new(registry.named(name).unwrap().guid()).unwrap();
        let location = location.map(|text| CString::new(text).unwrap());
        let location = location.as_ref().map_or(null(), |text| text.as_ptr());
        let mut lines = Box::<Vec<Line>>::default();
        let callbacks = callbacks(&raw mut *lines);
        let c = make(guid.as_ptr(), location, &raw const callbacks);
        if c.is_null() { Err(*lines) } else { Ok(Self { c, lines, name, registry }) }
    }

    /// An instance of `name` past initialization.
    pub fn started(name: &'static str, interface: fmi2Type) -> Self {
        let mut fmu = Self::new(name, interface);
        assert_eq!(fmu.setup(0.0), Status::Ok);
        assert_eq!(fmu.initialize(), Status::Ok);
        fmu
    }

    pub fn setup(&mut self, start: f64) -> Status {
        unsafe { fmi2::fmi2SetupExperiment(self.c, 0, f64::NAN, start, 0, f64::NAN) }
    }

    pub fn initialize(&mut self) -> Status {
        match self.enter() {
            Status::Ok => self.exit(),
            bad => bad,
        }
    }

    pub fn enter(&mut self) -> Status {
        unsafe { fmi2::fmi2EnterInitializationMode(self.c) }
    }

    pub fn exit(&mut self) -> Status {
        unsafe { fmi2::fmi2ExitInitializationMode(self.c) }
    }

    pub fn step(&mut self, t: f64, h: f64) -> Status {
        unsafe { fmi2::fmi2DoStep(self.c, t, h, 1) }
    }

    pub fn reference(&self, name: &str) -> u32 {
        let variable = self.registry.named(self.name).unwrap().table().named(name);
        variable.unwrap_or_else(|| panic!("no variable {name}")).reference
    }

    pub fn set(&mut self, name: &str, value: f64) -> Status {
        let reference = self.reference(name);
        unsafe { fmi2::fmi2SetReal(self.c, &raw const reference, 1, &raw const value) }
    }

    pub fn set_integer(&mut self, name: &str, value: i32) -> Status {
        let reference = self.reference(name);
        unsafe { fmi2::fmi2SetInteger(self.c, &raw const reference, 1, &raw const value) }
    }

    pub fn set_string(&mut self, name: &str, value: &CStr) -> Status {
        let (reference, text) = (self.reference(name), value.as_ptr());
        unsafe { fmi2::fmi2SetString(self.c, &raw const reference, 1, &raw const text) }
    }

    pub fn try_get(&mut self, name: &str) -> (Status, f64) {
        let (reference, mut value) = (self.reference(name), f64::NAN);
        let status = unsafe { fmi2::fmi2GetReal(self.c, &raw const reference, 1, &raw mut value) };
        (status, value)
    }

    pub fn get(&mut self, name: &str) -> f64 {
        let (status, value) = self.try_get(name);
        assert_eq!(status, Status::Ok, "{name}: {:?}", self.lines);
        value
    }

    /// The messages logged since the last call.
    pub fn log(&mut self) -> Vec<Line> {
        std::mem::take(&mut *self.lines)
    }

    /// The one line that was logged since the last call.
    pub fn line(&mut self) -> String {
        match <[Line; 1]>::try_from(self.log()) {
            Ok([line]) => line.text,
            Err(lines) => panic!("not one line: {lines:?}"),
        }
    }

    pub fn free(mut self) -> fmi2Component {
        unsafe { fmi2::fmi2FreeInstance(self.c) };
        std::mem::replace(&mut self.c, null_mut())
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        unsafe { fmi2::fmi2FreeInstance(self.c) };
    }
}
