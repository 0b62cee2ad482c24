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
//! Gauss-Seidel, and loops are solved instead of held (see `iterate`).
//!
//! Initialization: in initialization mode values are passed on in the same order, again and again
//! until none changes, at most as often as there are components (plus one).

mod converting_slave;
mod engine;
mod exchange_slave;
mod fmu_slave;
mod function_slave;
mod group;
mod iterate;
mod newton;
mod plan;
mod signal_slave;
mod slave;

pub use slave::Slave;

use crate::error::Result;
use crate::fmi::InterfaceType;
use crate::observe::{Observer, RunInfo, Stop};
use crate::system::{Model, System};
use crate::time::Time;
use converting_slave::ConvertingSlave;
use engine::Engine;
use exchange_slave::ExchangeSlave;
use fmu_slave::FmuSlave;
use function_slave::FunctionSlave;
use plan::Plan;
use signal_slave::SignalSlave;

/// What a run did.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Steps of all components together.
    pub steps: u64,
    /// Simulated seconds.
    pub simulated: f64,
    /// Why it ended before the stop time, if it did.
    pub stopped: Option<Stop>,
    /// What is odd but did not end the run.
    pub warnings: Vec<String>,
    /// What is good to know: the iterations that loops needed.
    pub notes: Vec<String>,
    /// What the components logged, `component: message`.
    pub messages: Vec<String>,
}

impl System {
    /// Runs from start to stop. Observers keep what they got when the run fails.
    pub fn run(&self, observers: &mut [&mut dyn Observer]) -> Result<Summary> {
        let info = RunInfo {
            name: self.name(),
            columns: self.columns(),
            start: self.start_time(),
            stop: self.stop_time(),
            output_interval: self.output_interval(),
        };
        let mut engine = self.engine()?;
        let run = (|| {
            for observer in observers.iter_mut() {
                observer.start(&info)?;
            }
            self.drive(&mut engine, observers)
        })();
        let mut finished = Ok(());
        for observer in observers.iter_mut() {
            finished = finished.and(observer.finish());
        }
        // The reason why a run ended comes before what happened while closing files.
        let (end, stopped) = run?;
        finished?;
        Ok(Summary {
            steps: engine.steps(),
            simulated: (end - self.start_time()).seconds(),
            stopped,
            warnings: engine.warnings().iter().cloned().chain(self.unsolved(&engine)).collect(),
            notes: self.solved(&engine),
            messages: self.named(engine.messages()),
        })
    }

    /// The effort for each loop that was solved by iteration.
    fn solved(&self, engine: &Engine) -> Vec<String> {
        let loops = self.solved_loops().zip(&engine.efforts);
        let told = loops.filter(|(_, effort)| effort.solved > 0).map(|(found, effort)| {
            let mean = effort.passes as f64 / effort.solved as f64;
            format!("loop through {}: {mean:.1} passes per solution", self.members(found))
        });
        told.collect()
    }

    /// The loops that did not converge.
    fn unsolved(&self, engine: &Engine) -> Vec<String> {
        let loops = self.solved_loops().zip(&engine.efforts);
        let told = loops.filter(|(_, effort)| effort.failed > 0).map(|(found, effort)| {
            format!(
                "loop through {}: {} of {} iterations did not converge, the first at t = {} with \
                 the residual {:.1e}",
                self.members(found),
                effort.failed,
                effort.solved,
                effort.first,
                effort.residual
            )
        });
        told.collect()
    }

    fn named(&self, messages: Vec<Vec<String>>) -> Vec<String> {
        let all = self.components().iter().zip(messages);
        all.flat_map(|(c, lines)| lines.into_iter().map(move |l| format!("{}: {l}", c.name)))
            .collect()
    }

    fn engine(&self) -> Result<Engine> {
        let plan = Plan::new(self);
        let mut slaves: Vec<Box<dyn Slave>> = Vec::with_capacity(plan.nodes.len());
        for (position, (component, node)) in self.components().iter().zip(&plan.nodes).enumerate() {
            let slave: Box<dyn Slave> = match &component.model {
                Model::Fmu(fmu) if component.interface == InterfaceType::ModelExchange => {
                    let (solver, logging) = (self.solver(), self.debug_logging());
                    Box::new(ExchangeSlave::new(component, fmu, node, solver, logging)?)
                }
                Model::Fmu(fmu) => {
                    Box::new(FmuSlave::new(component, fmu, node, self.debug_logging())?)
                }
                Model::Signals(signals) => Box::new(SignalSlave::new(signals, node)),
                Model::Function(function) => Box::new(FunctionSlave::new(function, node)),
            };
            slaves.push(ConvertingSlave::around(slave, self, position, node));
        }
        Ok(Engine::new(plan, slaves, self.start_time()))
    }

    /// Where the run ended, and why when that was before the stop time.
    fn drive(
        &self,
        engine: &mut Engine,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(Time, Option<Stop>)> {
        engine.initialize(self.stop_time())?;
        let mut row = vec![0.0; self.columns().len()];
        let mut output = self.start_time();
        loop {
            engine.run_until(output)?;
            engine.sample(&mut row)?;
            for observer in observers.iter_mut() {
                observer.sample(output, &row)?;
            }
            let next = output + self.output_interval();
            if next > self.stop_time() {
                break;
            }
            if let Some(reason) = observers.iter().find_map(|observer| observer.stop()) {
                return Ok((output, Some(reason)));
            }
            output = next;
        }
        self.rest(engine, output)?;
        Ok((self.stop_time(), None))
    }

    /// The part after the last output instant, when the interval does not divide the run.
    fn rest(&self, engine: &mut Engine, output: Time) -> Result<()> {
        if output < self.stop_time() { engine.run_until(self.stop_time()) } else { Ok(()) }
    }
}
