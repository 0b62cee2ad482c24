//! Which FMI function may be called in which state: the state machines of model exchange and
//! co-simulation as one table (FMI 2.0.4, sections 3.2.3 and 4.2.4).
//!
//! Two rows are wider than the standard's: values may be read right after instantiation, and
//! event mode may be entered twice, since importers do both.

/// The state of an instance, each a bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// Made or reset.
    Instantiated = 1,
    /// Between entering and leaving initialization mode.
    Initialization = 2,
    /// Model exchange: handling events.
    Event = 4,
    /// Model exchange: integrating.
    Continuous = 8,
    /// Co-simulation: between communication steps.
    Step = 16,
    /// Terminated: values can be read.
    Terminated = 32,
    /// A step or an event failed: values can be read, the instance reset or freed.
    Error = 64,
    /// Corrupt: the instance can only be freed.
    Fatal = 128,
}

const INSTANTIATED: u8 = Phase::Instantiated as u8;
const INITIALIZATION: u8 = Phase::Initialization as u8;
const EVENT: u8 = Phase::Event as u8;
const CONTINUOUS: u8 = Phase::Continuous as u8;
const STEP: u8 = Phase::Step as u8;
const ENDED: u8 = Phase::Terminated as u8 | Phase::Error as u8;
const ANY_BUT_FATAL: u8 = !(Phase::Fatal as u8);
const BEFORE: u8 = INSTANTIATED | INITIALIZATION;
const RUNNING: u8 = EVENT | CONTINUOUS | STEP;

/// Declares the functions and their legal states, so that a function cannot be left out.
macro_rules! calls {
    ($($variant:ident, $name:literal, $legal:expr;)+) => {
        /// The functions of FMI 2.0 that take an instance.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[expect(missing_docs, reason = "named as in the standard")]
        pub enum Call { $($variant),+ }

        impl Call {
            /// All functions.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// Name in the standard.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            /// The states in which it may be called, one bit each.
            #[must_use]
            pub const fn legal(self) -> u8 {
                match self { $(Self::$variant => $legal),+ }
            }
        }
    };
}

calls! {
    SetDebugLogging, "fmi2SetDebugLogging", ANY_BUT_FATAL;
    FreeInstance, "fmi2FreeInstance", u8::MAX;
    SetupExperiment, "fmi2SetupExperiment", INSTANTIATED;
    EnterInitializationMode, "fmi2EnterInitializationMode", INSTANTIATED;
    ExitInitializationMode, "fmi2ExitInitializationMode", INITIALIZATION;
    Terminate, "fmi2Terminate", RUNNING;
    Reset, "fmi2Reset", ANY_BUT_FATAL;
    GetReal, "fmi2GetReal", ANY_BUT_FATAL;
    GetInteger, "fmi2GetInteger", ANY_BUT_FATAL;
    GetBoolean, "fmi2GetBoolean", ANY_BUT_FATAL;
    GetString, "fmi2GetString", ANY_BUT_FATAL;
    SetReal, "fmi2SetReal", BEFORE | RUNNING;
    SetInteger, "fmi2SetInteger", BEFORE | EVENT | STEP;
    SetBoolean, "fmi2SetBoolean", BEFORE | EVENT | STEP;
    SetString, "fmi2SetString", BEFORE | EVENT | STEP;
    GetFmuState, "fmi2GetFMUstate", ANY_BUT_FATAL;
    SetFmuState, "fmi2SetFMUstate", ANY_BUT_FATAL;
    FreeFmuState, "fmi2FreeFMUstate", ANY_BUT_FATAL;
    SerializedFmuStateSize, "fmi2SerializedFMUstateSize", ANY_BUT_FATAL;
    SerializeFmuState, "fmi2SerializeFMUstate", ANY_BUT_FATAL;
    DeSerializeFmuState, "fmi2DeSerializeFMUstate", ANY_BUT_FATAL;
    GetDirectionalDerivative, "fmi2GetDirectionalDerivative", INITIALIZATION | RUNNING | ENDED;
    EnterEventMode, "fmi2EnterEventMode", EVENT | CONTINUOUS;
    NewDiscreteStates, "fmi2NewDiscreteStates", EVENT;
    EnterContinuousTimeMode, "fmi2EnterContinuousTimeMode", EVENT;
    CompletedIntegratorStep, "fmi2CompletedIntegratorStep", CONTINUOUS;
    SetTime, "fmi2SetTime", EVENT | CONTINUOUS;
    SetContinuousStates, "fmi2SetContinuousStates", CONTINUOUS;
    GetDerivatives, "fmi2GetDerivatives", INITIALIZATION | EVENT | CONTINUOUS | ENDED;
    GetEventIndicators, "fmi2GetEventIndicators", INITIALIZATION | EVENT | CONTINUOUS | ENDED;
    GetContinuousStates, "fmi2GetContinuousStates", INITIALIZATION | EVENT | CONTINUOUS | ENDED;
    GetNominals, "fmi2GetNominalsOfContinuousStates", BEFORE | EVENT | CONTINUOUS | ENDED;
    SetRealInputDerivatives, "fmi2SetRealInputDerivatives", BEFORE | STEP;
    GetRealOutputDerivatives, "fmi2GetRealOutputDerivatives", STEP | ENDED;
    DoStep, "fmi2DoStep", STEP;
    CancelStep, "fmi2CancelStep", 0;
    GetStatus, "fmi2GetStatus", STEP | ENDED;
    GetRealStatus, "fmi2GetRealStatus", STEP | ENDED;
    GetIntegerStatus, "fmi2GetIntegerStatus", STEP | ENDED;
    GetBooleanStatus, "fmi2GetBooleanStatus", STEP | ENDED;
    GetStringStatus, "fmi2GetStringStatus", STEP | ENDED;
}

impl Phase {
    /// Whether a function may be called in this state.
    #[inline]
    #[must_use]
    pub const fn allows(self, call: Call) -> bool {
        call.legal() & self as u8 != 0
    }

    /// The state in words, for log lines.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "after instantiation",
            Self::Initialization => "in initialization mode",
            Self::Event => "in event mode",
            Self::Continuous => "in continuous-time mode",
            Self::Step => "between communication steps",
            Self::Terminated => "after termination",
            Self::Error => "after an error (reset or free the instance)",
            Self::Fatal => "after a fatal error (free the instance)",
        }
    }
}
