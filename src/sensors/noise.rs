//! Gaussian numbers by Box and Muller from ChaCha8.

use super::Stream;
use core::f64::consts::TAU;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// ChaCha generates four blocks at a time: this many numbers of 64 bits.
const AHEAD: usize = 32;

/// Independent standard normal numbers; the same for the same seed and stream on any machine.
///
/// ChaCha is a counter, so its position defines its state, and only that is serialized. Numbers
/// generated ahead are plain data too: saving the state of a sensor is a copy of memory.
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
    /// Box and Muller generate two at a time; this is the one not yet used.
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
    /// The numbers starting with the `begun`th.
    fn numbers(&self, begun: u64) -> [u64; AHEAD] {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(self.stream);
        // It counts words of 32 bits.
        rng.set_word_pos(2 * u128::from(begun));
        core::array::from_fn(|_| rng.next_u64())
    }
}

impl Gaussian {
    /// Streams of one seed are independent of each other. Those of the instruments are [`Stream`]s;
    /// numbers from 1000 on are free for other uses.
    #[must_use]
    pub fn new(seed: u64, stream: impl Into<u64>) -> Self {
        Position { seed, stream: stream.into(), drawn: 0, spare: None }.into()
    }

    /// The same for a seed as it is declared, which is not negative.
    pub(crate) fn of(seed: i32, stream: Stream) -> Self {
        Self::new(u64::from(seed.unsigned_abs()), stream)
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

    /// Whether an event of this probability occurs.
    pub(crate) fn happens(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// The next `N` numbers, each times `sigma`.
    pub(crate) fn draw_vector<const N: usize>(&mut self, sigma: f64) -> [f64; N] {
        core::array::from_fn(|_| sigma * self.draw())
    }

    /// In the open interval (0, 1), so that the logarithm is finite.
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
        Self::new(0, 0_u64)
    }
}
