//! Verdicts on goals.
//!
//! Goals refer to all possible seeds; a campaign determines a number only within an interval. So a
//! verdict has three values: the number is within its bounds; it is not, but its interval reaches
//! into them (too few seeds to decide); or it is clearly outside.

/// One goal and its result.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Verdict {
    /// What was measured.
    pub(crate) what: String,
    /// The value reached.
    pub(crate) value: f64,
    /// The 95 % confidence interval of the value over all possible seeds; the value itself if that
    /// is unknown.
    pub(crate) interval: [f64; 2],
    /// Smallest allowed value.
    pub(crate) low: f64,
    /// Largest allowed value.
    pub(crate) high: f64,
    /// Unit, or nothing.
    pub(crate) unit: &'static str,
}

impl Verdict {
    /// Whether the value is within its bounds; NaN is not.
    pub(crate) fn is_reached(&self) -> bool {
        (self.low..=self.high).contains(&self.value)
    }

    /// The bounds as text.
    pub(crate) fn bounds(&self) -> String {
        let text = match (self.low > 0.0, self.high.is_finite()) {
            (true, true) => format!("{} to {}", self.low, self.high),
            (false, _) => format!("at most {}", self.high),
            (true, false) => format!("at least {}", self.low),
        };
        format!("{text} {}", self.unit).trim_end().to_string()
    }

    /// The value as text.
    pub(crate) fn value(&self) -> String {
        format!("{:.3} {}", self.value, self.unit).trim_end().to_string()
    }

    /// Whether the value is outside its bounds by more than the uncertainty of the seeds.
    pub(crate) fn is_missed(&self) -> bool {
        let [least, greatest] = self.interval;
        // Also without a value: comparisons with NaN are false.
        !(self.is_reached() || least <= self.high && greatest >= self.low)
    }

    /// The verdict in words.
    pub(crate) fn word(&self) -> String {
        let [least, greatest] = self.interval;
        if self.is_reached() {
            "reached".into()
        } else if self.is_missed() {
            "MISSED".into()
        } else {
            format!("open: these seeds say {least:.3} to {greatest:.3} (95 %)")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_outside_is_open_while_its_interval_reaches_into_the_band() {
        let verdict = |value, interval| Verdict {
            what: String::new(),
            value,
            interval,
            low: 0.25,
            high: 0.37,
            unit: "m",
        };
        assert!(!verdict(0.24, [0.2, 0.28]).is_missed());
        assert!(!verdict(0.24, [0.2, 0.28]).is_reached());
        assert!(verdict(0.24, [0.23, 0.249]).is_missed());
        assert!(verdict(0.4, [0.38, 0.42]).is_missed());
        assert!(verdict(f64::NAN, [f64::NAN; 2]).is_missed());
        assert!(!verdict(0.3, [0.1, 0.2]).is_missed());
    }
}
