//! The master: one scheduler for all algorithms.
//!
//! A run is a sequence of instants at which the step of some component ends. At each instant:
//!
//! 1. every component whose step ends there, in the order of the system, gets its *fresh* inputs
//!    (values of this instant), makes its whole step, and its outputs become visible;
//! 2. every such component begins its next step: its *held* inputs are taken from the values of
//!    this instant and stay constant until its step ends.
//!
//! An algorithm is only data for this: the order, and which connections are fresh. Jacobi: none;
//! Gauss-Seidel: those to inputs with direct feed-through (see `system::order`). Iterative: as
//! Gauss-Seidel, except that loops are solved instead of held (see `iterate`). Two options are
//! independent of it: inputs may be linear instead of constant during a step (`trend`), and the
//! length of the steps may follow a tolerance (`control`).
//!
//! Initialization: in initialization mode, values are passed on in the same order repeatedly until
//! none changes, at most as often as there are components (plus one).

mod control;
mod converting_slave;
mod direct;
mod drive;
mod engine;
mod exchange_slave;
mod fmu_slave;
mod function_slave;
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
mod start;
mod summary;
mod trend;

pub use converting_slave::Converted;
pub use drive::Drive;
pub use engine::{Engine, UNSETTLED, passes};
pub use plan::{Node, Plan, Route};
pub use snapshot::{EngineState, Saved};
pub use summary::{Report, Tally};

pub use manipulate::{Change, Controls, Manipulator};
pub use run::Run;
pub use slave::Slave;
pub use snapshot::Snapshot;
pub use summary::{ComponentSummary, Summary};

use crate::solver;
use crate::system::{Component, Model, System};
use control::Control;
use converting_slave::ConvertingSlave;
use cosim_base::error::Result;
use cosim_base::time::Time;
use cosim_import::{InterfaceType, Kind, Logging, Variability, guard};
use exchange_slave::ExchangeSlave;
use fmu_slave::{Discards, FmuSlave};
use function_slave::FunctionSlave;
use patched_slave::SharedPatches;
use serde::{Deserialize, Serialize};
use signal_slave::SignalSlave;

/// Settings shared by all slaves of a system.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Making {
    /// How model exchange is integrated.
    pub solver: solver::Settings,
    /// The tolerance for FMUs that step themselves, instead of what they suggest.
    pub tolerance: Option<f64>,
    /// Whether debug messages are requested from the FMUs, and of which categories.
    pub debug: bool,
    /// The categories that are logged.
    pub categories: Vec<String>,
    /// How often a discarded step is made smaller.
    pub retries: u32,
    /// Whether steps are under error control.
    pub controlled: bool,
}

/// A slave, and the manipulations of its values if it already has them.
pub(crate) type Made = (Box<dyn Slave>, Option<SharedPatches>);

/// A component as a slave of this process, behind the conversions of its inputs.
pub fn slave(
    component: &Component,
    node: &Node,
    converted: Vec<Converted>,
    making: &Making,
    logging: &Logging,
) -> Result<Made> {
    let slave: Box<dyn Slave> = match &component.model {
        Model::Fmu(fmu) if component.interface == InterfaceType::ModelExchange => {
            Box::new(ExchangeSlave::new(component, fmu, node, making.solver, logging)?)
        }
        Model::Fmu(fmu) => {
            let discards = match making.controlled {
                true => Discards::Reported,
                false if component.can_repeat(fmu) => Discards::Repeated(making.retries),
                false => Discards::Final,
            };
            let tolerance = making.tolerance;
            Box::new(FmuSlave::new(component, fmu, node, discards, tolerance, logging)?)
        }
        Model::Signals(signals) => Box::new(SignalSlave::new(signals, node)),
        Model::Function(function) => Box::new(FunctionSlave::new(function, node)),
    };
    Ok(ConvertingSlave::around(slave, converted, node))
}

impl System {
    fn engine(&self) -> Result<Engine> {
        self.engine_of(self.components(), self.start_time(), &self.making())
    }

    /// An engine that begins at `start`, with these components instead of the system's own, from
    /// which they differ in their start values.
    pub(crate) fn engine_of(
        &self,
        components: &[Component],
        start: Time,
        making: &Making,
    ) -> Result<Engine> {
        let fmus = components.iter().filter_map(|c| Some((c.name.as_str(), c.fmu()?)));
        self.logging().check(fmus)?;
        guard::begin();
        let plan = Plan::new(self);
        let mut made = Vec::with_capacity(plan.nodes.len());
        for (position, (component, node)) in components.iter().zip(&plan.nodes).enumerate() {
            let converted = self.converted(position, node);
            made.push(slave(component, node, converted, making, self.logging())?);
        }
        let control = self.step_control().map(|tolerance| {
            let steps = plan.nodes.iter().map(|node| node.step);
            let largest = steps.min().unwrap_or(self.output_interval()).rounded();
            let linear = !plan.ramps.is_empty();
            Control::new(tolerance, largest, start, linear, self.nominals(&plan))
        });
        let mut engine = Engine::new(plan, made, start);
        engine.control = control;
        Ok(engine)
    }

    /// The settings for the slaves of this system.
    pub fn making(&self) -> Making {
        Making {
            solver: self.solver(),
            tolerance: self.tolerance(),
            debug: self.logging().debug,
            categories: self.logging().categories.clone(),
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
