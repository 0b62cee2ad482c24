//! A system computed by several processes, on one machine or many.
//!
//! ```text
//!  cosim run ──────── Coordinator ── Fabric ─┐      one message each way per group and level
//!                      order of the engine   │
//!                                            │ Zenoh (or, in tests, a queue)
//!  cosim worker ───── Supervisor             │
//!                      └─ child process: ────┴── Host ── Engine ── FMUs
//! ```
//!
//! * `layout` says which component is where, and who waits for whom;
//! * `wire` is the form of the messages, `setup` what a host is told first;
//! * `host` computes a group with the engine of an ordinary run, `check` says what a set-up must be;
//! * `coordinator` drives the groups, `recovery` and `member` what happens when one is lost;
//! * `fabric` is what carries messages; `net` does so over Zenoh, `session` opens it, `present` knows
//!   who is there;
//! * `endpoint`, `credentials`, `members` and `rights` keep the door: who may come in, and what they
//!   may do then; `diagnose` says why somebody may not, `authority` makes certificates;
//! * `allowed` says which FMUs a worker loads, `confine` what these may do there;
//! * `status` knows how a run stands, `telemetry` tells it and what is recorded, `watch` hears it;
//! * `worker` lends a machine, `child` is the process in which FMUs run, `fate` how it ended;
//! * `own` starts workers for one run.

mod allowed;
mod authority;
mod check;
mod child;
mod configuration;
mod confine;
mod coordinator;
mod credentials;
mod decode;
mod diagnose;
mod distribute;
mod endpoint;
mod fabric;
mod failure;
mod fate;
mod host;
mod keys;
mod layout;
mod library;
#[cfg(test)]
mod local;
mod member;
mod members;
mod net;
mod options;
mod own;
mod placement;
mod pool;
mod present;
mod recovery;
mod rights;
mod run;
mod session;
mod setup;
mod status;
mod telemetry;
#[cfg(test)]
mod tests;
mod watch;
mod wire;
mod worker;

pub use allowed::Allowed;
pub use authority::Authority;
pub use child::serve as serve_group;
pub use configuration::{Configuration, Ours};
pub use confine::{close_inherited, unconfined};
pub use credentials::Credentials;
#[doc(hidden)]
pub use decode::decode;
pub use members::Members;
pub use options::{OnFatal, Options};
pub use pool::{Order, WorkerInfo, default_name};
pub use run::{Cluster, workers};
pub use session::{Access, DEFAULT_ENDPOINT};
pub use status::{GroupStatus, Status};
pub use telemetry::Rate;
pub use watch::watch;
pub use worker::Worker;
