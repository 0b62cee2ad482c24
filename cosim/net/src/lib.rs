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
//! * `layout` says which component runs where, and which group waits for which;
//! * `wire` is the format of the messages, `setup` the first message to a host;
//! * `host` computes a group with the engine of an ordinary run, `check` validates a set-up;
//! * `coordinator` drives the groups; `dispatcher` and `group_handle` send commands and recover
//!   lost groups;
//! * `fabric` carries messages; `net` does so over Zenoh, on two `channels`; `presence` tracks the
//!   workers;
//! * `access` opens sessions, and decides who may connect and with which rights;
//! * `status` collects the state of a run, `telemetry` publishes it and the recorded values,
//!   `watch` receives it;
//! * `proxy` writes and serves FMUs whose instances run on a worker;
//! * `remote` drives one instance for the simulation of another tool, `single` is that instance on
//!   its worker;
//! * `available_fmu` is what a worker advertises of an FMU that it holds;
//! * `worker` makes a machine available, `child` is the process in which FMUs run, `process_status`
//!   how it ended;
//! * `local_workers` starts workers for one run.

mod access;
mod available_fmu;
mod channels;
mod check;
mod child;
mod coordinator;
mod decode;
mod dispatcher;
mod distribute;
mod fabric;
mod failure;
mod group_handle;
mod host;
mod inbox;
mod keys;
mod layout;
mod library;
#[cfg(test)]
mod local;
mod local_workers;
mod net;
mod options;
mod placement;
mod pool;
mod presence;
mod process_status;
pub mod proxy;
mod remote;
mod run;
mod setup;
pub mod signature;
mod single;
mod status;
mod telemetry;
#[cfg(test)]
mod tests;
mod watch;
mod wire;
mod worker;

pub use access::allowed::Allowed;
pub use access::authority::Authority;
pub use access::configuration::{Configuration, Ours};
pub use access::credentials::Credentials;
#[doc(hidden)]
pub use access::members::{Members, Verb, all_rights};
pub use access::runtime::Threads;
pub use access::session::{Access, DEFAULT_ENDPOINT};
pub(crate) use available_fmu::AvailableFmu;
pub use child::serve as serve_group;
pub use cosim_confine::{close_inherited, unconfined};
#[doc(hidden)]
pub use decode::decode;
pub use options::{OnFatal, Options, several};
pub use pool::{Order, WorkerInfo, default_name};
pub use remote::{Reached, Remote};
pub use run::{Cluster, workers};
pub use status::{GroupStatus, Status};
pub use telemetry::Rate;
pub use watch::watch;
pub use worker::Worker;
