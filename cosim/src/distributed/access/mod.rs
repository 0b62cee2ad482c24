//! The door of distributed runs: who may come in, what they may do then, and why somebody may not.
//!
//! * `session` opens sessions as `configuration` and the command line say;
//! * `endpoint` says which addresses are on this machine, `credentials` reads certificates, `members`
//!   who has which role, `rights` what a role may do;
//! * `diagnose` says why somebody is refused, `authority` makes certificates;
//! * `runtime` says on which threads Zenoh works;
//! * `allowed` says which FMUs a worker loads.

pub(super) mod allowed;
pub(super) mod authority;
pub(super) mod configuration;
pub(super) mod credentials;
mod diagnose;
pub(super) mod endpoint;
pub(super) mod members;
pub(super) mod rights;
pub(super) mod runtime;
pub(super) mod session;
