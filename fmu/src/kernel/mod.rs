//! FMI 2.0 without its C: variable table, state machine, instances, stepper, description. Functions
//! are named without the prefix of the FMI version, which `fmu-standard` adds.
//!
//! | file | contents |
//! |---|---|
//! | `table`, `unit`, `values` | the variables of a component and the arrays they live in |
//! | `call`, `status`, `log` | calls accepted per state, failures, one line for each |
//! | `clock`, `envelope` | times from importers, saved states as bytes |
//! | `model`, `adapter`, `parameters` | the interface to the mathematics, and components behind it |
//! | `stepper`, `integrator`, `signal` | co-simulation: from event to event, between events, inputs |
//! | `instance`, `access`, `co_simulation`, `model_exchange`, `state`, `tangent` | the functions of FMI 2.0 |
//! | `served` | what the C interface serves: such an instance, or something else |
//! | `registry`, `description`, `documentation`, `dependencies`, `factors`, `perturbation` | the components of a library and their descriptions |

mod access;
mod adapter;
mod call;
mod clock;
mod co_simulation;
mod dependencies;
mod description;
mod documentation;
mod envelope;
mod factors;
mod instance;
mod integrator;
mod log;
mod memory;
mod model;
mod model_exchange;
mod parameters;
mod perturbation;
mod registry;
mod served;
mod shape;
mod signal;
mod state;
mod status;
mod stepper;
mod table;
mod tangent;
mod unit;
mod values;

pub use call::accepts;
pub use clock::{check_experiment, check_step, is_instant};
pub use envelope::{hand_out, seal, unseal};
pub use fmu_standard::{Call, Category, InterfaceType as Interface, Phase, Status};
pub use instance::Instance;
pub use integrator::{Integrator, IntegratorMethod};
pub use log::{Log, Sink};
pub use memory::{SPREAD, spare};
pub use model::{Cause, Events, Halt, Memory, Model};
pub use model_exchange::EventOutcome;
pub use registry::{Deferred, Entry, Registry, Shared};
pub use served::{Request, Served};
pub use signal::Slopes;
pub use state::State;
pub use status::Trouble;
pub use table::{Group, Layout, Table, TableError, Variable};
pub use values::{Explicit, Values};
