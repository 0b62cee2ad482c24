//! What a host needs to know to compute a group.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::check::check_variables;
use super::layout::Group;
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::{Step, Time};
use cosim_core::master::{Converted, Engine, EngineState, Making, Plan, Tally, slave};
use cosim_core::system::Signals;
use cosim_core::system::{Component, Function, Model};
use cosim_import::{Fmu, InterfaceType, LastCall, Logging, Value, guard};

/// A group to be made, from its start or from a state.
#[derive(Serialize, Deserialize)]
pub(crate) struct Setup {
    /// The plan of these components alone; its positions are those of `components`.
    pub plan: Plan,
    /// With the same positions.
    pub group: Group,
    /// The components to make.
    pub components: Vec<Blueprint>,
    /// What they have in common.
    pub making: Making,
    /// First instant of the run.
    pub start: Time,
    /// Last instant.
    pub stop: Time,
    /// The state to continue from, with its time and the counters until then.
    pub state: Option<(Time, EngineState, Tally)>,
}

/// A component to be made.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Blueprint {
    /// Name in the system.
    pub name: String,
    /// What computes it.
    pub source: Source,
    /// Whether it is driven by model exchange.
    pub model_exchange: bool,
    /// Communication step.
    pub step: Step,
    /// Start values by position of the variable.
    pub start_values: Vec<(usize, Value)>,
    /// Its inputs that are converted.
    pub converted: Vec<Converted>,
}

/// What computes a component.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) enum Source {
    /// An FMU, known by the hash of its file.
    Fmu(FmuFile),
    /// Signals, sent with the message.
    Signals(Signals),
    /// The sum of this many scalars, or of vectors of that dimension.
    Sum(usize, Option<usize>),
}

/// An FMU's file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FmuFile {
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
    /// Its name, for messages.
    pub name: String,
}

/// Where a host gets FMUs from.
pub(crate) trait FmuSource {
    /// Refuses an FMU that may not be loaded here.
    fn permit(&self, component: &str, file: &FmuFile) -> Result<()> {
        let _ = (component, file);
        Ok(())
    }

    /// The FMU of this hash.
    fn open(&mut self, file: &FmuFile) -> Result<Arc<Fmu>>;

    /// Where the last call is recorded for those who investigate a dead process.
    fn last_call(&self) -> Option<Arc<LastCall>> {
        None
    }
}

impl Setup {
    /// Makes the components, and restores the state if there is one; also returns the number of
    /// variables of each.
    pub(crate) fn build(self, fmus: &mut dyn FmuSource) -> Result<(Engine, Group, Vec<usize>)> {
        self.check()?;
        guard::begin();
        let (debug, categories) = (self.making.debug, self.making.categories.clone());
        // Messages are reported at the end; there is no live output here.
        let logging = Logging { debug, categories, last: fmus.last_call(), ..Logging::default() };
        // Before the first one is loaded: loading runs code.
        for blueprint in &self.components {
            if let Source::Fmu(file) = &blueprint.source {
                fmus.permit(&blueprint.name, file)?;
            }
        }
        let (mut slaves, mut variables) = (Vec::new(), Vec::new());
        for (blueprint, node) in self.components.into_iter().zip(&self.plan.nodes) {
            let model = match blueprint.source {
                Source::Fmu(file) => Model::Fmu(fmus.open(&file)?),
                Source::Signals(signals) => Model::Signals(Arc::new(signals)),
                Source::Sum(inputs, dimension) => {
                    let sum = Function::sum(&blueprint.name, inputs, dimension);
                    Model::Function(Arc::new(sum.ok_or_else(unusable)?))
                }
            };
            let component = Component {
                name: blueprint.name,
                model,
                file: None,
                interface: match blueprint.model_exchange {
                    true => InterfaceType::ModelExchange,
                    false => InterfaceType::CoSimulation,
                },
                step: blueprint.step,
                start_values: blueprint.start_values,
                worker: None,
            };
            check_variables(&component, node)?;
            variables.push(component.model.variables());
            slaves.push(slave(&component, node, blueprint.converted, &self.making, &logging)?);
        }
        let mut engine = Engine::new(self.plan, slaves, self.start);
        if let Some((time, state, tally)) = &self.state {
            // A state can only be restored after initialization, whose values do not matter.
            engine.enter(self.stop)?;
            engine.exit()?;
            engine.restore(state, *time)?;
            engine.count_from(tally);
        }
        Ok((engine, self.group, variables))
    }
}

/// Serializes a set-up; also returns the digest of its plan.
pub(crate) fn encode(setup: &Setup) -> Result<(Vec<u8>, u64)> {
    let tables = to_bytes(&(&setup.plan, &setup.group))?;
    let digest = Sha256::digest(&tables);
    let first = digest.first_chunk::<8>().copied().unwrap_or_default();
    Ok((to_bytes(setup)?, u64::from_le_bytes(first)))
}

/// The same set-up, continuing from a state.
pub(crate) fn with_state(
    setup: &[u8],
    time: Time,
    (state, tally): (EngineState, Tally),
) -> Result<Vec<u8>> {
    let mut setup: Setup = postcard::from_bytes(setup).map_err(|why| unusable().why(why))?;
    setup.state = Some((time, state, tally));
    to_bytes(&setup)
}

fn to_bytes<T: Serialize>(value: &T) -> Result<Vec<u8>> {
    postcard::to_stdvec(value).map_err(|why| unusable().why(why))
}

fn unusable() -> Error {
    Error::new(Code::Protocol, "a set-up cannot be serialized")
}
