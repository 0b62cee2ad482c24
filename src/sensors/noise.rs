//! Noise: Gaussian numbers by Box and Muller from ChaCha8, and inertial sensor bias.
//!
//! White noise of density N gives samples of standard deviation `N sqrt(rate)`. The slow bias is a
//! first-order Gauss-Markov process driven by white noise of density b (the "random walk"), exact
//! at the sample instants: `b_k+1 = exp(-T/tau) b_k + b sqrt(tau/2 (1 - exp(-2T/tau))) n`. A
//! constant turn-on bias is drawn once.

use crate::ParameterError;
use crate::error::{non_negative, positive};
use core::f64::consts::TAU;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// ChaCha makes four blocks at a time: this many numbers of 64 bits.
const AHEAD: usize = 32;

/// Independent standard normal numbers; the same for the same seed and stream on any machine.
///
/// ChaCha counts, so where it is says everything, and that is what is serialized. The numbers made
/// ahead are plain data too: saving the state of a sensor is a copy of memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Position", into = "Position")]
pub struct Gaussian {
    position: Position,
    ahead: [u64; AHEAD],
}

/// How far a stream of random numbers has been used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Position {
    seed: u64,
    stream: u64,
    /// Uniform numbers drawn so far.
    drawn: u64,
    /// Box and Muller make two at a time; this is the one not yet used.
    spare: Option<f64>,
}

impl From<Gaussian> for Position {
    fn from(gaussian: Gaussian) -> Self {
        gaussian.position
    }
}

impl From<Position> for Gaussian {
    fn from(position: Position) -> Self {
        let last = position.drawn.saturating_sub(1);
        Self { position, ahead: position.numbers(last - last % AHEAD as u64) }
    }
}

impl Position {
    /// The numbers from the `begun`th on.
    fn numbers(&self, begun: u64) -> [u64; AHEAD] {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.stream);
        // It counts words of 32 bits.
        rng.set_word_pos(2 * u128::from(begun));
        core::array::from_fn(|_| rng.next_u64())
    }
}

impl Gaussian {
    /// Streams of one seed are independent of each other.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        Position { seed, stream, drawn: 0, spare: None }.into()
    }

    /// The next number.
    pub fn draw(&mut self) -> f64 {
        if let Some(spare) = self.position.spare.take() {
            return spare;
        }
        let radius = (-2.0 * libm::log(self.uniform())).sqrt();
        let (sin, cos) = libm::sincos(TAU * self.uniform());
        self.position.spare = Some(radius * sin);
        radius * cos
    }

    /// The next `N` numbers, each times `sigma`.
    pub(super) fn draw_vector<const N: usize>(&mut self, sigma: f64) -> [f64; N] {
        core::array::from_fn(|_| sigma * self.draw())
    }

    /// In the open interval (0, 1): the logarithm stays finite.
    fn uniform(&mut self) -> f64 {
        let position = &mut self.position;
        let place = (position.drawn % AHEAD as u64) as usize;
        if place == 0 && position.drawn > 0 {
            self.ahead = position.numbers(position.drawn);
        }
        position.drawn = position.drawn.wrapping_add(1);
        ((self.ahead[place] >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
}

impl Default for Gaussian {
    fn default() -> Self {
        Self::new(0, 0)
    }
}

/// Noise of an inertial instrument, alike for its three axes. U: the unit measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasNoise {
    /// Density of the white noise (U/sqrt(Hz)).
    pub noise_density: f64,
    /// Density of the white noise that drives the slow bias (U/s/sqrt(Hz)).
    pub random_walk: f64,
    /// Correlation time of the slow bias (s).
    pub correlation_time: f64,
    /// Standard deviation of the constant bias after switching on (U).
    pub turn_on_sigma: f64,
}

impl BiasNoise {
    pub(crate) fn check(&self, name: &str) -> Result<(), ParameterError> {
        non_negative(&format!("{name}.noise_density"), self.noise_density)?;
        non_negative(&format!("{name}.random_walk"), self.random_walk)?;
        positive(&format!("{name}.correlation_time"), self.correlation_time)?;
        non_negative(&format!("{name}.turn_on_sigma"), self.turn_on_sigma)
    }
}

/// A [`BiasNoise`] discretised for a sample period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BiasProcess {
    white_sigma: f64,
    decay: f64,
    drive_sigma: f64,
    turn_on_sigma: f64,
}

/// The state of a three-axis [`BiasProcess`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BiasMemory {
    noise: Gaussian,
    turn_on: [f64; 3],
    slow: [f64; 3],
}

impl BiasProcess {
    pub(super) fn new(p: &BiasNoise, rate_hz: f64) -> Self {
        let (period, tau) = (1.0 / rate_hz, p.correlation_time);
        let variance = -libm::expm1(-2.0 * period / tau) * 0.5 * tau;
        Self {
            white_sigma: p.noise_density * rate_hz.sqrt(),
            decay: libm::exp(-period / tau),
            drive_sigma: p.random_walk * variance.sqrt(),
            turn_on_sigma: p.turn_on_sigma,
        }
    }

    pub(super) fn memory(&self, seed: u64, stream: u64) -> BiasMemory {
        let mut noise = Gaussian::new(seed, stream);
        let turn_on = noise.draw_vector(self.turn_on_sigma);
        BiasMemory { noise, turn_on, slow: [0.0; 3] }
    }

    /// The error of the next sample.
    pub(super) fn sample(&self, memory: &mut BiasMemory) -> [f64; 3] {
        core::array::from_fn(|i| {
            let error = memory.turn_on[i] + memory.slow[i] + self.white_sigma * memory.noise.draw();
            memory.slow[i] = self.decay * memory.slow[i] + self.drive_sigma * memory.noise.draw();
            error
        })
    }
}
