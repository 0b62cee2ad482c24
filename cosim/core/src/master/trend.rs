//! Inputs that move during a step: linear instead of held (`Input::Linear`).
//!
//! A *trend* belongs to a source: its value at the end of its last step and its slope there, which
//! comes from the source (fmi2GetRealOutputDerivatives) or from the difference over its last step.
//! A *ramp* belongs to an input. A held input begins a step from t to t + h with the trend's value
//! at t and continues with its slope (extrapolation); a fresh one goes from its value at the end of
//! the last step to the source's value at t + h (interpolation). Both leave an error of order h^2
//! in the input, whereas holding leaves one of order h.

use serde::{Deserialize, Serialize};

use super::engine::Engine;
use cosim_base::error::Result;
use cosim_base::time::Time;
use cosim_import::Scalar;

/// The value of a source, its time, and its slope.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Trend {
    time: Time,
    value: f64,
    slope: f64,
}

/// An input at the start of its component's step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Ramp {
    value: f64,
    slope: f64,
}

impl Trend {
    fn at(&self, now: Time) -> f64 {
        self.value + self.slope * (now - self.time).seconds()
    }
}

impl Engine {
    /// Trends and ramps at the start: the slopes that sources know by then, otherwise 0.
    pub(super) fn begin_trends(&mut self) -> Result<()> {
        for c in 0..self.plan.nodes.len() {
            self.learn(c, self.start)?;
        }
        for c in 0..self.plan.nodes.len() {
            self.take_ramps(c, self.start);
        }
        Ok(())
    }

    /// After the last component of an instant: trends of the sources, then ramps of the inputs.
    pub(super) fn follow(&mut self, now: Time) -> Result<()> {
        for c in 0..self.plan.nodes.len() {
            if self.due(c, now) {
                self.learn(c, now)?;
            }
        }
        for c in 0..self.plan.nodes.len() {
            if self.due(c, now) {
                self.take_ramps(c, now);
            }
        }
        Ok(())
    }

    fn learn(&mut self, c: usize, now: Time) -> Result<()> {
        let node = &self.plan.nodes[c];
        if node.trends.is_empty() {
            return Ok(());
        }
        let mut slopes = vec![0.0; node.output_slots.len()];
        let known = self.slaves[c].slopes(&mut slopes)?;
        for &trend in &node.trends {
            let slot = self.plan.trends[trend];
            let (value, last) = (self.values[slot].as_real(), self.trends[trend]);
            let slope = if known {
                slopes[slot - node.output_slots.start]
            } else if now > self.start {
                (value - last.value) / (now - last.time).seconds()
            } else {
                0.0
            };
            self.trends[trend] = Trend { time: now, value, slope };
        }
        Ok(())
    }

    fn take_ramps(&mut self, c: usize, now: Time) {
        for &ramp in &self.plan.nodes[c].ramps {
            let trend = &self.trends[self.plan.ramps[ramp].trend];
            self.ramps[ramp] = Ramp { value: trend.at(now), slope: trend.slope };
        }
    }

    /// Sets the inputs of a component for its step that ends now.
    #[cold]
    pub(super) fn set_ramps(&mut self, c: usize, now: Time) -> Result<()> {
        let node = &self.plan.nodes[c];
        let first = node.input_slots.start;
        let mut values = self.inputs[node.input_slots.clone()].to_vec();
        let mut slopes = vec![0.0; values.len()];
        for &position in &node.ramps {
            let (way, ramp) = (&self.plan.ramps[position], self.ramps[position]);
            let place = way.input - first;
            slopes[place] = if way.fresh {
                let stepped = self.due(way.source, now);
                let trend = &self.trends[way.trend];
                let goal = if stepped { self.inputs[way.input].as_real() } else { trend.at(now) };
                (goal - ramp.value) / self.paces[c].length.seconds()
            } else {
                ramp.slope
            };
            values[place] = Scalar::real(ramp.value);
        }
        self.slaves[c].ramp(&values, &slopes)
    }
}
