//! Signals from a file, which drive otherwise unconnected inputs of an FMU.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use cosim_base::error::{Code, Error, Result};
use cosim_base::sha256;
use cosim_base::time::Time;
use cosim_import::{Kind, Scalar};

/// The numbers of a column, one per instant; of another column the first text that is none.
pub type Numbers<'a> = std::result::Result<Cow<'a, [f64]>, String>;

/// Values over a common time by name, as a file has them.
pub struct Table<'a> {
    /// Instants (s).
    pub time: &'a [f64],
    /// Names and values.
    pub columns: Vec<(&'a str, Numbers<'a>)>,
}

/// Signals over a common time.
#[derive(Clone, Serialize, Deserialize)]
pub struct Signals {
    time: Vec<f64>,
    names: Vec<String>,
    signals: Vec<Signal>,
}

/// One signal.
#[derive(Clone, Serialize, Deserialize)]
pub struct Signal {
    /// Name.
    pub name: String,
    /// Type.
    pub kind: Kind,
    /// Linear between samples; otherwise held.
    pub continuous: bool,
    /// One value per instant.
    pub values: Vec<f64>,
}

impl Signals {
    /// Signals over `time`, which must not decrease.
    pub fn new(time: &[f64], signals: Vec<Signal>) -> Result<Self> {
        let names = signals.iter().map(|s| s.name.clone()).collect();
        let signals = Self { time: time.to_vec(), names, signals };
        signals.check()?;
        Ok(signals)
    }

    /// Whether every signal has a value at every instant.
    pub fn check(&self) -> Result<()> {
        let wrong = |what: String| Err(Error::new(Code::Results, what));
        let (time, signals) = (&self.time, &self.signals);
        if time.is_empty() {
            return wrong("the signals have no samples".to_owned());
        }
        if let Some(late) = time.windows(2).position(|w| w[1] < w[0] || w[1].is_nan()) {
            return wrong(format!("the time decreases at sample {}", late + 2));
        }
        if let Some(short) = signals.iter().find(|s| s.values.len() != time.len()) {
            return wrong(format!("'{}' has a different number of samples than time", short.name));
        }
        if self.names.len() != signals.len() {
            return wrong("the numbers of names and signals differ".to_owned());
        }
        Ok(())
    }

    /// Names, in the order of the variables.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Type of a signal.
    pub fn kind(&self, signal: usize) -> &Kind {
        &self.signals[signal].kind
    }

    /// A hash of names, times and values.
    pub(crate) fn digest(&self) -> String {
        let numbers = self.signals.iter().fold(self.time.clone(), |all, signal| {
            all.into_iter().chain(signal.values.iter().copied()).collect()
        });
        let mut bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_bits().to_le_bytes()).collect();
        bytes.extend(self.names.join("\n").into_bytes());
        sha256(bytes)
    }

    /// Slopes of `wanted` just after `time`; 0 where a signal is held.
    pub fn slopes_at(&self, time: Time, wanted: &[usize], slopes: &mut [f64]) {
        let after = self.time.partition_point(|&sample| sample <= time.seconds());
        for (slope, &wanted) in slopes.iter_mut().zip(wanted) {
            let signal = &self.signals[wanted];
            let between = signal.continuous && after > 0 && after < self.time.len();
            *slope = if between {
                let rise = signal.values[after] - signal.values[after - 1];
                rise / (self.time[after] - self.time[after - 1])
            } else {
                0.0
            };
        }
    }

    /// Values of `wanted` at `time`: the first before the first sample, the last after the last. At
    /// an instant that occurs twice (a discontinuity), the later value counts. A number of the file
    /// becomes the nearest value of the signal's type.
    pub fn values_at(&self, time: Time, wanted: &[usize], values: &mut [Scalar]) {
        let t = time.seconds();
        let after = self.time.partition_point(|&sample| sample <= t);
        for (value, &wanted) in values.iter_mut().zip(wanted) {
            let signal = &self.signals[wanted];
            let samples = &signal.values;
            let number = if after == 0 {
                samples[0]
            } else if after == samples.len() || !signal.continuous {
                samples[after - 1]
            } else {
                let (t0, t1) = (self.time[after - 1], self.time[after]);
                let share = (t - t0) / (t1 - t0);
                samples[after - 1] + share * (samples[after] - samples[after - 1])
            };
            *value = Scalar::of_number(signal.kind.basic(), number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_and_outside_of_samples() {
        let of = |continuous| Signal {
            name: "u".into(),
            kind: Kind::Real,
            continuous,
            values: vec![0.0, 2.0, 5.0, 6.0],
        };
        let signals = Signals::new(&[0.0, 1.0, 1.0, 2.0], vec![of(true), of(false)]).unwrap();
        let at = |seconds| {
            let mut values = [Scalar::default(); 2];
            let time = Time::from_seconds(seconds);
            signals.values_at(time, &[0, 1], &mut values);
            values.map(Scalar::as_real)
        };
        assert_eq!(at(-1.0), [0.0, 0.0]);
        assert_eq!(at(0.5), [1.0, 0.0]);
        assert_eq!(at(1.0), [5.0, 5.0]);
        assert_eq!(at(9.0), [6.0, 6.0]);
        assert!(Signals::new(&[1.0, 0.0], vec![]).is_err());
    }
}
