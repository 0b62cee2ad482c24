//! A component on another machine as an FMU on this one.
//!
//! ```text
//!  importer ── library ──(socket)── program ──(Zenoh)── worker ── instance
//!              `link`               `serve`, `distributed::Remote`
//! ```
//!
//! | file | what |
//! |---|---|
//! | `calls` | FMI calls as messages |
//! | `frames`, `link`, `serve` | the protocol between the library and the program beside it |
//! | `manifest`, `settings` | files in the FMU's resources |
//! | `write`, `description` | writes such an FMU |
//! | `shell` | an FMU without its binaries |

pub mod calls;
#[cfg(feature = "distributed")]
mod description;
pub mod frames;
pub mod link;
pub mod manifest;
#[cfg(feature = "distributed")]
pub mod serve;
#[cfg(feature = "distributed")]
mod settings;
#[cfg(feature = "distributed")]
pub(crate) mod shell;
#[cfg(feature = "distributed")]
mod write;

#[cfg(feature = "distributed")]
pub use write::Proxy;

/// The marker among the bytes of a library that serves remote FMUs of this format.
pub const MARK: &str = "cosim serves remote FMUs of version 1";
