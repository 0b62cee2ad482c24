//! What the C interface serves: the functions of FMI 2.0 after their arguments are checked.
//!
//! A component of the kit is served as an [`Instance`]. A library that serves something else (a
//! whole system of FMUs, a proxy of a remote one) implements this trait for it: it keeps a
//! [`Phase`](super::Phase), which defines what is legal when, and a [`Log`](super::Log) for the one
//! line of each failure. Everything but co-simulation has a default that rejects the call.

use std::ffi::{CStr, CString};

use fmu_standard::{Call, InterfaceType, Status};

use super::instance::Instance;
use super::log::Sink;
use super::model_exchange::EventOutcome;
use super::state::State;
use super::status::Trouble;

/// The arguments of `Instantiate`.
pub struct Request<'a> {
    /// The interface to serve.
    pub interface: InterfaceType,
    /// Name of the instance.
    pub name: &'a str,
    /// The identity shared by description and library.
    pub guid: &'a str,
    /// The FMU's folder of resources.
    pub resources: crate::Resources,
    /// The importer's logger.
    pub sink: Box<dyn Sink>,
    /// Whether debug messages are requested.
    pub logging_on: bool,
}

/// Declares functions whose default is a rejection.
macro_rules! refused {
    ($($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) = $call:ident, $flag:literal;)+) => {
        $(
            $(#[$doc])*
            fn $name(&mut self, $($argument: $type),*) -> Status {
                $(let _ = $argument;)*
                self.unsupported(Call::$call, $flag)
            }
        )+
    };
}

/// One instance of what a library serves.
pub trait Served: Sized + Send + 'static {
    /// A saved state.
    type State: Send + 'static;

    /// The frame of every function: whether it is legal now, its work, and one log line on failure.
    fn call(&mut self, call: Call, work: impl FnOnce(&mut Self) -> Result<(), Trouble>) -> Status;

    /// Marks the instance as corrupt after a panic in `call`.
    fn poison(&mut self, call: Call, reason: &str) -> Status;

    /// Rejects a function that is declared as not supported.
    fn unsupported(&mut self, call: Call, flag: &str) -> Status {
        self.call(call, |_| {
            Err(Trouble::error(format_args!("not supported, as modelDescription.xml says: {flag}")))
        })
    }

    /// Whether a function may be called now; logs a line if not.
    fn may(&mut self, call: Call) -> Status {
        self.call(call, |_| Ok(()))
    }

    /// Rejects a call because of its arguments.
    fn refuse(&mut self, call: Call, reason: &str) -> Status {
        self.call(call, |_| Err(Trouble::error(reason)))
    }

    /// `SetDebugLogging`
    fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Status;

    /// `SetupExperiment`
    fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start_s: f64,
        stop_s: Option<f64>,
    ) -> Status;

    /// `EnterInitializationMode`
    fn enter_initialization_mode(&mut self) -> Status;

    /// `ExitInitializationMode`
    fn exit_initialization_mode(&mut self) -> Status;

    /// `Terminate`
    fn terminate(&mut self) -> Status;

    /// `Reset`
    fn reset(&mut self) -> Status;

    /// `GetReal` if that only requires copying; `None` if it is not so simple. It must neither
    /// panic nor compute in floating point: the environment is the importer's.
    #[inline]
    fn get_fresh(&self, _references: &[u32], _into: &mut [f64]) -> Option<()> {
        None
    }

    /// `SetReal` if that only requires copying; `None` if it is not so simple. It must neither
    /// panic nor compute in floating point: the environment is the importer's.
    #[inline]
    fn set_inputs(&mut self, _references: &[u32], _values: &[f64]) -> Option<()> {
        None
    }

    /// `GetReal`
    fn get_real(&mut self, references: &[u32], into: &mut [f64]) -> Status;

    /// `GetInteger`, enumerations included
    fn get_integer(&mut self, references: &[u32], into: &mut [i32]) -> Status;

    /// `GetBoolean`: passes each value to `give` with its index.
    fn get_boolean(&mut self, references: &[u32], give: impl FnMut(usize, bool)) -> Status;

    /// `GetString`: passes each string to `give` with its index; it stays valid until the next
    /// call.
    fn get_string(&mut self, references: &[u32], give: impl FnMut(usize, &CStr)) -> Status;

    /// `SetReal`
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status;

    /// `SetInteger`, enumerations included
    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status;

    /// `SetBoolean`
    fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Status;

    /// `SetString`; `None` stands for NULL.
    fn set_string(&mut self, references: &[u32], values: &[Option<CString>]) -> Status;

    /// `GetFMUstate` into a new state.
    fn get_state(&mut self, state: &mut Option<Box<Self::State>>) -> Status;

    /// `GetFMUstate` into an existing state.
    fn get_state_again(&mut self, state: &mut Self::State) -> Status;

    /// `SetFMUstate`
    fn set_state(&mut self, state: &Self::State) -> Status;

    /// `SerializedFMUstateSize`
    fn serialized_size(&mut self, state: &Self::State, size: &mut usize) -> Status;

    /// `SerializeFMUstate`
    fn serialize_state(&mut self, state: &Self::State, into: &mut [u8]) -> Status;

    /// `DeSerializeFMUstate`
    fn deserialize_state(&mut self, bytes: &[u8], state: &mut Option<Box<Self::State>>) -> Status;

    /// `DoStep`
    fn do_step(&mut self, t: f64, h: f64) -> Status;

    /// `GetRealStatus` of `LastSuccessfulTime`
    fn last_successful_time(&mut self, into: &mut f64) -> Status;

    /// `GetBooleanStatus` of `Terminated`
    fn wants_to_end(&mut self, into: &mut bool) -> Status;

    /// Any other status kind: it would refer to a pending step, and there never is one.
    fn no_status(&mut self, call: Call, kind: i32) -> Status {
        self.call(call, |_| {
            Err(Trouble::discard(format_args!(
                "status kind {kind} is not available: steps are never pending"
            )))
        })
    }

    refused! {
        /// `GetDirectionalDerivative`
        directional_derivative(unknowns: &[u32], knowns: &[u32], along: &[f64], into: &mut [f64])
            = GetDirectionalDerivative, "providesDirectionalDerivative = false";
        /// `SetRealInputDerivatives`
        set_input_derivatives(references: &[u32], orders: &[i32], values: &[f64])
            = SetRealInputDerivatives, "canInterpolateInputs = false";
        /// `GetRealOutputDerivatives`
        output_derivatives(references: &[u32], orders: &[i32], into: &mut [f64])
            = GetRealOutputDerivatives, "maxOutputDerivativeOrder = 0";
        /// `EnterEventMode`
        enter_event_mode() = EnterEventMode, "no ModelExchange";
        /// `NewDiscreteStates`
        new_discrete_states(outcome: &mut EventOutcome) = NewDiscreteStates, "no ModelExchange";
        /// `EnterContinuousTimeMode`
        enter_continuous_time_mode() = EnterContinuousTimeMode, "no ModelExchange";
        /// `CompletedIntegratorStep`
        completed_integrator_step() = CompletedIntegratorStep, "no ModelExchange";
        /// `SetTime`
        set_time(time_s: f64) = SetTime, "no ModelExchange";
        /// `SetContinuousStates`
        set_continuous_states(x: &[f64]) = SetContinuousStates, "no ModelExchange";
        /// `GetContinuousStates`
        get_continuous_states(x: &mut [f64]) = GetContinuousStates, "no ModelExchange";
        /// `GetDerivatives`
        get_derivatives(derivatives: &mut [f64]) = GetDerivatives, "no ModelExchange";
        /// `GetNominalsOfContinuousStates`
        get_nominals(nominals: &mut [f64]) = GetNominals, "no ModelExchange";
        /// `GetEventIndicators`
        get_event_indicators(indicators: &mut [f64]) = GetEventIndicators, "no ModelExchange";
    }
}

/// Functions that the instance has under the same names.
macro_rules! own {
    ($($name:ident($($argument:ident: $type:ty),*);)+) => {
        $(
            #[inline]
            fn $name(&mut self, $($argument: $type),*) -> Status {
                Instance::$name(self, $($argument),*)
            }
        )+
    };
}

impl Served for Instance {
    type State = State;

    #[inline]
    fn call(&mut self, call: Call, work: impl FnOnce(&mut Self) -> Result<(), Trouble>) -> Status {
        Instance::call(self, call, work)
    }

    #[inline]
    fn get_fresh(&self, references: &[u32], into: &mut [f64]) -> Option<()> {
        Instance::get_fresh(self, references, into)
    }

    #[inline]
    fn set_inputs(&mut self, references: &[u32], values: &[f64]) -> Option<()> {
        Instance::set_inputs(self, references, values)
    }

    own! {
        poison(call: Call, reason: &str);
        set_debug_logging(on: bool, categories: &[&str]);
        setup_experiment(tolerance: Option<f64>, start_s: f64, stop_s: Option<f64>);
        enter_initialization_mode();
        exit_initialization_mode();
        terminate();
        reset();
        get_real(references: &[u32], into: &mut [f64]);
        get_integer(references: &[u32], into: &mut [i32]);
        get_boolean(references: &[u32], give: impl FnMut(usize, bool));
        get_string(references: &[u32], give: impl FnMut(usize, &CStr));
        set_real(references: &[u32], values: &[f64]);
        set_integer(references: &[u32], values: &[i32]);
        set_boolean(references: &[u32], values: &[bool]);
        set_string(references: &[u32], values: &[Option<CString>]);
        get_state(state: &mut Option<Box<State>>);
        get_state_again(state: &mut State);
        set_state(state: &State);
        serialized_size(state: &State, size: &mut usize);
        serialize_state(state: &State, into: &mut [u8]);
        deserialize_state(bytes: &[u8], state: &mut Option<Box<State>>);
        do_step(t: f64, h: f64);
        last_successful_time(into: &mut f64);
        wants_to_end(into: &mut bool);
        directional_derivative(unknowns: &[u32], knowns: &[u32], along: &[f64], into: &mut [f64]);
        set_input_derivatives(references: &[u32], orders: &[i32], values: &[f64]);
        output_derivatives(references: &[u32], orders: &[i32], into: &mut [f64]);
        enter_event_mode();
        new_discrete_states(outcome: &mut EventOutcome);
        enter_continuous_time_mode();
        completed_integrator_step();
        set_time(time_s: f64);
        set_continuous_states(x: &[f64]);
        get_continuous_states(x: &mut [f64]);
        get_derivatives(derivatives: &mut [f64]);
        get_nominals(nominals: &mut [f64]);
        get_event_indicators(indicators: &mut [f64]);
    }
}
