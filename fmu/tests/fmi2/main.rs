//! FMI 2.0 as an importer sees it: the exported C functions, used as importers use them, and
//! misused as importers misuse them.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]
#![allow(unreachable_pub, reason = "shared modules of one test program")]

mod abuse;
mod bad_arguments;
mod co_simulation;
mod components;
mod description;
mod driver;
mod hybrid;
mod initialization;
mod integration;
mod legality;
mod memory_shape;
mod model_exchange;
mod random_calls;
mod random_states;
mod random_threads;
mod smoke;
mod state;
mod state_events;
mod threads;
mod times;
mod typed;
