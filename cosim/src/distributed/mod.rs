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
//! * `fabric` is what carries messages; `net` does so over Zenoh, on two `lanes`, `present` knows who is there;
//! * `door` opens sessions, and says who may come in and what they may do then;
//! * `status` knows how a run stands, `telemetry` tells it and what is recorded, `watch` hears it;
//! * `remote` drives one instance for somebody else's simulation, `single` is that instance on its worker;
//! * `offer` is what a worker tells of an FMU that it holds;
//! * `worker` lends a machine, `child` is the process in which FMUs run, `fate` how it ended;
//! * `own` starts workers for one run.

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
mod remote;
mod run;
mod setup;
mod single;
mod status;
mod telemetry;
#[cfg(test)]
mod tests;
mod watch;
mod wire;
mod worker;

pub use crate::confine::{close_inherited, unconfined};
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
