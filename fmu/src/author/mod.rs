//! The interface for component authors: one trait, two derives, a few plain types. Nothing here
//! depends on FMI's C interface or its XML.

mod component;
mod enumeration;
mod error;
mod field;
mod info;
mod resources;
mod runge_kutta;
mod sampled;
mod sampler;
mod text;
mod variables;

pub use component::{Component, NoStates, Ports};
pub use enumeration::Enumeration;
pub use error::{Fault, ParameterError};
pub use field::{Declaration, Declarations, Field, Member, Start};
pub use fmu_standard::Time;
pub use info::Info;
pub use resources::{Resources, read_text};
pub(crate) use runge_kutta::{add, runge_kutta};
pub use sampled::{Held, Sample, Sampled};
pub use sampler::Sampler;
pub use text::Text;
pub use variables::{Count, Reader, Variables, Writer};
