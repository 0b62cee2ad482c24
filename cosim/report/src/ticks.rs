//! Round axis ticks: steps of 1, 2 or 5 times a power of ten, labelled with just enough decimals.

/// Ticks of one axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    /// Positions, ascending.
    pub(super) places: Vec<f64>,
    decimals: usize,
    scientific: bool,
}

impl Ticks {
    /// About `wanted` ticks within `[low, high]`.
    pub(super) fn new(low: f64, high: f64, wanted: usize) -> Self {
        let rough = (high - low) / wanted.max(1) as f64;
        let power = rough.log10().floor();
        let unit = 10_f64.powf(power);
        let (factor, exponent) = match rough / unit {
            m if m < 1.5 => (1.0, power),
            m if m < 3.5 => (2.0, power),
            m if m < 7.5 => (5.0, power),
            _ => (1.0, power + 1.0),
        };
        let step = factor * 10_f64.powf(exponent);
        // Integer multiples of the step, so that no rounding error accumulates; with a tolerance of
        // a millionth.
        let first = (low / step - 1e-6).ceil() as i64;
        let last = (high / step + 1e-6).floor() as i64;
        let greatest = low.abs().max(high.abs());
        Ticks {
            places: (first..=last).map(|i| i as f64 * step).collect(),
            decimals: (-exponent).max(0.0) as usize,
            scientific: greatest >= 1e6 || exponent < -5.0,
        }
    }

    /// The label at a position.
    pub(super) fn label(&self, place: f64) -> String {
        if self.scientific {
            return format!("{:.3e}", if place == 0.0 { 0.0 } else { place });
        }
        let text = format!("{place:.*}", self.decimals);
        let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
        let digits = if is_zero { text.trim_start_matches('-') } else { text.as_str() };
        // U+2212: a true minus sign, as wide as the plus sign.
        digits.replacen('-', "\u{2212}", 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, wanted: usize) -> Vec<String> {
        let ticks = Ticks::new(low, high, wanted);
        ticks.places.iter().map(|p| ticks.label(*p)).collect()
    }

    #[test]
    fn steps_are_round_and_carry_no_rounding_error() {
        assert_eq!(labels(0.0, 0.3, 3), ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(labels(-0.05, 0.05, 4), ["−0.04", "−0.02", "0.00", "0.02", "0.04"]);
        assert_eq!(labels(0.0, 321.0, 6), ["0", "50", "100", "150", "200", "250", "300"]);
    }

    #[test]
    fn great_and_tiny_ranges_use_exponents() {
        assert_eq!(labels(0.0, 2e6, 2), ["0.000e0", "1.000e6", "2.000e6"]);
        assert_eq!(labels(0.0, 2e-7, 2), ["0.000e0", "1.000e-7", "2.000e-7"]);
    }

    #[test]
    fn ticks_lie_within_the_range() {
        let ticks = Ticks::new(-3.7, 12.2, 5);
        assert!(ticks.places.iter().all(|p| (-3.7..=12.2).contains(p)));
        assert!((3..=8).contains(&ticks.places.len()));
    }
}
