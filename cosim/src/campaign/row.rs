//! The stored result of a run.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// A run as a row of the results. Numbers are stored as texts that read back to the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its number.
    pub run: u64,
    /// How it ended.
    pub status: Status,
    /// Why it has no figures, or what ended it early; empty otherwise.
    pub reason: String,
    /// The values of the parameters of the file's factors, list and dispersions.
    pub inputs: Vec<String>,
    /// Simulated time (s).
    pub simulated: String,
    /// The figures of merit, in alphabetical order.
    pub figures: Vec<Number>,
    /// The digest of everything that was recorded for the figures.
    pub digest: String,
    /// The processor time that it took (ms).
    pub cpu_ms: String,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// It was simulated.
    Ok,
    /// It failed with an error.
    Failed,
    /// The process that made it ended.
    Crashed,
    /// It took longer than its time limit.
    TimedOut,
}

impl Status {
    /// As a word.
    pub fn word(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Failed => "failed",
            Status::Crashed => "crashed",
            Status::TimedOut => "timed-out",
        }
    }
}

impl Row {
    /// For a run that failed.
    pub fn without_figures(run: u64, status: Status, reason: impl Into<String>) -> Self {
        Self {
            run,
            status,
            reason: reason.into(),
            inputs: Vec::new(),
            simulated: String::new(),
            figures: Vec::new(),
            digest: String::new(),
            cpu_ms: String::new(),
        }
    }

    /// Whether two rows are the same except for the time that the run took.
    pub fn agrees(&self, other: &Self) -> bool {
        *self == Self { cpu_ms: self.cpu_ms.clone(), ..other.clone() }
    }

    /// A figure by its position; NaN if there is none.
    pub(super) fn figure(&self, place: usize) -> f64 {
        self.figures.get(place).map_or(f64::NAN, |number| number.0)
    }
}

/// A number that is written as a text which reads back to the same bits. NaN is equal to NaN.
#[derive(Debug, Clone, Copy)]
pub struct Number(pub f64);

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits() || (self.0.is_nan() && other.0.is_nan())
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;
        impl de::Visitor<'_> for Text {
            type Value = Number;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number as a text")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Number, E> {
                text.parse().map(Number).map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Text)
    }
}
