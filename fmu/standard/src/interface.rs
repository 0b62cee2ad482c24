//! The two interfaces of FMI (`fmi2Type`).

use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// How an FMU is driven; the numbers are those of `fmi2Type`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum InterfaceType {
    /// It provides derivatives and events; the importer integrates.
    ModelExchange = 0,
    /// It brings its own solver and is stepped.
    CoSimulation = 1,
}

impl InterfaceType {
    /// The interface of this number.
    #[must_use]
    pub const fn from_number(number: i32) -> Option<Self> {
        match number {
            0 => Some(Self::ModelExchange),
            1 => Some(Self::CoSimulation),
            _ => None,
        }
    }

    /// Its name in messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ModelExchange => "model exchange",
            Self::CoSimulation => "co-simulation",
        }
    }

    /// Its element in modelDescription.xml.
    #[must_use]
    pub const fn element(self) -> &'static str {
        match self {
            Self::ModelExchange => "ModelExchange",
            Self::CoSimulation => "CoSimulation",
        }
    }
}

impl FromStr for InterfaceType {
    type Err = String;

    /// `cs` or `me`.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "cs" => Ok(Self::CoSimulation),
            "me" => Ok(Self::ModelExchange),
            _ => Err(format!("'{text}' is neither cs nor me")),
        }
    }
}
