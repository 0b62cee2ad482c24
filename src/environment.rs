//! Unknown disturbances that act on a vehicle from outside: gusts of force, the current, propellers
//! that push a little more or less than they should.
//!
//! Forces and moments are Ornstein-Uhlenbeck processes (stationary, first-order Gauss-Markov), and
//! the horizontal current adds a random walk to its mean; both are exact at the sample instants.

use crate::ParameterError;
use crate::error::{each, finite, non_negative, positive};
use crate::sampling::Rate;
use crate::sensors::{Correlated, GaussMarkov, Gaussian, Stream};
use serde::{Deserialize, Serialize};

/// Parameters of the disturbances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisturbanceParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of all its random numbers.
    pub seed: u64,
    /// Standard deviation of surge, sway and heave force (N).
    pub force_sigma: f64,
    /// Standard deviation of the yaw moment (N.m).
    pub moment_sigma: f64,
    /// Standard deviation of roll and pitch moment (N.m).
    pub tilt_moment_sigma: f64,
    /// Correlation time of forces and moments (s).
    pub correlation_time: f64,
    /// Current at the start, NED (m/s).
    pub mean_current: [f64; 3],
    /// Density of the random walk of the current north and east (m/s/sqrt(s)).
    pub current_random_walk: f64,
    /// Standard deviation of the constant relative errors of the thrusts, drawn once.
    pub thrust_gain_sigma: f64,
}

impl Default for DisturbanceParameters {
    fn default() -> Self {
        Self {
            rate_hz: 50.0,
            seed: 7,
            force_sigma: 20.0,
            moment_sigma: 10.0,
            tilt_moment_sigma: 0.0,
            correlation_time: 5.0,
            mean_current: [0.0; 3],
            current_random_walk: 0.0,
            thrust_gain_sigma: 0.03,
        }
    }
}

/// The disturbances at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisturbanceSample {
    /// Forces and moments `[X, Y, Z, K, M, N]` about the centre of gravity, body (N, N.m).
    pub wrench: [f64; 6],
    /// Current, NED (m/s).
    pub current: [f64; 3],
    /// Fraction of the thrust lost, for each thruster; negative for additional thrust.
    pub thruster_loss: [f64; 8],
}

/// Noise generators and their present values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DisturbanceMemory {
    gusts: Gaussian,
    walk: Gaussian,
    wrench: [f64; 6],
    current: [f64; 3],
    thruster_loss: [f64; 8],
}

/// The disturbances, with their parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbance {
    /// How often they change.
    pub rate: Rate,
    p: DisturbanceParameters,
    wrench: [Correlated; 6],
    walk_sigma: f64,
}

impl Disturbance {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &DisturbanceParameters) -> Result<Self, ParameterError> {
        let rate = Rate::new(p.rate_hz)?;
        non_negative("force_sigma", p.force_sigma)?;
        non_negative("moment_sigma", p.moment_sigma)?;
        non_negative("tilt_moment_sigma", p.tilt_moment_sigma)?;
        positive("correlation_time", p.correlation_time)?;
        each("mean_current", &p.mean_current, finite)?;
        non_negative("current_random_walk", p.current_random_walk)?;
        non_negative("thrust_gain_sigma", p.thrust_gain_sigma)?;
        let process = |sigma| {
            Correlated::new(&GaussMarkov { sigma, correlation_time: p.correlation_time }, p.rate_hz)
        };
        let (force, tilt) = (process(p.force_sigma), process(p.tilt_moment_sigma));
        Ok(Self {
            rate,
            p: *p,
            wrench: [force, force, force, tilt, tilt, process(p.moment_sigma)],
            walk_sigma: p.current_random_walk * rate.period().sqrt(),
        })
    }

    /// The memory at the start.
    #[must_use]
    pub fn memory(&self) -> DisturbanceMemory {
        let stream = |stream| Gaussian::new(self.p.seed, stream);
        let mut gusts = stream(Stream::DisturbanceWrench);
        DisturbanceMemory {
            wrench: self.wrench.map(|process| process.first(&mut gusts)),
            gusts,
            walk: stream(Stream::DisturbanceCurrent),
            current: self.p.mean_current,
            thruster_loss: stream(Stream::DisturbanceThrust).draw_vector(-self.p.thrust_gain_sigma),
        }
    }

    /// The next sample.
    pub fn sample(&self, memory: &mut DisturbanceMemory) -> DisturbanceSample {
        let sample = DisturbanceSample {
            wrench: memory.wrench,
            current: memory.current,
            thruster_loss: memory.thruster_loss,
        };
        for (value, process) in memory.wrench.iter_mut().zip(&self.wrench) {
            *value = process.next(*value, &mut memory.gusts);
        }
        for value in &mut memory.current[..2] {
            *value += self.walk_sigma * memory.walk.draw();
        }
        sample
    }
}
