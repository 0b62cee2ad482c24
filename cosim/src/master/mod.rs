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
mod converting_slave;
mod direct;
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
mod summary;
mod trend;

pub use manipulate::{Controls, Manipulator};
pub use run::Run;
pub use slave::Slave;
pub use snapshot::Snapshot;
pub use summary::{ComponentSummary, Summary};

use crate::error::Result;
use crate::fmi::{InterfaceType, Kind, Variability};
use crate::system::{Component, Model, System};
use control::Control;
use converting_slave::ConvertingSlave;
use engine::Engine;
use exchange_slave::ExchangeSlave;
use fmu_slave::{Discards, FmuSlave};
use function_slave::FunctionSlave;
use plan::{Node, Plan};
use signal_slave::SignalSlave;

impl System {
    fn engine(&self) -> Result<Engine> {
        let fmus = self.components().iter().filter_map(|c| Some((c.name.as_str(), c.fmu()?)));
        self.logging().check(fmus)?;
        let plan = Plan::new(self);
        let mut slaves: Vec<Box<dyn Slave>> = Vec::with_capacity(plan.nodes.len());
        let mut patches = Vec::with_capacity(plan.nodes.len());
        for (position, (component, node)) in self.components().iter().zip(&plan.nodes).enumerate() {
            let slave = self.slave(component, node)?;
            let (slave, shared) = ConvertingSlave::around(slave, self, position, node);
            slaves.push(slave);
            patches.push(shared);
        }
        let control = self.step_control().map(|tolerance| {
            let steps = plan.nodes.iter().map(|node| node.step);
            let largest = steps.min().unwrap_or(self.output_interval());
            let linear = !plan.ramps.is_empty();
            Control::new(tolerance, largest, self.start_time(), linear, self.nominals(&plan))
        });
        let mut engine = Engine::new(plan, slaves, self.start_time());
        engine.control = control;
        engine.patches = patches;
        Ok(engine)
    }

    fn slave(&self, component: &Component, node: &Node) -> Result<Box<dyn Slave>> {
        Ok(match &component.model {
            Model::Fmu(fmu) if component.interface == InterfaceType::ModelExchange => {
                let (solver, logging) = (self.solver(), self.logging());
                Box::new(ExchangeSlave::new(component, fmu, node, solver, logging)?)
            }
            Model::Fmu(fmu) => {
                let discards = match self.step_control() {
                    Some(_) => Discards::Told,
                    None if component.can_repeat(fmu) => Discards::Repeated(self.retries()),
                    None => Discards::Final,
                };
                Box::new(FmuSlave::new(component, fmu, node, discards, self.logging())?)
            }
            Model::Signals(signals) => Box::new(SignalSlave::new(signals, node)),
            Model::Function(function) => Box::new(FunctionSlave::new(function, node)),
        })
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
