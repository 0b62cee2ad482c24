//! The master: one scheduler for all algorithms.
//!
//! A run is a sequence of instants, those at which some component's step ends. At each instant:
//!
//! 1. every component whose step ends there, in the order of the system, gets its *fresh* inputs
//!    (values of this instant), does its whole step, and its outputs become visible;
//! 2. every such component begins its next step: its *held* inputs are taken from the values of
//!    this instant and stay until its step ends.
//!
//! An algorithm is only data for this: the order, and which connections are fresh. Jacobi: none;
//! Gauss-Seidel: those to inputs with direct feed-through (see `system::order`). Iterative: as
//! Gauss-Seidel, and loops are solved instead of held (see `iterate`). Two things are independent
//! of it: inputs may be linear instead of constant during a step (`trend`), and the length of the
//! steps may follow a tolerance (`control`).
//!
//! Initialization: in initialization mode values are passed on in the same order, again and again
//! until none changes, at most as often as there are components (plus one).

mod control;
mod drive;
mod engine;
mod exchange_slave;
mod fmu_slave;
mod group;
mod iterate;
mod manipulate;
mod meter;
mod newton;
mod patched_slave;
mod plan;
mod run;
mod signal_slave;
mod slave;
mod snapshot;
mod summary;
mod trend;

pub(crate) use engine::{Engine, UNSETTLED, passes};
pub(crate) use drive::Drive;
pub(crate) use manipulate::Change;
pub(crate) use plan::{Node, Plan, Route};
pub(crate) use snapshot::{EngineState, Saved};
pub(crate) use summary::Report;

pub use manipulate::{Controls, Manipulator};
pub use run::Run;
pub use slave::{Slave, Step};
pub use snapshot::Snapshot;
pub use summary::{ComponentSummary, Summary};

use crate::error::Result;
use crate::fmi::{InterfaceType, Kind, Variability};
use crate::solver;
use crate::system::{Component, Model, System};
use serde::{Deserialize, Serialize};
use control::Control;
use exchange_slave::ExchangeSlave;
use fmu_slave::{Discards, FmuSlave};
use signal_slave::SignalSlave;

/// What all slaves of a system have in common.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Making {
    pub solver: solver::Settings,
    /// Whether the FMUs are asked for debug messages.
    pub logging: bool,
    /// How often a discarded step is made smaller.
    pub retries: u32,
    /// Whether steps have an error control.
    pub controlled: bool,
}

/// A component as a slave of this process.
pub(crate) fn slave(component: &Component, node: &Node, making: Making) -> Result<Box<dyn Slave>> {
    let Making { solver, logging, retries, controlled } = making;
    Ok(match &component.model {
        Model::Fmu(fmu) if component.interface == InterfaceType::ModelExchange => {
            Box::new(ExchangeSlave::new(component, fmu, node, solver, logging)?)
        }
        Model::Fmu(fmu) => {
            let discards = match controlled {
                true => Discards::Told,
                false if component.can_repeat(fmu) => Discards::Repeated(retries),
                false => Discards::Repeated(0),
            };
            Box::new(FmuSlave::new(component, fmu, node, discards, logging)?)
        }
        Model::Signals(signals) => Box::new(SignalSlave::new(signals, node)),
    })
}

impl System {
    fn engine(&self) -> Result<Engine> {
        let plan = Plan::new(self);
        let mut slaves: Vec<Box<dyn Slave>> = Vec::with_capacity(plan.nodes.len());
        for (component, node) in self.components().iter().zip(&plan.nodes) {
            slaves.push(slave(component, node, self.making())?);
        }
        let control = self.step_control().map(|tolerance| {
            let steps = plan.nodes.iter().map(|node| node.step);
            let largest = steps.min().unwrap_or(self.output_interval());
            let linear = !plan.ramps.is_empty();
            Control::new(tolerance, largest, self.start_time(), linear, self.nominals(&plan))
        });
        let mut engine = Engine::new(plan, slaves, self.start_time());
        engine.control = control;
        Ok(engine)
    }

    /// How the slaves of this system are made.
    pub(crate) fn making(&self) -> Making {
        Making {
            solver: self.solver(),
            logging: self.debug_logging(),
            retries: self.retries(),
            controlled: self.step_control().is_some(),
        }
    }

    /// The usual magnitudes of the connected outputs whose errors count: the continuous ones.
    fn nominals(&self, plan: &Plan) -> Vec<Option<f64>> {
        let mut nominals = vec![None; plan.values];
        for (component, node) in self.components().iter().zip(&plan.nodes) {
            let Model::Fmu(fmu) = &component.model else {
                continue;
            };
            for (&output, slot) in node.outputs.iter().zip(node.output_slots.clone()) {
                let variable = &fmu.description().variables[output];
                let counts =
                    variable.kind == Kind::Real && variable.variability == Variability::Continuous;
                nominals[slot] = counts.then_some(variable.nominal);
            }
        }
        nominals
    }
}
