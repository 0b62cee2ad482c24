//! What the crates of `cosim` share and what knows nothing of simulation: errors, files, names,
//! texts, times, units, XML.

mod digest;
pub mod error;
pub mod files;
mod messages;
pub mod names;
mod nesting;
pub mod shown;
pub mod texts;
pub mod time;
pub mod units;
pub mod xml;

pub use digest::{hexadecimal, sha256};
pub use error::{Code, Error, Result};
pub use messages::{Messages, Warnings};
pub use nesting::{MOST, is_too_deep};
pub use time::{Step, Time};
