//! Unknown disturbances that act on a vehicle from outside: gusts of force, the current, propellers
//! that push a little more or less than they should.
//!
//! Forces and moments are Ornstein-Uhlenbeck processes (stationary, first-order Gauss-Markov), and
//! the horizontal current adds a random walk to its mean; both are exact at the sample instants.

use crate::ParameterError;
use crate::axes;
use crate::error::declared;
use crate::sampling::Rate;
use crate::sensors::{Correlated, GaussMarkov, Gaussian, Stream};
use fmu_quantity::{Member, Variables};
use serde::{Deserialize, Serialize};

/// The loss of one thruster.
const LOSS: Member = Member::new("loss", "fraction of the thrust that is lost").unit("1");

/// Parameters of the disturbances.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct DisturbanceParameters {
    /// Samples a second
    #[var(unit = "Hz", min = 0.001, max = 1e6, start = 50.0)]
    pub rate_hz: f64,
    /// Seed of everything
    #[var(min = 0, start = 7)]
    pub seed: i32,
    /// Standard deviation of surge, sway and heave force
    #[var(unit = "N", min = 0.0, start = 20.0)]
    pub force_sigma: f64,
    /// Standard deviation of the yaw moment
    #[var(unit = "N.m", min = 0.0, start = 10.0)]
    pub moment_sigma: f64,
    /// Standard deviation of roll and pitch moment
    #[var(unit = "N.m", min = 0.0)]
    pub tilt_moment_sigma: f64,
    /// Correlation time of forces and moments
    #[var(unit = "s", min = 1e-6, start = 5.0)]
    pub correlation_time: f64,
    /// Current at the start
    #[var(elements = axes::NED_VELOCITY)]
    pub mean_current: [f64; 3],
    /// Density of the random walk of the current north and east
    #[var(unit = "m/(s2.Hz0.5)", min = 0.0, nominal = 0.001)]
    pub current_random_walk: f64,
    /// Standard deviation of the constant relative errors of the thrusts, drawn once
    #[var(unit = "1", min = 0.0, start = 0.03)]
    pub thrust_gain_sigma: f64,
}

/// The disturbances at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct DisturbanceSample {
    /// Force and moment about the centre of gravity, body frame
    #[var(elements = axes::WRENCH)]
    pub wrench: [f64; 6],
    /// Current of the water
    #[var(elements = axes::NED_VELOCITY)]
    pub current: [f64; 3],
    /// Thruster
    ///
    /// The loss is negative for additional thrust.
    #[var(rename = "thruster", each = LOSS)]
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
        declared(p)?;
        let rate = Rate::new(p.rate_hz)?;
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
        let stream = |stream| Gaussian::of(self.p.seed, stream);
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
