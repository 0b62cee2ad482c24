//! The program's side of remote FMUs ([`cosim_import::proxy`]): it writes them, and serves their libraries.
//!
//! | file | what |
//! |---|---|
//! | `serve` | the protocol between the library and this program |
//! | `settings` | the file in the FMU's resources that says how workers are reached |
//! | `write`, `description` | writes such an FMU |
//! | `shell` | an FMU without its binaries |

mod description;
mod serve;
mod settings;
pub(super) mod shell;
mod write;

pub use serve::serve;
pub use write::Proxy;
