//! Access to distributed runs: who may connect, with which rights, and why a client is refused.
//!
//! * `session` opens sessions as `configuration` and the command line specify;
//! * `endpoint` decides which addresses are on this machine, `credentials` reads certificates,
//!   `members` defines who has which role, `rights` answers queries for rights;
//! * `diagnose` finds out why a client is refused, `authority` makes certificates;
//! * `runtime` defines on which threads Zenoh works, `linger` keeps closed connections from stopping
//!   them;
//! * `allowed` defines which FMUs a worker loads.

pub(super) mod allowed;
pub(super) mod authority;
pub(super) mod configuration;
pub(super) mod credentials;
mod diagnose;
pub(super) mod endpoint;
#[cfg(unix)]
mod linger;
pub(super) mod members;
pub(super) mod rights;
pub(super) mod runtime;
pub(super) mod session;
