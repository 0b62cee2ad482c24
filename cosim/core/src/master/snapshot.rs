//! The state of a complete running system as a file, from which a run can continue.
//!
//! A file contains the magic text, the version, a SHA-256 of the rest, and the rest in postcard
//! encoding: the instant, the identity of the system, the state of the scheduler between two
//! instants, and the state of every component as it serialized it. The identity is text, so that a
//! snapshot of another system is refused with the first difference.

use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::engine::Engine;
use super::patched_slave::Patches;
use super::plan::{Node, Plan};
use super::trend::{Ramp, Trend};
use crate::system::{Model, System};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files;
use cosim_base::time::Time;
use cosim_import::Scalar;

const MAGIC: &[u8; 8] = b"COSIMSNP";
const VERSION: u32 = 5;
const HEADER: usize = 8 + 4 + 32;

/// A running system at one instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    time: Time,
    identity: Vec<String>,
    state: EngineState,
}

/// The state of the scheduler between two instants, and the states of the components.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EngineState {
    /// What components have put out.
    pub values: Vec<Scalar>,
    /// Their inputs.
    pub inputs: Vec<Scalar>,
    /// The Strings among the values, then those among the inputs.
    pub texts: Vec<String>,
    /// Where the last step of each component ended.
    pub ends: Vec<Time>,
    /// How inputs continue during steps.
    pub trends: Vec<Trend>,
    /// The slopes of inputs during steps.
    pub ramps: Vec<Ramp>,
    /// The step that the error control tries next.
    pub step: Option<Time>,
    /// The states of the components.
    pub components: Vec<Saved>,
}

/// A component's state.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    state: Vec<u8>,
    /// Its manipulations.
    patches: Patches,
}

impl Snapshot {
    /// The instant.
    pub fn time(&self) -> Time {
        self.time
    }

    /// For a system whose state at `time` is known.
    pub(crate) fn new(system: &System, time: Time, state: EngineState) -> Result<Self> {
        Ok(Self { time, identity: system.identity()?, state })
    }

    pub(crate) fn state(&self) -> &EngineState {
        &self.state
    }

    /// Writes a file, replacing an existing one as a whole: after a power loss, either the old one
    /// or the new one is there.
    pub fn write(&self, file: impl AsRef<Path>) -> Result<()> {
        let file = file.as_ref();
        let unwritten = |why: String| {
            Error::new(Code::Output, "the snapshot cannot be written").at(file).why(why)
        };
        let body = postcard::to_stdvec(self).map_err(|e| unwritten(e.to_string()))?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(Sha256::digest(&body));
        bytes.extend(body);
        files::refuse_others(file, "the snapshot cannot be written", None)?;
        files::replace(file, &bytes).map_err(|e| unwritten(e.to_string()))
    }

    /// Reads a file that [`Snapshot::write`] wrote.
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let unread = |why: String| {
            Error::new(Code::Snapshot, "the snapshot cannot be read").at(file).why(why)
        };
        let bytes = std::fs::read(file).map_err(|e| unread(e.to_string()))?;
        if bytes.len() < HEADER || &bytes[..8] != MAGIC {
            return Err(unread("the file is not a snapshot of cosim".to_owned()));
        }
        let version = u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]);
        if version != VERSION {
            let why = format!("it is of version {version}, this cosim reads version {VERSION}");
            return Err(unread(why).help("run the system again from its start"));
        }
        if Sha256::digest(&bytes[HEADER..])[..] != bytes[12..HEADER] {
            return Err(unread(
                "its checksum is wrong: the file is truncated or damaged".to_owned(),
            ));
        }
        postcard::from_bytes(&bytes[HEADER..]).map_err(|e| unread(e.to_string()))
    }

    /// Fails with the first difference if this belongs to another system.
    pub fn check(&self, system: &System) -> Result<()> {
        let identity = system.identity()?;
        if self.identity == identity {
            return Ok(());
        }
        let length = identity.len().max(self.identity.len());
        let line = |lines: &[String], at: usize| {
            lines.get(at).map_or("nothing more".to_owned(), |line| format!("'{line}'"))
        };
        let at = (0..length).find(|&at| line(&self.identity, at) != line(&identity, at));
        let at = at.unwrap_or_default();
        Err(Error::new(Code::Snapshot, "the snapshot belongs to another system")
            .why(format!(
                "it has {}, the system has {}",
                line(&self.identity, at),
                line(&identity, at)
            ))
            .help("resume with the same files, start values, steps and algorithm as before"))
    }
}

impl System {
    /// Everything that determines how a run continues, as lines of text.
    fn identity(&self) -> Result<Vec<String>> {
        let mut lines = vec![
            format!("algorithm {}, {:?}", self.algorithm(), self.solver()),
            format!("tolerance {:?}", self.tolerance()),
            format!("step control {:?}", self.step_control()),
            format!("start {}", self.start_time()),
        ];
        for component in self.components() {
            let model = match &component.model {
                Model::Fmu(fmu) => {
                    format!("{:?} {}", component.interface, fmu.digest(component.interface)?)
                }
                Model::Signals(signals) => format!("signals {}", signals.digest()),
                Model::Function(f) => format!("sum of {} by {:?}", f.inputs(), f.dimension()),
            };
            lines.push(format!("component {} every {}: {model}", component.name, component.step));
            for (variable, value) in &component.start_values {
                let name = component.model.variable_name(*variable);
                lines.push(format!("{}.{name} = {value}", component.name));
            }
        }
        for (position, connection) in self.connections().iter().enumerate() {
            let (from, to) = (self.port_name(connection.from), self.port_name(connection.to));
            let linear = if self.is_linear(position) { ", linear" } else { "" };
            let conversion = connection.conversion.as_ref();
            let conversion = conversion.map_or(String::new(), |c| format!(", {c}"));
            lines.push(format!("connection {from} -> {to}{linear}{conversion}"));
        }
        // The order of recorded values determines where they are stored.
        lines.extend(self.columns().iter().map(|column| format!("column {}", column.name)));
        Ok(lines)
    }
}

impl EngineState {
    /// Fails if this cannot be a state at `time` of a run of this plan from `start`: the file was
    /// made by hand. A step that ended long ago would have to be followed by any number of steps.
    pub fn check(&self, plan: &Plan, start: Time, time: Time, controlled: bool) -> Result<()> {
        let strange = |why: &str| {
            Err(Error::new(Code::Snapshot, "the snapshot does not fit its own system")
                .why(format!("{why}: the file was made by hand"))
                .help("run the system again from its start"))
        };
        let fits = self.values.len() == plan.values
            && self.inputs.len() == plan.inputs
            && self.texts.len() == plan.value_texts.len() + plan.input_texts.len()
            && self.ends.len() == plan.nodes.len()
            && self.trends.len() == plan.trends.len()
            && self.ramps.len() == plan.ramps.len()
            && self.components.len() == plan.nodes.len();
        if !fits {
            return strange("it has a different number of values");
        }
        // A step may be a nanosecond longer than its rounded length.
        let current = |(end, node): (&Time, &Node)| {
            let rest = end.ns().saturating_sub(time.ns());
            rest >= 0 && rest <= node.step.rounded().ns().saturating_add(1)
        };
        // With error control, all components begin their steps together.
        let current = controlled || self.ends.iter().zip(&plan.nodes).all(current);
        if !current || time < start {
            return strange(&format!("its steps are not those of t = {time}"));
        }
        Ok(())
    }
}

impl Engine {
    /// The state after all steps that end now or before.
    pub fn save(&mut self) -> Result<EngineState> {
        let mut components = Vec::with_capacity(self.slaves.len());
        for (slave, patches) in self.slaves.iter_mut().zip(&self.patches) {
            let patches = patches.as_ref().map(|p| p.borrow().clone()).unwrap_or_default();
            components.push(Saved { state: slave.serialize()?, patches });
        }
        Ok(EngineState {
            values: self.values.clone(),
            inputs: self.inputs.clone(),
            texts: self.plan.texts(&self.values, &self.inputs),
            ends: self.paces.iter().map(|pace| pace.end).collect(),
            trends: self.trends.clone(),
            ramps: self.ramps.clone(),
            step: self.control.as_ref().map(|control| control.step),
            components,
        })
    }

    /// Continues from a state of the instant `time`, after an initialization.
    pub fn restore(&mut self, state: &EngineState, time: Time) -> Result<()> {
        state.check(&self.plan, self.start, time, self.control.is_some())?;
        self.values.clone_from(&state.values);
        self.inputs.clone_from(&state.inputs);
        self.plan.take_texts(&state.texts, &mut self.values, &mut self.inputs);
        for (component, &end) in state.ends.iter().enumerate() {
            self.ends_at(component, end);
            self.paces[component].read_at = Time::NEVER;
        }
        self.next = state.ends.iter().min().copied().unwrap_or(Time::NEVER);
        self.trends.clone_from(&state.trends);
        self.ramps.clone_from(&state.ramps);
        if let (Some(control), Some(step)) = (&mut self.control, state.step) {
            (control.now, control.step) = (time, step);
        }
        for (component, saved) in state.components.iter().enumerate() {
            self.slaves[component].deserialize(&saved.state, time)?;
            self.replace_patches(component, &saved.patches);
        }
        Ok(())
    }
}
