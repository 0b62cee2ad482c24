//! The shared library of an FMU as a table of typed functions (FMI 2.0.5, 2.1 and 4.2).

use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

use libloading::Library;

use super::callbacks::{Callbacks, text};
use super::description::InterfaceType;
use super::elf;
use super::guard;
use super::open::{self, Opened};
use super::status::{self, RawStatus};
use cosim_base::error::{Code, Error, Result};

pub(super) type Component = *mut c_void;
pub(super) type Bool = c_int;
pub(super) type FmuState = *mut c_void;

/// A table of functions. A library that lacks a required one is refused. Any other missing one is
/// replaced by a function that returns [`status::MISSING`]: a library may lack functions that are
/// never called.
macro_rules! functions {
    ($(#[$doc:meta])* $name:ident {
        required { $($field:ident = $symbol:literal : fn($($argument:ty),*) $(-> $result:ty)?;)* }
        optional { $($may:ident = $may_symbol:literal : fn($($may_argument:ty),*);)* }
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(super) struct $name {
            $(pub $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            $(pub $may: unsafe extern "C" fn($($may_argument),*) -> RawStatus,)*
        }

        impl $name {
            fn resolve(library: &Library, fmu: &Path) -> Result<Self> {
                $(
                    // SAFETY: FMI 2.0 fixes the type of the function of that name.
                    let $field = *unsafe {
                        library.get::<unsafe extern "C" fn($($argument),*) $(-> $result)?>($symbol)
                    }
                    .map_err(|e| {
                        Error::new(Code::Library, format!("the library lacks {}", $symbol))
                            .at(fmu)
                            .why(e)
                            .help("the FMU was exported for another interface, or is damaged")
                    })?;
                )*
                $(
                    // SAFETY: FMI 2.0 fixes the type of the function of that name.
                    let found = unsafe {
                        library.get::<unsafe extern "C" fn($($may_argument),*) -> RawStatus>(
                            $may_symbol,
                        )
                    };
                    let $may = match found {
                        Ok(function) => *function,
                        Err(_) => {
                            unsafe extern "C" fn missing($(_: $may_argument),*) -> RawStatus {
                                status::MISSING
                            }
                            missing
                        }
                    };
                )*
                Ok(Self { $($field,)* $($may),* })
            }
        }
    };
}

functions! {
    /// Functions of both interface types.
    Functions {
        required {
            get_version = "fmi2GetVersion": fn() -> *const c_char;
            instantiate = "fmi2Instantiate": fn(
                *const c_char, c_int, *const c_char, *const c_char, *const Callbacks, Bool, Bool
            ) -> Component;
            free_instance = "fmi2FreeInstance": fn(Component);
            setup_experiment = "fmi2SetupExperiment": fn(
                Component, Bool, f64, f64, Bool, f64
            ) -> RawStatus;
            enter_initialization = "fmi2EnterInitializationMode": fn(Component) -> RawStatus;
            exit_initialization = "fmi2ExitInitializationMode": fn(Component) -> RawStatus;
        }
        optional {
            terminate = "fmi2Terminate": fn(Component);
            reset = "fmi2Reset": fn(Component);
            set_debug_logging = "fmi2SetDebugLogging": fn(
                Component, Bool, usize, *const *const c_char
            );
            get_real = "fmi2GetReal": fn(Component, *const u32, usize, *mut f64);
            get_integer = "fmi2GetInteger": fn(Component, *const u32, usize, *mut c_int);
            get_boolean = "fmi2GetBoolean": fn(Component, *const u32, usize, *mut Bool);
            get_string = "fmi2GetString": fn(
                Component, *const u32, usize, *mut *const c_char
            );
            set_real = "fmi2SetReal": fn(Component, *const u32, usize, *const f64);
            set_integer = "fmi2SetInteger": fn(
                Component, *const u32, usize, *const c_int
            );
            set_boolean = "fmi2SetBoolean": fn(Component, *const u32, usize, *const Bool);
            set_string = "fmi2SetString": fn(
                Component, *const u32, usize, *const *const c_char
            );
            get_state = "fmi2GetFMUstate": fn(Component, *mut FmuState);
            set_state = "fmi2SetFMUstate": fn(Component, FmuState);
            free_state = "fmi2FreeFMUstate": fn(Component, *mut FmuState);
            serialized_size = "fmi2SerializedFMUstateSize": fn(Component, FmuState, *mut usize);
            serialize = "fmi2SerializeFMUstate": fn(Component, FmuState, *mut u8, usize);
            deserialize = "fmi2DeSerializeFMUstate": fn(
                Component, *const u8, usize, *mut FmuState
            );
            directional = "fmi2GetDirectionalDerivative": fn(
                Component, *const u32, usize, *const u32, usize, *const f64, *mut f64
            );
        }
    }
}

functions! {
    /// Functions of co-simulation only.
    Stepping {
        required {
            do_step = "fmi2DoStep": fn(Component, f64, f64, Bool) -> RawStatus;
        }
        optional {
            get_status = "fmi2GetStatus": fn(Component, c_int, *mut c_int);
            real_status = "fmi2GetRealStatus": fn(Component, c_int, *mut f64);
            boolean_status = "fmi2GetBooleanStatus": fn(Component, c_int, *mut Bool);
            input_derivatives = "fmi2SetRealInputDerivatives": fn(
                Component, *const u32, usize, *const c_int, *const f64
            );
            output_derivatives = "fmi2GetRealOutputDerivatives": fn(
                Component, *const u32, usize, *const c_int, *mut f64
            );
        }
    }
}

functions! {
    /// Functions of model exchange only.
    Exchange {
        required {
            enter_event = "fmi2EnterEventMode": fn(Component) -> RawStatus;
            new_discrete = "fmi2NewDiscreteStates": fn(Component, *mut EventInfo) -> RawStatus;
            enter_continuous = "fmi2EnterContinuousTimeMode": fn(Component) -> RawStatus;
            set_time = "fmi2SetTime": fn(Component, f64) -> RawStatus;
            set_states = "fmi2SetContinuousStates": fn(Component, *const f64, usize) -> RawStatus;
            get_derivatives = "fmi2GetDerivatives": fn(Component, *mut f64, usize) -> RawStatus;
            get_states = "fmi2GetContinuousStates": fn(Component, *mut f64, usize) -> RawStatus;
        }
        optional {
            completed_step = "fmi2CompletedIntegratorStep": fn(
                Component, Bool, *mut Bool, *mut Bool
            );
            get_indicators = "fmi2GetEventIndicators": fn(Component, *mut f64, usize);
            get_nominals = "fmi2GetNominalsOfContinuousStates": fn(Component, *mut f64, usize);
        }
    }
}

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Debug, Default)]
pub(super) struct EventInfo {
    pub new_discrete_states_needed: Bool,
    pub terminate: Bool,
    pub nominals_changed: Bool,
    pub states_changed: Bool,
    pub next_event_defined: Bool,
    pub next_event: f64,
}

/// The functions of one interface type.
#[derive(Clone, Copy)]
pub(super) enum Own {
    Stepping(Stepping),
    Exchange(Exchange),
}

/// The functions of every co-simulation step, repeated next to each other.
#[derive(Clone, Copy)]
#[repr(C)]
pub(super) struct Hot {
    pub set_real: unsafe extern "C" fn(Component, *const u32, usize, *const f64) -> RawStatus,
    pub get_real: unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> RawStatus,
    /// Not for model exchange.
    pub do_step: Option<unsafe extern "C" fn(Component, f64, f64, Bool) -> RawStatus>,
}

impl Hot {
    pub(super) fn new(functions: &Functions, own: &Own) -> Self {
        let do_step = match own {
            Own::Stepping(stepping) => Some(stepping.do_step),
            Own::Exchange(_) => None,
        };
        Self { set_real: functions.set_real, get_real: functions.get_real, do_step }
    }
}

/// A mapped library.
pub(super) struct Binary {
    pub functions: Functions,
    pub own: Own,
    /// What it changed in the process while it was loaded.
    pub changed: Vec<String>,
    /// Number of threads of the process before that.
    threads: usize,
    /// Keeps the code mapped; the pointers above point into it.
    library: Opened,
}

impl Binary {
    /// Whether there are more threads than before: some may run code of the library.
    pub(super) fn may_run(&self) -> bool {
        threads() > self.threads
    }

    /// Keeps the library mapped permanently: a thread of it may still run.
    pub(super) fn leak(self) {
        std::mem::forget(self.library);
    }
}

/// Number of threads of this process, 0 if that is unknown.
fn threads() -> usize {
    std::fs::read_dir("/proc/self/task").map_or(0, Iterator::count)
}

/// Loads the library at `path`, which belongs to the FMU `fmu`.
pub(super) fn load(path: &Path, fmu: &Path, kind: InterfaceType) -> Result<Binary> {
    let threads = threads();
    // SAFETY: loading runs the library's constructors: a user who runs an FMU trusts its code.
    let (library, mut changed) =
        guard::around("loading the library", || unsafe { open::library(path) });
    let library = library.map_err(|e| {
        let help = remedy(&e);
        Error::new(Code::Library, "the library of the FMU cannot be loaded")
            .at(fmu)
            .why(e)
            .maybe_help(help)
    })?;
    let functions = Functions::resolve(&library.library, fmu)?;
    let own = match kind {
        InterfaceType::CoSimulation => Own::Stepping(Stepping::resolve(&library.library, fmu)?),
        InterfaceType::ModelExchange => Own::Exchange(Exchange::resolve(&library.library, fmu)?),
    };
    // SAFETY: the function takes nothing.
    let (version, more) =
        guard::around("fmi2GetVersion", || text(unsafe { (functions.get_version)() }));
    changed.extend(more);
    if version == "2.0" {
        return Ok(Binary { functions, own, changed, threads, library });
    }
    Err(Error::new(Code::Library, "the library of the FMU is not for FMI 2.0")
        .at(fmu)
        .why(format!("fmi2GetVersion returned '{version}'")))
}

/// The remedy for an error of the dynamic linker.
fn remedy(why: &str) -> Option<String> {
    if let Some((_, version)) = why.split_once("version `") {
        let version = version.split('\'').next().unwrap_or_default();
        return Some(format!(
            "the FMU was built on a system with {version}, which this one does not have: run it on \
             a newer one, or build it on one as old as this"
        ));
    }
    if let Some((missing, _)) = why.split_once(": cannot open shared object file") {
        return Some(format!(
            "install the library {missing}, or put it beside the FMU's own and name its folder by \
             LD_LIBRARY_PATH"
        ));
    }
    let (_, symbol) = why.split_once("undefined symbol: ")?;
    Some(format!(
        "the FMU was linked without the library that has {symbol}: name that by LD_PRELOAD, or \
         export the FMU again"
    ))
}

/// Possible paths of the library in the unpacked FMU, newest convention last (FMI 2.0.4, 2.3).
pub(super) fn folders() -> &'static [&'static str] {
    if cfg!(target_os = "linux") { elf::of_machine(std::env::consts::ARCH) } else { &[] }
}

#[cfg(test)]
mod tests {
    use super::remedy;

    #[test]
    fn each_reason_has_its_own_remedy() {
        let remedy_of = |why: &str| remedy(why).unwrap();
        let new =
            "/lib/x86_64-linux-gnu/libc.so.6: version `GLIBC_2.38' not found (required by x.so)";
        assert!(remedy_of(new).contains("a system with GLIBC_2.38"));
        let missing = "libgfortran.so.3: cannot open shared object file: No such file or directory";
        assert!(remedy_of(missing).contains("install the library libgfortran.so.3"));
        assert!(!remedy_of(missing).contains("GLIBC"));
        assert!(remedy_of("x.so: undefined symbol: dgesv_").contains("has dgesv_"));
        assert_eq!(remedy("invalid ELF header"), None);
    }
}
