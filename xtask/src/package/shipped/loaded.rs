//! A library in this process, and the functions of FMI 2.0 in it.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]

use fmu_kit::{
    abi::types::{
        fmi2Boolean, fmi2CallbackFunctions, fmi2Component, fmi2Real, fmi2String, fmi2Type,
        fmi2ValueReference,
    },
    kernel::Status,
};
use libloading::os::unix::{Library as Image, RTLD_GLOBAL, RTLD_NOW};
use std::{
    ffi::{CStr, CString, c_void},
    fs,
    path::{Path, PathBuf},
};

const CO_SIMULATION: fmi2Type = 1;

/// A loaded library and its path.
pub(super) struct Loaded {
    image: Image,
    pub(super) path: PathBuf,
}

impl Loaded {
    /// Loads it so that all libraries loaded later would resolve its symbols before their own.
    pub(super) fn global(folder: &Path, name: &str, bytes: &[u8]) -> Self {
        let path = folder.join(format!("{name}.so"));
        fs::write(&path, bytes).unwrap();
        // SAFETY: the libraries are ours; loading them runs only code of Rust's runtime.
        let image = unsafe { Image::open(Some(&path), RTLD_NOW | RTLD_GLOBAL) }.unwrap();
        Self { image, path }
    }

    pub(super) fn function<T: Copy>(&self, name: &str) -> T {
        // SAFETY: the types requested below are those of the standard.
        *unsafe { self.image.get::<T>(name.as_bytes()) }.unwrap()
    }

    pub(super) fn instantiate(&self, guid: &str) -> fmi2Component {
        type Instantiate = unsafe extern "C" fn(
            fmi2String,
            fmi2Type,
            fmi2String,
            fmi2String,
            *const fmi2CallbackFunctions,
            fmi2Boolean,
            fmi2Boolean,
        ) -> fmi2Component;
        let instantiate: Instantiate = self.function("fmi2Instantiate");
        let guid = CString::new(guid).unwrap();
        let callbacks = fmi2CallbackFunctions {
            logger: None,
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: std::ptr::null_mut(),
        };
        let (name, uri) = (c"test".as_ptr(), c"".as_ptr());
        // SAFETY: all pointers live through the call.
        unsafe { instantiate(name, CO_SIMULATION, guid.as_ptr(), uri, &raw const callbacks, 0, 0) }
    }

    pub(super) fn call(&self, name: &str, instance: fmi2Component) -> Status {
        let function: unsafe extern "C" fn(fmi2Component) -> Status = self.function(name);
        // SAFETY: the instance came from this library.
        unsafe { function(instance) }
    }

    pub(super) fn initialize(&self, instance: fmi2Component) {
        type Setup = unsafe extern "C" fn(
            fmi2Component,
            fmi2Boolean,
            fmi2Real,
            fmi2Real,
            fmi2Boolean,
            fmi2Real,
        ) -> Status;
        let setup: Setup = self.function("fmi2SetupExperiment");
        // SAFETY: the instance came from this library.
        assert_eq!(unsafe { setup(instance, 0, 0.0, 0.0, 0, 0.0) }, Status::Ok);
        assert_eq!(self.call("fmi2EnterInitializationMode", instance), Status::Ok);
        assert_eq!(self.call("fmi2ExitInitializationMode", instance), Status::Ok);
    }

    pub(super) fn step(&self, instance: fmi2Component) -> Status {
        type DoStep =
            unsafe extern "C" fn(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean) -> Status;
        let step: DoStep = self.function("fmi2DoStep");
        // SAFETY: the instance came from this library.
        unsafe { step(instance, 0.0, 0.1, 1) }
    }

    pub(super) fn get(
        &self,
        instance: fmi2Component,
        reference: fmi2ValueReference,
    ) -> (Status, f64) {
        type GetReal = unsafe extern "C" fn(
            fmi2Component,
            *const fmi2ValueReference,
            usize,
            *mut fmi2Real,
        ) -> Status;
        let get: GetReal = self.function("fmi2GetReal");
        let mut value = f64::NAN;
        // SAFETY: the instance came from this library, the pointers live through the call.
        let status = unsafe { get(instance, &raw const reference, 1, &raw mut value) };
        (status, value)
    }

    pub(super) fn set(&self, instance: fmi2Component, reference: fmi2ValueReference, value: f64) {
        type SetReal = unsafe extern "C" fn(
            fmi2Component,
            *const fmi2ValueReference,
            usize,
            *const fmi2Real,
        ) -> Status;
        let set: SetReal = self.function("fmi2SetReal");
        // SAFETY: the instance came from this library, the pointers live through the call.
        let status = unsafe { set(instance, &raw const reference, 1, &raw const value) };
        assert_eq!(status, Status::Ok);
    }

    /// The file that the code at an address was loaded from.
    pub(super) fn origin(&self, name: &str) -> PathBuf {
        let address: *const c_void = self.function(name);
        // SAFETY: dladdr fills in the structure for any address; zero is a valid value of it.
        let found = unsafe {
            let mut info: libc::Dl_info = std::mem::zeroed();
            assert_ne!(libc::dladdr(address, &raw mut info), 0);
            CStr::from_ptr(info.dli_fname)
        };
        PathBuf::from(found.to_str().unwrap())
    }
}
