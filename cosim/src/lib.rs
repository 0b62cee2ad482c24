//! A co-simulation master for FMI 2.0.
//!
//! Loads FMUs (our solvers integrate those for model exchange), connects them according to an SSP
//! or OSP system description, steps them with a deterministic schedule in integer time, and records
//! the results. It knows FMI and these formats, but no particular component. The feature
//! `distributed` (on by default) adds runs over several processes and machines.
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
//! many runs, keep one and derive the others with [`System::with`].
//!
//! # Observers and manipulators
//!
//! An [`Observer`] gets the recorded values at each output instant and changes nothing; a
//! [`Manipulator`] decides when to act, and then overrides, biases or releases variables, or ends
//! the run. A [`Run`] combines them with a system, and optionally with a [`Snapshot`] to continue
//! from. The example `campaign` shows all of this:
//!
//! ```no_run
//! use cosim::{Controls, Manipulator, Overrides, Recording, Result, Run, System, Time};
//!
//! /// The GPS is off from 10 s on.
//! struct Fault(Option<Time>);
//!
//! impl Manipulator for Fault {
//!     fn next(&self) -> Option<Time> {
//!         self.0
//!     }
//!     fn act(&mut self, _: Time, controls: &mut Controls<'_>) -> Result<()> {
//!         self.0 = None;
//!         controls.set("gps.off", 1.0)
//!     }
//! }
//!
//! let system = System::load("vehicle.ssd", &Overrides::new())?;
//! let (mut results, mut fault) = (Recording::new(), Fault(Some(Time::from_seconds(10.0))));
//! let summary = Run::new(&system).observe(&mut results).manipulate(&mut fault).go()?;
//! results.write_csv("with_fault.csv")?;
//! # Ok::<(), cosim::Error>(())
//! ```
//!
//! Included: [`scenario::Scenario`] from a file, [`Pace`] for real time, [`observe::create`]
//! for results files.

pub mod live;

pub use cosim_base::{Code, Error, Result, Step, Time};
pub use cosim_base::{error, files, names, shown, texts, time, units, xml};
pub use cosim_campaign as campaign;
pub use cosim_confine as confine;
pub use cosim_core::{
    Algorithm, Controls, Input, Manipulator, Observer, Overrides, Overruns, Pace, Recording, Run,
    Snapshot, Summary, System,
};
pub use cosim_core::{hosted, master, scenario, system};
pub use cosim_import as fmi;
pub use cosim_import::{proxy, scripted};
#[cfg(feature = "distributed")]
pub use cosim_net as distributed;
#[cfg(feature = "distributed")]
pub use cosim_net::signature;
pub use cosim_pack as export;
pub use cosim_report as report;
pub use cosim_results::roles;

/// Observers of a run, and files of results.
pub mod observe {
    pub use cosim_core::observe::*;
    pub use cosim_results::*;
}

/// The code in the README, for the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
