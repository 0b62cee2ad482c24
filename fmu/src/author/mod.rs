//! The interface for component authors: one trait, two derives, a few plain types. Nothing here
//! depends on FMI's C interface or its XML. The variables themselves are those of `fmu-quantity`.

mod component;
mod error;
mod info;
mod resources;
mod runge_kutta;
mod sampled;
mod sampler;

pub use component::{Component, NoStates, Ports};
pub use error::{Fault, ParameterError};
pub use fmu_quantity::{
    Count, Declaration, Declarations, Enumeration, Field, Member, Reader, Start, Text, Variables,
    Writer,
};
pub use fmu_standard::Time;
pub use info::Info;
pub use resources::{Resources, read_text};
pub(crate) use runge_kutta::{add, runge_kutta};
pub use sampled::{Held, Sample, Sampled};
pub use sampler::Sampler;
