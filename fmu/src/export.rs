//! [`export!`]: the symbols of FMI 2.0 in the author's library.

/// Exports components as FMUs.
///
/// Expands to the 44 functions of FMI 2.0 with C linkage and to `REGISTRY`, which lists the
/// components. Call it once per library; `fmi2Instantiate` distinguishes the components by GUID.
#[macro_export]
macro_rules! export {
    ($($component:ty),+ $(,)?) => {
        /// The components of this library.
        pub static REGISTRY: ::std::sync::LazyLock<$crate::kernel::Registry> =
            ::std::sync::LazyLock::new(Components::registry);

        /// These components behind the C interface.
        #[doc(hidden)]
        #[allow(missing_docs)]
        pub struct Components;

        impl Components {
            fn registry() -> $crate::kernel::Registry {
                $crate::kernel::Registry::new(
                    ::std::module_path!(),
                    vec![$($crate::kernel::Deferred::of::<$component>()),+],
                )
            }

            /// The registry again, for unloading the library.
            fn shared() -> &'static $crate::kernel::Shared {
                static SHARED: $crate::kernel::Shared =
                    $crate::kernel::Shared::new(Components::registry);
                &SHARED
            }
        }

        impl $crate::abi::Library for Components {
            type Instance = $crate::kernel::Instance;

            fn instantiate(
                request: $crate::kernel::Request<'_>,
            ) -> ::std::result::Result<Self::Instance, ::std::string::String> {
                Self::shared().get().serve(request)
            }

            fn unload() {
                Self::shared().clear();
            }

            #[inline]
            fn shelf() -> &'static $crate::abi::Shelf<Self::Instance> {
                static SHELF: $crate::abi::Shelf<$crate::kernel::Instance> =
                    $crate::abi::Shelf::new();
                &SHELF
            }
        }

        $crate::export_library!(Components);
    };
}

/// Exports the 44 functions of FMI 2.0 for a [`Library`](crate::abi::Library), which [`export!`]
/// makes from components.
#[macro_export]
macro_rules! export_library {
    ($library:ident) => {
        /// The C interface of FMI 2.0.
        #[allow(missing_docs, non_snake_case, unsafe_code, clippy::missing_safety_doc)]
        pub mod fmi2 {
            use $crate::abi::types::*;

            /// Called when the library is unloaded, or the process ends.
            #[cfg(target_os = "linux")]
            #[used]
            #[unsafe(link_section = ".fini_array")]
            static UNLOAD: extern "C" fn() = $crate::abi::unload::<super::$library>;

            $crate::fmi2_functions! { super::$library;
                fmi2Instantiate(name: fmi2String, kind: fmi2Type, guid: fmi2String,
                    resources: fmi2String, functions: *const fmi2CallbackFunctions,
                    visible: fmi2Boolean, logging_on: fmi2Boolean) -> fmi2Component;
                fmi2GetTypesPlatform() -> fmi2String;
                fmi2GetVersion() -> fmi2String;
                fmi2SetDebugLogging(c: fmi2Component, on: fmi2Boolean, n: usize,
                    categories: *const fmi2String) -> fmi2Status;
                fmi2FreeInstance(c: fmi2Component) -> ();
                fmi2SetupExperiment(c: fmi2Component, tolerance_defined: fmi2Boolean,
                    tolerance: fmi2Real, start: fmi2Real, stop_defined: fmi2Boolean,
                    stop: fmi2Real) -> fmi2Status;
                fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status;
                fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status;
                fmi2Terminate(c: fmi2Component) -> fmi2Status;
                fmi2Reset(c: fmi2Component) -> fmi2Status;
                fmi2GetReal(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *mut fmi2Real) -> fmi2Status;
                fmi2GetInteger(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *mut fmi2Integer) -> fmi2Status;
                fmi2GetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *mut fmi2Boolean) -> fmi2Status;
                fmi2GetString(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *mut fmi2String) -> fmi2Status;
                fmi2SetReal(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *const fmi2Real) -> fmi2Status;
                fmi2SetInteger(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *const fmi2Integer) -> fmi2Status;
                fmi2SetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *const fmi2Boolean) -> fmi2Status;
                fmi2SetString(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                    value: *const fmi2String) -> fmi2Status;
                fmi2GetFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
                fmi2SetFMUstate(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status;
                fmi2FreeFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
                fmi2SerializedFMUstateSize(c: fmi2Component, state: fmi2FMUstate,
                    size: *mut usize) -> fmi2Status;
                fmi2SerializeFMUstate(c: fmi2Component, state: fmi2FMUstate,
                    bytes: *mut fmi2Byte, size: usize) -> fmi2Status;
                fmi2DeSerializeFMUstate(c: fmi2Component, bytes: *const fmi2Byte, size: usize,
                    state: *mut fmi2FMUstate) -> fmi2Status;
                fmi2GetDirectionalDerivative(c: fmi2Component,
                    unknowns: *const fmi2ValueReference, n_unknown: usize,
                    knowns: *const fmi2ValueReference, n_known: usize,
                    dv_known: *const fmi2Real, dv_unknown: *mut fmi2Real) -> fmi2Status;
                fmi2EnterEventMode(c: fmi2Component) -> fmi2Status;
                fmi2NewDiscreteStates(c: fmi2Component, info: *mut fmi2EventInfo) -> fmi2Status;
                fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status;
                fmi2CompletedIntegratorStep(c: fmi2Component, no_set_state: fmi2Boolean,
                    enter_event_mode: *mut fmi2Boolean, terminate: *mut fmi2Boolean)
                    -> fmi2Status;
                fmi2SetTime(c: fmi2Component, time: fmi2Real) -> fmi2Status;
                fmi2SetContinuousStates(c: fmi2Component, x: *const fmi2Real, nx: usize)
                    -> fmi2Status;
                fmi2GetDerivatives(c: fmi2Component, derivatives: *mut fmi2Real, nx: usize)
                    -> fmi2Status;
                fmi2GetEventIndicators(c: fmi2Component, indicators: *mut fmi2Real, ni: usize)
                    -> fmi2Status;
                fmi2GetContinuousStates(c: fmi2Component, x: *mut fmi2Real, nx: usize)
                    -> fmi2Status;
                fmi2GetNominalsOfContinuousStates(c: fmi2Component, x_nominal: *mut fmi2Real,
                    nx: usize) -> fmi2Status;
                fmi2SetRealInputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference,
                    nvr: usize, order: *const fmi2Integer, value: *const fmi2Real) -> fmi2Status;
                fmi2GetRealOutputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference,
                    nvr: usize, order: *const fmi2Integer, value: *mut fmi2Real) -> fmi2Status;
                fmi2DoStep(c: fmi2Component, t: fmi2Real, h: fmi2Real, no_set_state: fmi2Boolean)
                    -> fmi2Status;
                fmi2CancelStep(c: fmi2Component) -> fmi2Status;
                fmi2GetStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Status)
                    -> fmi2Status;
                fmi2GetRealStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real)
                    -> fmi2Status;
                fmi2GetIntegerStatus(c: fmi2Component, s: fmi2StatusKind,
                    value: *mut fmi2Integer) -> fmi2Status;
                fmi2GetBooleanStatus(c: fmi2Component, s: fmi2StatusKind,
                    value: *mut fmi2Boolean) -> fmi2Status;
                fmi2GetStringStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2String)
                    -> fmi2Status;
            }
        }
    };
}

/// Gives functions of the kit the C linkage and the unmangled names that the standard requires.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi2_functions {
    ($library:ty; $($name:ident($($argument:ident: $type:ty),*) -> $result:ty;)+) => {
        $(
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                // SAFETY: the arguments are passed on as the importer gave them.
                #[allow(unused_unsafe)]
                unsafe { $crate::abi::$name::<$library>($($argument),*) }
            }
        )+
    };
}
