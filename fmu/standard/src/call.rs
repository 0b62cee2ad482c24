//! Which FMI function may be called in which state: the state machines of model exchange and
//! co-simulation as one table (FMI 2.0.4, sections 3.2.3 and 4.2.4).

use serde::{Deserialize, Serialize};

use crate::InterfaceType;

/// The states of an instance, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u16)]
pub enum Phase {
    /// Instantiated or reset.
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
    /// Co-simulation: a step was discarded; values are those of the last successful time.
    Failed = 256,
}

impl Phase {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Instantiated,
        Self::Initialization,
        Self::Event,
        Self::Continuous,
        Self::Step,
        Self::Terminated,
        Self::Error,
        Self::Fatal,
        Self::Failed,
    ];
}

const INSTANTIATED: u16 = Phase::Instantiated as u16;
const INITIALIZATION: u16 = Phase::Initialization as u16;
const EVENT: u16 = Phase::Event as u16;
const CONTINUOUS: u16 = Phase::Continuous as u16;
const STEP: u16 = Phase::Step as u16;
const FAILED: u16 = Phase::Failed as u16;
const ENDED: u16 = Phase::Terminated as u16 | Phase::Error as u16 | FAILED;
const ANY: u16 = 0x1FF;
const ANY_BUT_FATAL: u16 = ANY & !(Phase::Fatal as u16);
const BEFORE: u16 = INSTANTIATED | INITIALIZATION;
const RUNNING: u16 = EVENT | CONTINUOUS | STEP;
/// Functions of one interface only.
const ME: u16 = 1 << 14;
const CS: u16 = 1 << 15;

/// Declares the functions and their legal states, so that no function can be omitted.
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

            /// The states in which it may be called, and the interface it belongs to.
            const fn legal(self) -> u16 {
                match self { $(Self::$variant => $legal),+ }
            }
        }
    };
}

calls! {
    SetDebugLogging, "fmi2SetDebugLogging", ANY_BUT_FATAL;
    FreeInstance, "fmi2FreeInstance", ANY;
    SetupExperiment, "fmi2SetupExperiment", INSTANTIATED;
    EnterInitializationMode, "fmi2EnterInitializationMode", INSTANTIATED;
    ExitInitializationMode, "fmi2ExitInitializationMode", INITIALIZATION;
    Terminate, "fmi2Terminate", RUNNING | FAILED;
    Reset, "fmi2Reset", ANY_BUT_FATAL;
    GetReal, "fmi2GetReal", INITIALIZATION | RUNNING | ENDED;
    GetInteger, "fmi2GetInteger", INITIALIZATION | RUNNING | ENDED;
    GetBoolean, "fmi2GetBoolean", INITIALIZATION | RUNNING | ENDED;
    GetString, "fmi2GetString", INITIALIZATION | RUNNING | ENDED;
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
    EnterEventMode, "fmi2EnterEventMode", ME | CONTINUOUS;
    NewDiscreteStates, "fmi2NewDiscreteStates", ME | EVENT;
    EnterContinuousTimeMode, "fmi2EnterContinuousTimeMode", ME | EVENT;
    CompletedIntegratorStep, "fmi2CompletedIntegratorStep", ME | CONTINUOUS;
    SetTime, "fmi2SetTime", ME | EVENT | CONTINUOUS;
    SetContinuousStates, "fmi2SetContinuousStates", ME | CONTINUOUS;
    GetDerivatives, "fmi2GetDerivatives", ME | INITIALIZATION | EVENT | CONTINUOUS | ENDED;
    GetEventIndicators, "fmi2GetEventIndicators", ME | INITIALIZATION | EVENT | CONTINUOUS | ENDED;
    GetContinuousStates, "fmi2GetContinuousStates", ME | INITIALIZATION | EVENT | CONTINUOUS | ENDED;
    GetNominals, "fmi2GetNominalsOfContinuousStates", ME | BEFORE | EVENT | CONTINUOUS | ENDED;
    SetRealInputDerivatives, "fmi2SetRealInputDerivatives", CS | BEFORE | STEP;
    GetRealOutputDerivatives, "fmi2GetRealOutputDerivatives", CS | STEP | ENDED;
    DoStep, "fmi2DoStep", CS | STEP;
    CancelStep, "fmi2CancelStep", CS;
    GetStatus, "fmi2GetStatus", CS | STEP | ENDED;
    GetRealStatus, "fmi2GetRealStatus", CS | STEP | ENDED;
    GetIntegerStatus, "fmi2GetIntegerStatus", CS | STEP | ENDED;
    GetBooleanStatus, "fmi2GetBooleanStatus", CS | STEP | ENDED;
    GetStringStatus, "fmi2GetStringStatus", CS | STEP | ENDED;
}

impl Call {
    /// Whether it is a function of the interface at all.
    #[inline]
    #[must_use]
    pub const fn belongs_to(self, interface: InterfaceType) -> bool {
        let others = match interface {
            InterfaceType::ModelExchange => CS,
            InterfaceType::CoSimulation => ME,
        };
        self.legal() & others == 0
    }
}

impl Phase {
    /// Whether a function may be called in this state.
    #[inline]
    #[must_use]
    pub const fn allows(self, call: Call) -> bool {
        call.legal() & self as u16 != 0
    }

    /// Whether the instance is initialized, and did not fail.
    #[inline]
    #[must_use]
    pub const fn is_running(self) -> bool {
        self as u16 & RUNNING != 0
    }

    /// Where a function is not legal, in words: in this state, or in its interface.
    #[must_use]
    pub fn place(self, call: Call, interface: InterfaceType) -> String {
        match call.belongs_to(interface) {
            true => self.words().to_owned(),
            false => format!("in {}", interface.name()),
        }
    }

    /// The state in words, for log lines.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "after instantiation",
            Self::Initialization => "in initialization mode",
            Self::Event => "in event mode",
            Self::Continuous => "in continuous-time mode",
            Self::Step => "between communication steps",
            Self::Terminated => "after termination",
            Self::Error => "after an error (reset or free the instance)",
            Self::Fatal => "after a fatal error (free the instance)",
            Self::Failed => "after a discarded step (restore a state, reset or free the instance)",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Call, Phase};

    /// The tables of the standard a second time, by hand, with a letter for each state in the order
    /// of [`Phase::ALL`]: instantiated, initialization, event, continuous, step, terminated, error,
    /// fatal, failed step.
    const TABLE: &str = "
SetDebugLogging          inecstr-f
FreeInstance             inecstrxf
SetupExperiment          i--------
EnterInitializationMode  i--------
ExitInitializationMode   -n-------
Terminate                --ecs---f
Reset                    inecstr-f
GetReal                  -necstr-f
GetInteger               -necstr-f
GetBoolean               -necstr-f
GetString                -necstr-f
SetReal                  inecs----
SetInteger               ine-s----
SetBoolean               ine-s----
SetString                ine-s----
GetFmuState              inecstr-f
SetFmuState              inecstr-f
FreeFmuState             inecstr-f
SerializedFmuStateSize   inecstr-f
SerializeFmuState        inecstr-f
DeSerializeFmuState      inecstr-f
GetDirectionalDerivative -necstr-f
EnterEventMode           ---c-----
NewDiscreteStates        --e------
EnterContinuousTimeMode  --e------
CompletedIntegratorStep  ---c-----
SetTime                  --ec-----
SetContinuousStates      ---c-----
GetDerivatives           -nec-tr-f
GetEventIndicators       -nec-tr-f
GetContinuousStates      -nec-tr-f
GetNominals              inec-tr-f
SetRealInputDerivatives  in--s----
GetRealOutputDerivatives ----str-f
DoStep                   ----s----
CancelStep               ---------
GetStatus                ----str-f
GetRealStatus            ----str-f
GetIntegerStatus         ----str-f
GetBooleanStatus         ----str-f
GetStringStatus          ----str-f
";

    #[test]
    fn the_table_is_the_standards() {
        let written: Vec<(&str, &str)> =
            TABLE.lines().filter_map(|line| line.split_once(' ')).collect();
        let names: Vec<&str> = written.iter().map(|(name, _)| *name).collect();
        let functions: Vec<String> = Call::ALL.iter().map(|call| format!("{call:?}")).collect();
        assert_eq!(names, functions);
        for (call, (name, states)) in Call::ALL.iter().zip(written) {
            for (phase, state) in Phase::ALL.iter().zip(states.trim_start().chars()) {
                assert_eq!(phase.allows(*call), state != '-', "{name} {phase:?}");
            }
        }
    }
}
