//! FMI calls to an instance in another process, and their results.
//!
//! Several go together: what is set, the step, and what is read after it are one message in each
//! direction. Times and values keep their bits, so the instance sees what it would see here.

use fmu_standard::Call;
use serde::{Deserialize, Serialize};

use super::Basic;

/// A call of one function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Ask {
    /// `fmi2SetDebugLogging`: on or off, and the categories.
    Debug(bool, Vec<String>),
    /// `fmi2SetupExperiment`: tolerance, start and stop in seconds.
    SetUp(Option<f64>, f64, Option<f64>),
    /// `fmi2EnterInitializationMode`
    Enter,
    /// `fmi2ExitInitializationMode`
    Exit,
    /// `fmi2Reset`
    Reset,
    /// `fmi2SetReal` and the same for the other types
    Set(Vec<u32>, Values),
    /// `fmi2GetReal` and the same for the other types
    Get(Basic, Vec<u32>),
    /// `fmi2DoStep`: start and length, in seconds.
    Step(f64, f64),
    /// The serialized state: `fmi2GetFMUstate` and `fmi2SerializeFMUstate`.
    Save,
    /// Restores a serialized state: `fmi2DeSerializeFMUstate` and `fmi2SetFMUstate`.
    Restore(Vec<u8>),
    /// `fmi2GetDirectionalDerivative`: unknowns, knowns, and the direction.
    Derivative(Vec<u32>, Vec<u32>, Vec<f64>),
}

/// Values of one type.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are FMI's")]
pub enum Values {
    Real(Vec<f64>),
    Integer(Vec<i32>),
    Boolean(Vec<bool>),
    String(Vec<String>),
}

/// The result of a call.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Given {
    /// Success without a value.
    Done,
    /// Values that were read.
    Values(Values),
    /// A state.
    State(Vec<u8>),
}

/// The outcome of calls: they are made in order up to the first failure.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Results of those that succeeded.
    pub given: Vec<Given>,
    /// The failure of the one that did not.
    pub trouble: Option<Trouble>,
}

/// A call that failed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trouble {
    /// The status that it returned.
    pub status: i32,
    /// What, where, why.
    pub text: String,
    /// The instance wants the run to end.
    pub ended: bool,
}

impl Ask {
    /// The function.
    pub fn function(&self) -> Call {
        match self {
            Self::Debug(..) => Call::SetDebugLogging,
            Self::SetUp(..) => Call::SetupExperiment,
            Self::Enter => Call::EnterInitializationMode,
            Self::Exit => Call::ExitInitializationMode,
            Self::Reset => Call::Reset,
            Self::Set(_, Values::Real(_)) => Call::SetReal,
            Self::Set(_, Values::Integer(_)) => Call::SetInteger,
            Self::Set(_, Values::Boolean(_)) => Call::SetBoolean,
            Self::Set(_, Values::String(_)) => Call::SetString,
            Self::Get(Basic::Real, _) => Call::GetReal,
            Self::Get(Basic::Integer, _) => Call::GetInteger,
            Self::Get(Basic::Boolean, _) => Call::GetBoolean,
            Self::Get(Basic::String, _) => Call::GetString,
            Self::Step(..) => Call::DoStep,
            Self::Save => Call::SerializeFmuState,
            Self::Restore(_) => Call::SetFmuState,
            Self::Derivative(..) => Call::GetDirectionalDerivative,
        }
    }

    /// Whether it changes the instance: it must be repeated for a replacement.
    pub fn changes(&self) -> bool {
        !matches!(self, Self::Get(..) | Self::Save | Self::Derivative(..))
    }

    /// The most significant of several calls for a message: the one that advances time, or the
    /// last.
    pub fn main(asks: &[Self]) -> Option<&Self> {
        asks.iter().find(|ask| matches!(ask, Self::Step(..))).or(asks.last())
    }
}

impl Values {
    /// The type.
    pub fn basic(&self) -> Basic {
        match self {
            Self::Real(_) => Basic::Real,
            Self::Integer(_) => Basic::Integer,
            Self::Boolean(_) => Basic::Boolean,
            Self::String(_) => Basic::String,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Boolean(values) => values.len(),
            Self::String(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
