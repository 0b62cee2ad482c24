//! Creation, initialization, termination (FMI 2.0.4, section 2.1).

use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::author::Resources;
use crate::kernel::{Call, Category, Interface, Request, Served, Sink, Status, spare};

use super::arguments::{array, copies, text};
use super::environment::{Environment, from_here};
use super::guard::{call, panic_text};
use super::handles::{Library, Live};
use super::logger::Logger;
use super::resource_uri;
use super::types::*;

/// `fmi2GetTypesPlatform`
#[must_use]
pub fn fmi2GetTypesPlatform<L: Library>() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`
#[must_use]
pub fn fmi2GetVersion<L: Library>() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2SetDebugLogging`
pub unsafe fn fmi2SetDebugLogging<L: Library>(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    call::<L>(c, Call::SetDebugLogging, |instance| {
        // SAFETY: the importer passes `nCategories` strings, as the standard requires.
        let names = unsafe { array("categories", categories, nCategories) };
        let names = match names {
            Ok(names) => names,
            Err(wrong) => return instance.refuse(Call::SetDebugLogging, &wrong),
        };
        // SAFETY: as above, each text ends with a NUL.
        let names = match unsafe { copies("categories", names) } {
            Ok(names) => names,
            Err(wrong) => return instance.refuse(Call::SetDebugLogging, &wrong),
        };
        let names: Vec<&str> = names
            .iter()
            .map(|name| name.as_ref().map_or("NULL", |name| name.to_str().unwrap_or("not UTF-8")))
            .collect();
        instance.set_debug_logging(loggingOn != FMI2_FALSE, &names)
    })
}

/// `fmi2Instantiate`; NULL when it fails, with a line in the log.
pub unsafe fn fmi2Instantiate<L: Library>(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    let _environment = Environment::enter();
    // SAFETY: the importer passes NULL or one struct of callbacks, as the standard requires.
    let Some(functions) = (unsafe { functions.as_ref() }) else {
        return std::ptr::null_mut();
    };
    // SAFETY: the importer passes NULL or NUL-terminated strings, likewise.
    let (name, guid, location) = unsafe {
        (
            text("instanceName", instanceName),
            text("fmuGUID", fmuGUID),
            text("fmuResourceLocation", fmuResourceLocation),
        )
    };
    let logger = || Logger::new(functions, name.as_ref().ok().copied().flatten().unwrap_or(c""));
    let made = catch_unwind(AssertUnwindSafe(|| {
        let (name, guid, location) = (name.clone()?.unwrap_or(c""), guid?, location?);
        spare(L::MEMORY).map_err(|trouble| trouble.text)?;
        let interface = Interface::from_number(fmuType)
            .ok_or_else(|| format!("fmuType = {fmuType} is neither 0 nor 1"))?;
        if name.is_empty() {
            return Err("instanceName is missing or empty".to_owned());
        }
        let resources =
            location.map_or_else(Resources::none, |uri| resource_uri::resources(utf8(uri)));
        let request = Request {
            interface,
            name: utf8(name),
            guid: guid.map_or("", utf8),
            resources,
            sink: Box::new(logger()),
            logging_on: loggingOn != FMI2_FALSE,
        };
        let live = Live { instance: L::instantiate(request)?, states: Vec::new() };
        L::shelf().instances.insert(Box::new(live)).ok_or_else(|| {
            "there are too many instances, or no memory for more; free some".to_owned()
        })
    }));
    let (status, category, reason) = match made {
        Ok(Ok(handle)) => return handle,
        Ok(Err(reason)) => (Status::Error, Category::Error, reason),
        Err(payload) => {
            let text = format!("panicked: {}", panic_text(&*payload));
            (Status::Fatal, Category::Fatal, text)
        }
    };
    logger().write(status, category, &format!("fmi2Instantiate: {reason}"));
    std::ptr::null_mut()
}

fn utf8(text: &CStr) -> &str {
    text.to_str().unwrap_or_default()
}

/// `fmi2FreeInstance`, which also frees the states that were made from the instance and not freed.
pub unsafe fn fmi2FreeInstance<L: Library>(c: fmi2Component) {
    let _environment = Environment::enter();
    // An invalid handle leaves nothing to free and no logger to report to.
    if let Ok(live) = L::shelf().instances.remove(c) {
        // A panic in an author's `drop` ends here.
        let _ = catch_unwind(AssertUnwindSafe(|| {
            for state in &live.states {
                drop(L::shelf().states.remove(std::ptr::without_provenance_mut(*state)));
            }
            drop(live);
        }));
    }
}

/// Runs when the library is unloaded or the process ends: drops everything made for all instances,
/// so that a host that loads and unloads the library gets its memory back.
pub extern "C" fn unload<L: Library>() {
    let _ = catch_unwind(AssertUnwindSafe(|| {
        L::shelf().unload();
        L::unload();
    }));
}

/// `fmi2SetupExperiment`
pub unsafe fn fmi2SetupExperiment<L: Library>(
    c: fmi2Component,
    toleranceDefined: fmi2Boolean,
    tolerance: fmi2Real,
    startTime: fmi2Real,
    stopTimeDefined: fmi2Boolean,
    stopTime: fmi2Real,
) -> fmi2Status {
    call::<L>(c, Call::SetupExperiment, |instance| {
        let (startTime, stopTime) = from_here(startTime, stopTime);
        let tolerance = (toleranceDefined != FMI2_FALSE).then_some(tolerance);
        let stop = (stopTimeDefined != FMI2_FALSE).then_some(stopTime);
        instance.setup_experiment(tolerance, startTime, stop)
    })
}

/// `fmi2EnterInitializationMode`
pub unsafe fn fmi2EnterInitializationMode<L: Library>(c: fmi2Component) -> fmi2Status {
    call::<L>(c, Call::EnterInitializationMode, |instance| instance.enter_initialization_mode())
}

/// `fmi2ExitInitializationMode`
pub unsafe fn fmi2ExitInitializationMode<L: Library>(c: fmi2Component) -> fmi2Status {
    call::<L>(c, Call::ExitInitializationMode, |instance| instance.exit_initialization_mode())
}

/// `fmi2Terminate`
pub unsafe fn fmi2Terminate<L: Library>(c: fmi2Component) -> fmi2Status {
    call::<L>(c, Call::Terminate, |instance| instance.terminate())
}

/// `fmi2Reset`
pub unsafe fn fmi2Reset<L: Library>(c: fmi2Component) -> fmi2Status {
    call::<L>(c, Call::Reset, |instance| instance.reset())
}
