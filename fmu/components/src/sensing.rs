//! Sensors as components: samples at their instants, output after their latency.

use crate::instrument::Stamp;
use crate::parameter_error;
use fmu_kit::{
    Component, Fault, Info, NoStates, ParameterError, Ports, Resources, Sampler, Time, Variables,
};
use rexrov::sampling::Rate;
use rexrov::sensors::Instrument;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Maximum number of samples in transit.
const MOST_LATE: f64 = 64.0;

/// A sensor; [`Sensing`] makes it a component.
pub trait Sensor: Sized + Send + 'static {
    /// Name and description.
    const INFO: Info;
    /// Parameters.
    type Parameters: Variables + Default;
    /// Inputs.
    type Inputs: Ports;
    /// Outputs, with a [`Stamp`] among them.
    type Outputs: Ports + Serialize + DeserializeOwned;
    /// Random numbers, slow errors.
    type Memory: Clone + Default + Send + Serialize + DeserializeOwned + 'static;

    /// See [`Component::preset`].
    fn preset(selected: &Self::Parameters) -> Self::Parameters {
        let _ = selected;
        Self::Parameters::default()
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    fn new(parameters: &Self::Parameters) -> Result<Self, ::rexrov::ParameterError>;

    /// The common part of the parameters of all sensors.
    fn instrument(parameters: &Self::Parameters) -> &Instrument;

    /// How often it samples.
    fn rate(&self) -> Rate;

    /// The memory at switch-on.
    fn memory(&self) -> Self::Memory;

    /// Takes a sample, even while switched off, so that later noise stays the same; none if there
    /// is no output.
    fn sample(
        &self,
        stamp: Stamp,
        memory: &mut Self::Memory,
        inputs: &Self::Inputs,
    ) -> Option<Self::Outputs>;
}

/// A component made from a [`Sensor`]: a sample taken at t appears at t + latency, by a separate
/// event.
pub struct Sensing<S> {
    sensor: S,
    latency_ns: i64,
    places: usize,
}

/// The clock of a sensor, its memory, the sample it outputs and those in transit.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Held<M, Y> {
    sampler: Sampler,
    memory: M,
    shown: Y,
    late: Queue<Y>,
}

impl<M: Clone, Y: Copy> Clone for Held<M, Y> {
    fn clone(&self) -> Self {
        Self { memory: self.memory.clone(), late: self.late.clone(), ..*self }
    }

    /// Directly into its place, without an intermediate copy, because this is used to save states.
    #[inline]
    fn clone_from(&mut self, from: &Self) {
        self.memory.clone_from(&from.memory);
        self.late.clone_from(&from.late);
        (self.sampler, self.shown) = (from.sampler, from.shown);
    }
}

impl<S: Sensor> Sensing<S> {
    fn take(&self, now: Time, held: &mut Held<S::Memory, S::Outputs>, inputs: &S::Inputs) {
        let stamp = Stamp { stamp: now.seconds(), valid: 1.0 };
        let Some(sample) = self.sensor.sample(stamp, &mut held.memory, inputs) else {
            return;
        };
        if self.latency_ns == 0 {
            held.shown = sample;
        } else {
            held.late.push(now.after_ns(self.latency_ns), sample);
        }
    }
}

/// Places for the samples in transit.
fn places(instrument: &Instrument) -> Result<usize, ParameterError> {
    let Instrument { rate_hz, latency, .. } = *instrument;
    let samples = latency * rate_hz;
    if !(0.0..=MOST_LATE).contains(&samples) {
        let most = MOST_LATE / rate_hz;
        let reason = format!("{latency} s: at most {MOST_LATE} samples, here {most} s");
        return Err(ParameterError::new("latency", reason));
    }
    Ok(if samples > 0.0 { samples as usize + 2 } else { 0 })
}

impl<S: Sensor> Component for Sensing<S> {
    const INFO: Info = Info { sampled: true, ..S::INFO };
    type Parameters = S::Parameters;
    type Inputs = S::Inputs;
    type Outputs = S::Outputs;
    type States = NoStates;
    type Memory = Held<S::Memory, S::Outputs>;

    fn preset(selected: &S::Parameters) -> S::Parameters {
        S::preset(selected)
    }

    fn new(parameters: &S::Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let sensor = S::new(parameters).map_err(parameter_error)?;
        let instrument = S::instrument(parameters);
        let latency_ns = Time::from_seconds(instrument.latency).ns();
        Ok(Self { sensor, latency_ns, places: places(instrument)? })
    }

    fn initial(&self, start: Time, inputs: &S::Inputs) -> Result<(NoStates, Self::Memory), Fault> {
        let mut held = Held {
            sampler: Sampler::new(start, self.sensor.rate().period()),
            memory: self.sensor.memory(),
            shown: S::Outputs::default(),
            late: Queue::new(self.places),
        };
        self.take(start, &mut held, inputs);
        Ok(((), held))
    }

    fn outputs(&self, _: f64, held: &Self::Memory, _: &NoStates, _: &S::Inputs) -> S::Outputs {
        held.shown
    }

    fn next_event(&self, held: &Self::Memory) -> Option<Time> {
        let sample = held.sampler.next();
        Some(held.late.due().map_or(sample, |due| due.min(sample)))
    }

    fn event(
        &self,
        now: Time,
        held: &mut Self::Memory,
        _: &mut NoStates,
        inputs: &S::Inputs,
    ) -> Result<(), Fault> {
        while let Some(sample) = held.late.pop(now) {
            held.shown = sample;
        }
        if held.sampler.next() <= now {
            held.sampler.advance();
            self.take(now, held, inputs);
        }
        Ok(())
    }
}

/// Samples in transit, in places allocated once: a ring buffer.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Queue<Y> {
    places: Box<[(Time, Y)]>,
    first: usize,
    count: usize,
}

impl<Y: Copy> Clone for Queue<Y> {
    fn clone(&self) -> Self {
        Self { places: self.places.clone(), ..*self }
    }

    #[inline]
    fn clone_from(&mut self, from: &Self) {
        self.places.clone_from(&from.places);
        (self.first, self.count) = (from.first, from.count);
    }
}

impl<Y: Copy + Default> Queue<Y> {
    fn new(places: usize) -> Self {
        Self { places: vec![(Time::default(), Y::default()); places].into(), first: 0, count: 0 }
    }

    /// When the first one is due.
    fn due(&self) -> Option<Time> {
        (self.count > 0).then(|| self.places.get(self.first).map(|(due, _)| *due)).flatten()
    }

    /// Adds one; there are enough places for a latency of whole sample periods and a remainder.
    fn push(&mut self, due: Time, sample: Y) {
        let n = self.places.len().max(1);
        if let Some(place) = self.places.get_mut(self.first.wrapping_add(self.count) % n) {
            *place = (due, sample);
            self.count = self.count.saturating_add(1).min(n);
        }
    }

    /// Takes the first one if it is due.
    fn pop(&mut self, now: Time) -> Option<Y> {
        self.due().filter(|due| *due <= now)?;
        let (_, sample) = *self.places.get(self.first)?;
        self.first = (self.first + 1) % self.places.len().max(1);
        self.count -= 1;
        Some(sample)
    }
}
