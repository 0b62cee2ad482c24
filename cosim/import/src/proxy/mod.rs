//! A component on another machine as an FMU on this one.
//!
//! ```text
//!  importer ── library ──(socket)── program ──(Zenoh)── worker ── instance
//!              `link`               `cosim_net::proxy`, `cosim_net::Remote`
//! ```
//!
//! | file | what |
//! |---|---|
//! | `frames` | the protocol between the library and the program beside it |
//! | `link` | the library's side of it; the program's is in `cosim_net::proxy` |
//! | `manifest` | the file in the FMU's resources that identifies it |

pub mod frames;
pub mod link;
pub mod manifest;

/// The marker among the bytes of a library that serves remote FMUs of this format.
pub const MARK: &str = "cosim serves remote FMUs of version 1";
