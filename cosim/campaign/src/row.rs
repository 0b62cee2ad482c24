//! The stored result of a run.

use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use cosim_base::hexadecimal;

/// A run as a row of the results, compact because a campaign has many. Numbers are stored as texts
/// that read back to the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its number.
    pub run: u64,
    /// How it ended.
    pub status: Status,
    /// Why it has no figures, or what ended it early; empty otherwise.
    pub reason: Box<str>,
    /// The values of the parameters of the file's factors, list and dispersions.
    pub inputs: Box<[Box<str>]>,
    /// Simulated time (s); NaN if it failed.
    pub simulated: Number,
    /// The figures of merit, in alphabetical order.
    pub figures: Box<[Number]>,
    /// The digest of everything that was recorded for the figures.
    pub digest: RowDigest,
    /// The processor time that it took (ms).
    pub cpu_ms: Number,
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
    /// All of them, in order.
    pub(super) const ALL: [Self; 4] = [Self::Ok, Self::Failed, Self::Crashed, Self::TimedOut];

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
    pub fn without_figures(run: u64, status: Status, reason: impl Into<Box<str>>) -> Self {
        Self {
            run,
            status,
            reason: reason.into(),
            inputs: Box::default(),
            simulated: Number(f64::NAN),
            figures: Box::default(),
            digest: RowDigest::default(),
            cpu_ms: Number(f64::NAN),
        }
    }

    /// Whether two rows are the same except for the time that the run took.
    pub fn agrees(&self, other: &Self) -> bool {
        *self == Self { cpu_ms: self.cpu_ms, ..other.clone() }
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

/// An empty text is NaN.
impl FromStr for Number {
    type Err = std::num::ParseFloatError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text.is_empty() { Ok(Self(f64::NAN)) } else { text.parse().map(Self) }
    }
}

/// The SHA-256 digest of a run in hexadecimal digits; an empty text for a run without results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RowDigest(Option<[u8; 32]>);

impl RowDigest {
    /// Whether the run has no results.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }
}

impl From<[u8; 32]> for RowDigest {
    fn from(octets: [u8; 32]) -> Self {
        Self(Some(octets))
    }
}

impl fmt::Display for RowDigest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |octets| f.write_str(&hexadecimal(&octets)))
    }
}

impl FromStr for RowDigest {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const WRONG: &str = "a digest has 64 hexadecimal digits";
        if text.is_empty() {
            return Ok(Self(None));
        }
        let digit = |digit: u8| match digit {
            b'0'..=b'9' => Ok(digit - b'0'),
            b'a'..=b'f' => Ok(digit - b'a' + 10),
            b'A'..=b'F' => Ok(digit - b'A' + 10),
            _ => Err(WRONG),
        };
        let digits: &[u8; 64] = text.as_bytes().try_into().map_err(|_| WRONG)?;
        let mut octets = [0; 32];
        for (octet, pair) in octets.iter_mut().zip(digits.chunks_exact(2)) {
            *octet = 16 * digit(pair[0])? + digit(pair[1])?;
        }
        Ok(Self(Some(octets)))
    }
}

/// Stores a type as the text that it displays and is parsed from.
macro_rules! stored_as_text {
    ($($type:ty),*) => {$(
        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_str(Parsed(PhantomData))
            }
        }
    )*};
}
stored_as_text!(Number, RowDigest);

/// Parses a text.
struct Parsed<T>(PhantomData<T>);

impl<T: FromStr<Err: fmt::Display>> de::Visitor<'_> for Parsed<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a text")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<T, E> {
        text.parse().map_err(E::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_reads_back_as_it_was_written() {
        let mut row = Row::without_figures(7, Status::Ok, "ended when x > 1");
        (row.simulated, row.cpu_ms) = (Number(0.1 + 0.2), Number(1.5));
        row.figures = [Number(f64::INFINITY), Number(f64::NAN), Number(-0.0)].into();
        row.inputs = ["1.50".into(), "a \"b\"".into()].into();
        row.digest = [0xa7; 32].into();
        for row in [row, Row::without_figures(8, Status::Crashed, "")] {
            let text = serde_json::to_string(&row).unwrap();
            assert_eq!(serde_json::from_str::<Row>(&text).unwrap(), row, "{text}");
        }
        let digest: RowDigest = "0f".repeat(32).parse().unwrap();
        assert_eq!(digest.to_string(), "0f".repeat(32));
        assert!(
            "0g".repeat(32).parse::<RowDigest>().is_err() && "0f".parse::<RowDigest>().is_err()
        );
    }
}
