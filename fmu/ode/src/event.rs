//! Locates where in a step an event indicator changes its sign.
//!
//! An indicator has two domains, z > 0 and z <= 0 (FMI 2.0.5, 3.1.1). A bracket is narrowed by the
//! secant, from both sides, alternating with bisection; its right end, after the crossing, is the
//! event.

/// A bracket in a step: no sign has changed at `before`, some have at `after`.
#[derive(Clone, Debug)]
pub struct Bracket {
    /// Its start, from the beginning of the step.
    pub before: f64,
    /// Its end.
    pub after: f64,
    z_before: Vec<f64>,
    z_after: Vec<f64>,
    turn: u8,
}

impl Bracket {
    /// From the beginning of the step to `after`, with the indicators there.
    #[must_use]
    pub fn new(z_before: &[f64], after: f64, z_after: &[f64]) -> Self {
        let (z_before, z_after) = (z_before.to_vec(), z_after.to_vec());
        Self { before: 0.0, after, z_before, z_after, turn: 0 }
    }

    /// Where to evaluate next.
    #[must_use]
    pub fn guess(&mut self) -> f64 {
        let width = self.after - self.before;
        self.turn = (self.turn + 1) % 3;
        // The earliest crossing of those that changed.
        let secants = self.z_before.iter().zip(&self.z_after).filter(|(b, a)| changed(**b, **a));
        let share = secants.map(|(b, a)| b / (b - a)).fold(1.0, f64::min);
        // Slightly after the guess, then slightly before it, closes the bracket from both sides;
        // the middle is for indicators that are far from linear.
        let share = match self.turn {
            1 => share + 0.01,
            2 => share - 0.01,
            _ => 0.5,
        };
        self.before + width * share.clamp(0.01, 0.99)
    }

    /// Narrows the bracket by the indicators found at `at`.
    pub fn narrow(&mut self, at: f64, z: &[f64]) {
        if any_changed(&self.z_before, z) {
            self.after = at;
            self.z_after.copy_from_slice(z);
        } else {
            self.before = at;
            self.z_before.copy_from_slice(z);
        }
    }
}

/// The domain of an indicator.
#[inline]
#[must_use]
pub fn is_positive(indicator: f64) -> bool {
    indicator > 0.0
}

/// Whether any indicator is in another domain.
#[must_use]
pub fn any_changed(before: &[f64], after: &[f64]) -> bool {
    before.iter().zip(after).any(|(b, a)| changed(*b, *a))
}

fn changed(before: f64, after: f64) -> bool {
    is_positive(before) != is_positive(after)
}

/// The width to which an event at time `t` is located: `width`, if the time has enough digits.
#[must_use]
pub fn resolution(width: f64, t: f64) -> f64 {
    width.max(4.0 * f64::EPSILON * t.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_earliest_of_two_crossings_is_found_quickly() {
        let z = |t: f64| [t * t * t - 0.3, 0.5 - t, 1.0];
        let mut bracket = Bracket::new(&z(0.0), 1.0, &z(1.0));
        let mut calls = 0;
        while bracket.after - bracket.before > 1e-12 {
            let at = bracket.guess();
            bracket.narrow(at, &z(at));
            calls += 1;
        }
        assert!(bracket.before <= 0.5 && 0.5 <= bracket.after && calls < 30, "{calls}");
        assert!(any_changed(&z(0.0), &z(bracket.after)));
    }
}
