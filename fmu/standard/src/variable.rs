//! Types and attributes of variables (sections 2.1.2 and 2.2.7).

use serde::{Deserialize, Serialize};

/// The base types of FMI, each with its own value references and functions; an Enumeration is an
/// Integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "named as in the standard")]
pub enum Basic {
    Real,
    Integer,
    Boolean,
    String,
}

impl Basic {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Real, Self::Integer, Self::Boolean, Self::String];
}

/// Declares an attribute of variables by its values and their names in the standard.
macro_rules! attribute {
    ($(#[$doc:meta])* $name:ident { $($value:ident = $word:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[expect(missing_docs, reason = "named as in the standard")]
        pub enum $name { $($value),+ }

        impl $name {
            /// Its name in modelDescription.xml.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$value => $word),+ }
            }

            /// The one of that name.
            #[must_use]
            pub fn named(name: &str) -> Option<Self> {
                match name {
                    $($word => Some(Self::$value),)+
                    _ => None,
                }
            }
        }
    };
}

attribute! {
    /// The role of a variable.
    Causality {
        Parameter = "parameter",
        CalculatedParameter = "calculatedParameter",
        Input = "input",
        Output = "output",
        Local = "local",
        Independent = "independent",
    }
}

attribute! {
    /// When a variable may change.
    Variability {
        Constant = "constant",
        Fixed = "fixed",
        Tunable = "tunable",
        Discrete = "discrete",
        Continuous = "continuous",
    }
}

attribute! {
    /// How a variable is initialized.
    Initial {
        Exact = "exact",
        Approx = "approx",
        Calculated = "calculated",
    }
}
