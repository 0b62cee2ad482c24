//! A co-simulation master for FMI 2.0.
//!
//! Loads FMUs (those of model exchange get an integrator of ours), links them as an SSP or OSP system description says, steps them by a
//! deterministic schedule in integer time and records the results. It knows FMI and these formats,
//! and no component in particular.
//!
//! ```no_run
//! use cosim::{Overrides, Recording, System};
//!
//! let overrides = Overrides::new().start_value("gps.seed", 7).stop_time(60.0);
//! let system = System::load("vehicle.ssd", &overrides)?;
//! let mut recording = Recording::new();
//! system.run(&mut [&mut recording])?;
//! println!("{:?}", recording.column("plant.pose.x")?.last());
//! # Ok::<(), cosim::Error>(())
//! ```
//!
//! An FMU file is unpacked and mapped once per process while any [`System`] with it is alive: for
//! many runs keep one and derive the others by [`System::with`].

mod digest;
pub mod error;
pub mod fmi;
pub mod master;
pub mod names;
pub mod observe;
pub mod report;
pub mod signals;
pub mod solver;
pub mod system;
pub mod time;
pub mod units;
pub mod xml;

pub use error::{Code, Error, Result};
pub use master::{Controls, Manipulator, Run, Snapshot, Summary};
pub use observe::{Observer, Recording};
pub use system::{Algorithm, Input, Overrides, System};
pub use time::Time;
