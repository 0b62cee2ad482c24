//! How a known enters an unknown: `dependenciesKind` of FMI 2.0.4, section 2.2.8.
//!
//! Slopes are partial derivatives by the tangent-linear model, at random points. A slope that has
//! the same bits at all of them is a constant factor, and one that changes only with the parameters
//! is a fixed factor. Neither is declared for a slope that is zero everywhere, because then the
//! effect on the unknown was not seen, nor for components without a tangent-linear model.

use std::collections::BTreeMap;

/// How a known v enters an unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Factor {
    /// `c v`, c a number.
    Constant,
    /// `p v`, p made of parameters.
    Fixed,
    /// `h(v)`.
    Dependent,
}

impl Factor {
    /// Its name in modelDescription.xml.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Fixed => "fixed",
            Self::Dependent => "dependent",
        }
    }
}

/// Evidence from the slopes so far for a pair of unknown and known.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    factor: Factor,
    slope: f64,
    /// The set of parameters at which the slope was seen.
    parameters: u64,
}

/// The pairs of unknowns and knowns with known slopes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Factors(BTreeMap<(usize, usize), Seen>);

impl Factors {
    /// Records a slope at a numbered set of parameters.
    pub(crate) fn see(&mut self, unknown: usize, known: usize, slope: f64, parameters: u64) {
        let now = Seen { factor: Factor::Constant, slope, parameters };
        let seen = self.0.entry((unknown, known)).or_insert(now);
        if seen.slope != slope {
            let same = seen.parameters == parameters;
            seen.factor = seen.factor.max(if same { Factor::Dependent } else { Factor::Fixed });
        }
        (seen.slope, seen.parameters) = (slope, parameters);
    }

    /// How a known that affects an unknown enters it.
    pub(crate) fn of(&self, unknown: usize, known: usize) -> Factor {
        match self.0.get(&(unknown, known)) {
            Some(seen) if seen.factor != Factor::Constant || seen.slope != 0.0 => seen.factor,
            _ => Factor::Dependent,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_what_its_slopes_allow() {
        let mut factors = Factors::default();
        for (parameters, point) in [(0, 0.0), (0, 1.0), (1, 2.0), (1, 3.0)] {
            factors.see(0, 0, 2.0, parameters);
            factors.see(0, 1, parameters as f64, parameters);
            factors.see(0, 2, point, parameters);
            factors.see(0, 3, 0.0, parameters);
        }
        assert_eq!(factors.of(0, 0), Factor::Constant);
        assert_eq!(factors.of(0, 1), Factor::Fixed);
        assert_eq!(factors.of(0, 2), Factor::Dependent);
        assert_eq!(factors.of(0, 3), Factor::Dependent);
        assert_eq!(factors.of(1, 0), Factor::Dependent);
    }
}
