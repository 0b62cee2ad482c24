//! The model structure in modelDescription.xml against what the components do, at random points that
//! are not those it was made from.
//!
//! * What moves an unknown is declared: by directional derivatives where there are any, elsewhere by
//!   moving one quantity in the second of two otherwise equal runs.
//! * What is declared moves it somewhere, or (what is sampled together depends together) moves another
//!   unknown of the same sample.
//! * A factor that is called constant is the same everywhere, one called fixed wherever the
//!   parameters are.

mod declared;
mod sampled;
mod subject;
mod vehicle;
