//! Our own solvers for model exchange: x' = f(t, x), with events.
//!
//! `continuous` drives an FMU from event to event with the methods of `fmu-ode`.

use fmu_ode::{CLASSICAL, DORMAND_PRINCE, Tableau};
use serde::{Deserialize, Serialize};

mod continuous;

pub(crate) use continuous::Continuous;

/// A Runge-Kutta method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Method {
    /// The classical method of order 4, one step per communication step (shorter before events).
    RungeKutta4,
    /// The pair of Dormand and Prince of orders 5 and 4, with steps chosen by the tolerance.
    #[default]
    DormandPrince,
}

impl Method {
    fn tableau(self) -> &'static Tableau {
        match self {
            Self::RungeKutta4 => &CLASSICAL,
            Self::DormandPrince => &DORMAND_PRINCE,
        }
    }
}

/// How model exchange is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// Error allowed per step, relative to the state and to its nominal value.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { method: Method::default(), tolerance: 1e-6 }
    }
}

impl std::str::FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "rk4" => Ok(Method::RungeKutta4),
            "dopri5" => Ok(Method::DormandPrince),
            _ => Err(format!("'{text}' is neither rk4 nor dopri5")),
        }
    }
}
