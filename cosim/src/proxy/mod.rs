//! A component on another machine as an FMU here.
//!
//! ```text
//!  importer ── library ──(socket)── program ──(Zenoh)── worker ── instance
//!              `link`               `serve`, `distributed::Remote`
//! ```
//!
//! | file | what |
//! |---|---|
//! | `calls` | calls of FMI as messages |
//! | `frames`, `link`, `serve` | what the library and the program beside it say to each other |
//! | `manifest`, `settings` | what lies in the FMU's resources |
//! | `write`, `description` | making such an FMU |
//! | `shell` | what an FMU tells without what computes in it |

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

/// What marks a library that serves remote FMUs of this form, among its bytes.
pub const MARK: &str = "cosim serves remote FMUs of version 1";
