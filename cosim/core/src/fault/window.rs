//! When a fault acts in a run, as text for reports.

use serde::Serialize;

use super::{Begin, End, Fault, Kind, Meanwhile};
use crate::observe::Recording;
use cosim_base::time::Time;

/// A time span in which a fault acts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Window {
    /// Fault and variable: `drop-out of gps.position.x`.
    pub label: String,
    /// Its start (s).
    pub from: f64,
    /// Its end (s); `None`: end of the run.
    pub until: Option<f64>,
}

impl Fault {
    /// The time span in which the fault with this number acts in a recorded run; `None` if it never
    /// begins, or if the variable of its condition was not recorded.
    pub(crate) fn window(&self, seed: u64, number: u32, recording: &Recording) -> Option<Window> {
        let time = recording.time();
        let start = Time::try_from_seconds(*time.first()?).ok()?;
        let from = match (self.begins(seed, number, start), &self.begin) {
            (Some(from), _) => from.seconds(),
            (None, Begin::When(condition)) => {
                let values = recording.column(&condition.variable).ok()?;
                *time.iter().zip(values).find(|(_, value)| condition.holds(**value))?.0
            }
            (None, _) => return None,
        };
        let until = match self.ends(seed, number) {
            End::Never if self.kind == Kind::Reset => Some(from),
            End::Never => None,
            End::At(time) => Some(time.seconds()),
            End::After(lasts) | End::AfterBetween(lasts, _) => Some(from + lasts.seconds()),
        };
        Some(Window { label: self.words(), from, until })
    }

    /// Its kind and its variables.
    pub(crate) fn words(&self) -> String {
        format!("{} of {}", word(&self.kind), self.variables.join(", "))
    }
}

/// The name of the kind in files.
fn word(kind: &Kind) -> &'static str {
    match kind {
        Kind::Override(_) => "override",
        Kind::Bias(_) => "bias",
        Kind::Scale(_) => "scale",
        Kind::Drift(_) => "drift",
        Kind::Ramp { .. } => "ramp",
        Kind::WhiteNoise(_) => "white noise",
        Kind::GaussMarkov { .. } => "Gauss-Markov noise",
        Kind::Outliers { .. } => "outliers",
        Kind::Stuck => "stuck value",
        Kind::NotANumber => "NaN instead",
        Kind::Quantization(_) => "quantization",
        Kind::Saturation(..) => "saturation",
        Kind::DropOut { turns: Some(_), .. } => "intermittent drop-outs",
        Kind::DropOut { meanwhile: Meanwhile::NotANumber, .. } => "drop-out to NaN",
        Kind::DropOut { .. } => "drop-out",
        Kind::Latency { .. } => "latency",
        Kind::Lag(_) => "lag",
        Kind::Sampling => "rate change",
        Kind::Reordering { again: false, .. } => "reordering",
        Kind::Reordering { again: true, .. } => "duplicates",
        Kind::Release => "release",
        Kind::Reset => "reset",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(begin: Begin, end: End) -> Fault {
        let (variables, none) = (vec!["gps.*".to_owned()], Time::ZERO);
        let (ramp_in, ramp_out, every) = (none, none, none);
        let (kind, installed) = (Kind::Stuck, None);
        Fault { variables, kind, installed, begin, end, ramp_in, ramp_out, every }
    }

    #[test]
    fn windows_are_where_the_fault_acts() {
        let time = vec![0.0, 1.0, 2.0, 3.0];
        let recording =
            Recording::from_columns(vec!["z".into()], time, vec![vec![0.0, 5.0, 15.0, 20.0]]);
        let second = |s: i64| Time::from_ns(s * 1_000_000_000);
        let window = |begin, end| fault(begin, end).window(7, 0, &recording);
        let at = window(Begin::At(second(1)), End::After(second(2))).unwrap();
        assert_eq!(
            (at.label.as_str(), at.from, at.until),
            ("stuck value of gps.*", 1.0, Some(3.0))
        );
        let when = |text: &str| window(Begin::When(text.parse().unwrap()), End::Never);
        assert_eq!(when("z > 10").map(|w| (w.from, w.until)), Some((2.0, None)));
        assert_eq!((when("z > 30"), when("y > 3")), (None, None));
        let drawn = fault(Begin::Between(second(1), second(3)), End::Never);
        let from = drawn.window(7, 0, &recording).unwrap().from;
        assert_eq!(Some(from), drawn.begins(7, 0, Time::ZERO).map(Time::seconds));
        let lasting = fault(Begin::At(second(1)), End::AfterBetween(second(2), second(4)));
        let lasts = |seed| {
            let window = lasting.window(seed, 0, &recording).unwrap();
            window.until.unwrap() - window.from
        };
        assert!((0..50).map(lasts).all(|lasts| (2.0..4.0).contains(&lasts)));
        assert!((0..50).map(lasts).any(|lasts| lasts < 2.5));
        assert!((0..50).map(lasts).any(|lasts| lasts > 3.5));
        assert_eq!(lasting.ends(7, 0), lasting.ends(7, 0));
    }
}
