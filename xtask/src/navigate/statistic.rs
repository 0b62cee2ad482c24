//! Numbers of a cell over its seeds, each with its interval.

use cosim::report::{mean, quantile};

use super::score::{CHANNELS, Score};
use crate::experiment::bootstrap;

/// A number and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Number {
    pub(crate) value: f64,
    pub(crate) interval: [f64; 2],
}

/// A statistic of the seeds at these positions.
pub(crate) fn number(seeds: usize, statistic: impl Fn(&[usize]) -> f64) -> Number {
    let all: Vec<usize> = (0..seeds).collect();
    Number { value: statistic(&all), interval: bootstrap(seeds, statistic) }
}

/// A quantile of a measure over the drawn seeds.
pub(crate) fn over(scores: &[Score], drawn: &[usize], p: f64, of: fn(&Score) -> f64) -> f64 {
    // An infinite measure, as the time to an event that never occurs, is larger than all others.
    let values: Vec<f64> = drawn.iter().map(|i| of(&scores[*i]).min(1e9)).collect();
    quantile(&values, p)
}

/// A quantile of a measure.
pub(crate) fn quantile_of(scores: &[Score], p: f64, of: fn(&Score) -> f64) -> Number {
    number(scores.len(), |drawn| over(scores, drawn, p, of))
}

/// The mean of a measure.
pub(crate) fn mean_of(scores: &[Score], of: impl Fn(&Score) -> f64) -> Number {
    number(scores.len(), |drawn| mean(&drawn.iter().map(|i| of(&scores[*i])).collect::<Vec<_>>()))
}

/// The ratio of the sums of two measures.
pub(crate) fn ratio_of(scores: &[Score], of: impl Fn(&Score) -> [f64; 2]) -> Number {
    number(scores.len(), |drawn| {
        let [above, below] = drawn.iter().fold([0.0; 2], |[a, b], i| {
            let [above, below] = of(&scores[*i]);
            [a + above, b + below]
        });
        above / below
    })
}

/// The mean NIS of a channel.
pub(crate) fn anis(scores: &[Score], channel: usize) -> Number {
    debug_assert!(channel < CHANNELS.len());
    ratio_of(scores, |score| score.nis[channel])
}

/// Share of the time in which the mean NEES over all seeds, of this many components, is within its
/// 95 % band.
pub(crate) fn share_in_band(scores: &[Score], which: usize, components: f64) -> f64 {
    let degrees = components * scores.len() as f64;
    let [low, high] = [-1.96, 1.96].map(|z| chi_square(degrees, z) / scores.len() as f64);
    let instants = scores.iter().map(|s| s.nees[which].len()).min().unwrap_or_default();
    let inside = (0..instants).filter(|i| {
        let at_once: Vec<f64> = scores.iter().map(|s| s.nees[which][*i]).collect();
        (low..=high).contains(&mean(&at_once))
    });
    inside.count() as f64 / instants as f64
}

/// The chi-square quantile that corresponds to `z` of the normal distribution (Wilson & Hilferty
/// 1931).
fn chi_square(degrees: f64, z: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees);
    degrees * (1.0 - spread + z * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_that_of_the_tables() {
        // Bar-Shalom, Li & Kirubarajan 2001, table 1.5.4-1: chi-square with 100 degrees of freedom.
        assert!((chi_square(100.0, -1.96) - 74.2).abs() < 0.1);
        assert!((chi_square(100.0, 1.96) - 129.6).abs() < 0.1);
        let score = |nees: f64| Score { nees: [vec![nees, 9.0], vec![]], ..Score::default() };
        assert_eq!(share_in_band(&[score(1.5), score(2.5)], 0, 2.0), 0.5);
    }

    #[test]
    fn what_never_comes_is_later_than_everything() {
        let scores: Vec<Score> =
            [1.0, f64::INFINITY, 2.0].map(|detected| Score { detected, ..Score::default() }).into();
        assert_eq!(quantile_of(&scores, 0.5, |s| s.detected).value, 2.0);
    }
}
