//! Navigation filters as components: cycles at a rate, and a line in the log when their health
//! changes.

use crate::navigation_estimate::{Outputs, number};
use crate::navigation_ports::Inputs;
use crate::parameter_error;
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::estimation::kalman::GATE;
use rexrov::estimation::{Estimate, Health, Navigation};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A filter with its parameters; [`Navigating`] makes it a component.
pub trait Navigator: Sized + Send + 'static {
    /// Name and description.
    const INFO: Info;
    /// Parameters.
    type Parameters: Variables + Default;
    /// The filter.
    type Filter: Navigation<Memory: Clone + Default + Send + Serialize + DeserializeOwned + 'static>
        + Send
        + 'static;

    /// See [`Sample::preset`].
    fn preset(selected: &Self::Parameters) -> Self::Parameters {
        let _ = selected;
        Self::Parameters::default()
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    fn filter(parameters: &Self::Parameters) -> Result<Self::Filter, ::rexrov::ParameterError>;

    /// Cycles a second (Hz).
    fn rate_hz(parameters: &Self::Parameters) -> f64;
}

/// A component made from a [`Navigator`].
pub struct Navigating<N: Navigator> {
    filter: N::Filter,
    period_s: f64,
}

/// The memory of the filter, its state of health, and what has been logged about it.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Held<M> {
    filter: M,
    now: Condition,
    logged: Condition,
    /// The sensor whose measurements contradict the estimate most, and its NIS over the limit.
    worst: u8,
    excess: f64,
}

/// A state of health: its number, and a bit for each thruster that has lost thrust.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Condition {
    health: u8,
    lost: u8,
}

impl<M: Clone> Clone for Held<M> {
    fn clone(&self) -> Self {
        Self { filter: self.filter.clone(), ..*self }
    }

    /// In place, because this is used to save states.
    fn clone_from(&mut self, from: &Self) {
        self.filter.clone_from(&from.filter);
        (self.now, self.logged) = (from.now, from.logged);
        (self.worst, self.excess) = (from.worst, from.excess);
    }
}

/// Fraction of lost thrust above which a thruster counts as lost.
const LOST: f64 = 0.1;
/// Degrees of freedom of each channel.
const SIZES: [usize; 5] = [2, 1, 1, 3, 2];
/// Channels in words.
const NAMES: [&str; 5] = ["roll and pitch", "heading", "depth", "velocity log", "fix"];

impl<M> Held<M> {
    fn look(&mut self, estimate: &Estimate) {
        let bits = estimate.loss.iter().enumerate().filter(|(_, loss)| **loss > LOST);
        let lost = bits.fold(0, |all, (i, _)| all | (1 << i));
        self.now = Condition { health: number(estimate.health), lost };
        if estimate.health == Health::Inconsistent && self.now != self.logged {
            (self.worst, self.excess) = (0, 0.0);
            for (i, (channel, size)) in (0..).zip(estimate.channels.iter().zip(SIZES)) {
                let excess = channel.nis / GATE.get(size - 1).copied().unwrap_or(f64::MAX);
                if excess > self.excess {
                    (self.worst, self.excess) = (i, excess);
                }
            }
        }
    }

    fn health_in_words(&self) -> String {
        match self.now.health {
            0 => "good again".to_owned(),
            1 => {
                "starved: neither velocity log nor fix; the error of the position grows".to_owned()
            }
            2 => format!(
                "inconsistent: most measurements of late contradict the estimate; {} has {:.1} times \
                 the innovation squared that chance allows once in a thousand",
                NAMES.get(usize::from(self.worst)).copied().unwrap_or_default(),
                self.excess
            ),
            _ => "diverged: the estimate was lost and begun again from the start values".to_owned(),
        }
    }

    fn thrusters_in_words(&self) -> String {
        let thrusters = |lost: bool| {
            let changed = self.now.lost ^ self.logged.lost;
            let those = (0..8)
                .filter(move |i| changed >> i & 1 == 1 && (self.now.lost >> i & 1 == 1) == lost);
            those.map(|i| format!("thruster[{i}]")).collect::<Vec<_>>().join(", ")
        };
        match (thrusters(true), thrusters(false)) {
            (lost, found) if found.is_empty() => format!("{lost} gives less thrust than it should"),
            (lost, found) if lost.is_empty() => format!("{found} gives its thrust again"),
            (lost, found) => {
                format!("{lost} gives less thrust than it should, {found} its own again")
            }
        }
    }
}

impl<N: Navigator> Sample for Navigating<N> {
    const INFO: Info = N::INFO;
    const ANY_INPUT: bool = true;
    // Its past, for late measurements.
    const ROOM: usize = 1 << 20;
    type Parameters = N::Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = Held<<N::Filter as Navigation>::Memory>;

    fn preset(selected: &N::Parameters) -> N::Parameters {
        N::preset(selected)
    }

    fn new(p: &N::Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let filter = N::filter(p).map_err(parameter_error)?;
        Ok(Self { filter, period_s: 1.0 / N::rate_hz(p) })
    }

    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn memory(&self) -> Self::Memory {
        Held { filter: self.filter.memory(), ..Held::default() }
    }

    fn sample(
        &self,
        now: Time,
        memory: &mut Self::Memory,
        u: &Inputs,
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let estimate = self.filter.update(&mut memory.filter, now.seconds(), &u.measurements());
        memory.look(&estimate);
        *y = Outputs::of(&estimate);
        Ok(())
    }

    fn notice(memory: &mut Self::Memory) -> Option<String> {
        if memory.now == memory.logged {
            return None;
        }
        let mut words = Vec::new();
        if memory.now.health != memory.logged.health {
            words.push(memory.health_in_words());
        }
        if memory.now.lost != memory.logged.lost {
            words.push(memory.thrusters_in_words());
        }
        memory.logged = memory.now;
        Some(format!("health: {}", words.join("; ")))
    }
}
