//! Components that compute at each sample instant and hold the result until the next: sensors,
//! filters, controllers.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{
    Component, Fault, Info, NoStates, ParameterError, Ports, Resources, Sampler, Time, Variables,
};

/// What a sampled component does; [`Sampled`] makes it a [`Component`].
///
/// ```
/// use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Sampled, Time, Variables};
/// use serde::{Deserialize, Serialize};
///
/// #[derive(Clone, Copy, Debug, Default, Variables)]
/// struct Vehicle {
///     /// Depth of the vehicle
///     #[var(unit = "m")]
///     z: f64,
/// }
///
/// #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
/// struct Measured {
///     /// Depth measured
///     #[var(unit = "m")]
///     depth: f64,
/// }
///
/// struct DepthSensor;
///
/// impl Sample for DepthSensor {
///     const INFO: Info = Info::new("DepthSensor", "Depth, rounded to centimetres, ten times a second");
///     type Parameters = ();
///     type Inputs = Vehicle;
///     type Outputs = Measured;
///     type Memory = ();
///
///     fn new(_: &(), _: &Resources) -> Result<Self, ParameterError> {
///         Ok(Self)
///     }
///     fn period_s(&self) -> f64 {
///         0.1
///     }
///     fn memory(&self) {}
///     fn sample(&self, _: Time, _: &mut (), u: &Vehicle, y: &mut Measured) -> Result<(), Fault> {
///         y.depth = (u.z * 100.0).round() / 100.0;
///         Ok(())
///     }
/// }
///
/// fmu_kit::export!(Sampled<DepthSensor>);
/// # fn main() {
/// #     let text = REGISTRY.named("DepthSensor").unwrap().describe().unwrap();
/// #     assert!(text.contains("name=\"depth\"") && text.contains("discrete"));
/// # }
/// ```
pub trait Sample: Sized + Send + 'static {
    /// Name, description, default experiment; [`Info::sampled`] is set by [`Sampled`].
    const INFO: Info;
    /// See [`Component::ANY_INPUT`].
    const ANY_INPUT: bool = false;
    /// See [`Component::ROOM`].
    const ROOM: usize = 32 << 10;
    /// Parameters.
    type Parameters: Variables + Default;
    /// Inputs.
    type Inputs: Ports;
    /// Outputs, held between the instants.
    type Outputs: Ports + Serialize + DeserializeOwned;
    /// Everything else that changes: random numbers, filter state.
    type Memory: Clone + Default + Send + Serialize + DeserializeOwned + 'static;

    /// See [`Component::preset`].
    fn preset(selected: &Self::Parameters) -> Self::Parameters {
        let _ = selected;
        Self::Parameters::default()
    }

    /// Checks the parameters and derives constants from them.
    ///
    /// # Errors
    /// As for [`Component::new`].
    fn new(parameters: &Self::Parameters, resources: &Resources) -> Result<Self, ParameterError>;

    /// Time between two samples (s), the same throughout a simulation. The first sample is taken
    /// at the start, in initialization.
    fn period_s(&self) -> f64;

    /// The memory before the first sample.
    fn memory(&self) -> Self::Memory;

    /// Takes one sample: `outputs` contains the values held so far, and the values left in it are
    /// held until the next instant.
    ///
    /// # Errors
    /// As for [`Component::event`].
    fn sample(
        &self,
        now: Time,
        memory: &mut Self::Memory,
        inputs: &Self::Inputs,
        outputs: &mut Self::Outputs,
    ) -> Result<(), Fault>;

    /// See [`Component::notice`].
    fn notice(memory: &mut Self::Memory) -> Option<String> {
        let _ = memory;
        None
    }
}

/// A component made of a [`Sample`].
#[derive(Debug)]
pub struct Sampled<S>(S);

/// The memory of a [`Sampled`] component: its clock, the held outputs, and the memory of the
/// [`Sample`] itself.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Held<M, Y> {
    sampler: Sampler,
    memory: M,
    outputs: Y,
}

impl<M: Clone, Y: Copy> Clone for Held<M, Y> {
    fn clone(&self) -> Self {
        Self { memory: self.memory.clone(), ..*self }
    }

    /// Directly into its place, without an intermediate copy, because states are saved by this.
    #[inline]
    fn clone_from(&mut self, from: &Self) {
        self.memory.clone_from(&from.memory);
        (self.sampler, self.outputs) = (from.sampler, from.outputs);
    }
}

impl<S: Sample> Component for Sampled<S> {
    const INFO: Info = Info { sampled: true, ..S::INFO };
    const ANY_INPUT: bool = S::ANY_INPUT;
    const ROOM: usize = S::ROOM;
    type Parameters = S::Parameters;
    type Inputs = S::Inputs;
    type Outputs = S::Outputs;
    type States = NoStates;
    type Memory = Held<S::Memory, S::Outputs>;

    fn preset(selected: &S::Parameters) -> S::Parameters {
        S::preset(selected)
    }

    fn new(parameters: &S::Parameters, resources: &Resources) -> Result<Self, ParameterError> {
        S::new(parameters, resources).map(Self)
    }

    fn initial(&self, start: Time, inputs: &S::Inputs) -> Result<(NoStates, Self::Memory), Fault> {
        let mut memory = self.0.memory();
        let mut outputs = S::Outputs::default();
        self.0.sample(start, &mut memory, inputs, &mut outputs)?;
        let sampler = Sampler::new(start, self.0.period_s());
        Ok(((), Held { sampler, memory, outputs }))
    }

    fn outputs(&self, _: f64, held: &Self::Memory, _: &NoStates, _: &S::Inputs) -> S::Outputs {
        held.outputs
    }

    fn next_event(&self, held: &Self::Memory) -> Option<Time> {
        Some(held.sampler.next())
    }

    fn event(
        &self,
        now: Time,
        held: &mut Self::Memory,
        _: &mut NoStates,
        inputs: &S::Inputs,
    ) -> Result<(), Fault> {
        held.sampler.advance();
        self.0.sample(now, &mut held.memory, inputs, &mut held.outputs)
    }

    fn notice(held: &mut Self::Memory) -> Option<String> {
        S::notice(&mut held.memory)
    }
}
