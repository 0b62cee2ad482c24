//! Step-size control (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4) for
//! a method that estimates its error with order 4: a step is accepted up to the error 1.

const SAFETY: f64 = 0.9;
const MOST: f64 = 5.0;

/// The root mean square of the parts of an error; NaN if one of them is NaN.
#[derive(Clone, Copy, Debug, Default)]
pub struct RootMeanSquare {
    squares: f64,
    count: usize,
}

impl RootMeanSquare {
    /// Adds the error of one state, divided by the error allowed there.
    #[inline]
    pub fn add(&mut self, part: f64) {
        self.squares += part * part;
        self.count += 1;
    }

    /// The value; 0 without parts.
    #[inline]
    #[must_use]
    pub fn value(self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}

/// The factor from a step with this error to the next, from `least` to 5; `least` if the error is
/// NaN.
#[must_use]
pub fn step_factor(error: f64, least: f64) -> f64 {
    if error == 0.0 {
        return MOST;
    }
    let factor = SAFETY * libm::pow(error, -0.2);
    if factor.is_nan() { least } else { factor.clamp(least, MOST) }
}

#[cfg(test)]
mod tests {
    use super::{RootMeanSquare, step_factor};

    #[test]
    fn the_step_is_the_one_that_would_have_had_the_allowed_error() {
        assert_eq!(step_factor(1.0, 0.2), 0.9);
        assert_eq!(step_factor(32.0, 0.1), 0.45);
        assert_eq!(step_factor(0.0, 0.2), 5.0);
        for hopeless in [1e300, f64::INFINITY, f64::NAN] {
            assert_eq!(step_factor(hopeless, 0.1), 0.1);
        }
    }

    #[test]
    fn the_norm_of_nothing_is_zero_and_nan_stays() {
        let norm = |parts: &[f64]| {
            let mut norm = RootMeanSquare::default();
            parts.iter().for_each(|part| norm.add(*part));
            norm.value()
        };
        assert_eq!(norm(&[]), 0.0);
        assert_eq!(norm(&[1.0, -7.0]), 5.0);
        assert!(norm(&[1.0, f64::NAN]).is_nan());
    }
}
