//! The model structure in modelDescription.xml compared with the behaviour of the components, at
//! random points other than those it was made from.
//!
//! * Everything that changes an unknown is declared: checked by directional derivatives if there
//!   are any, otherwise by changing one quantity in the second of two equal runs.
//! * Every declared known changes the unknown somewhere, or (because what is sampled together
//!   depends together) another unknown of the same sample.
//! * A factor declared constant is the same everywhere, a factor declared fixed is the same for
//!   equal parameters.

mod declared;
mod sampled;
mod subject;
mod vehicle;
