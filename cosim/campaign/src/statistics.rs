//! What runs imply for all possible runs: shares and quantiles with confidence intervals.

use serde::Serialize;

/// The probability of at most `k` successes in `n` trials of the probability `p`.
fn binomial(k: u64, n: u64, p: f64) -> f64 {
    if k >= n || p <= 0.0 {
        return 1.0;
    }
    if p >= 1.0 {
        return 0.0;
    }
    let term = |i: u64| {
        let (i, n) = (i as f64, n as f64);
        let ways = libm::lgamma(n + 1.0) - libm::lgamma(i + 1.0) - libm::lgamma(n - i + 1.0);
        libm::exp(ways + i * libm::log(p) + (n - i) * libm::log1p(-p))
    };
    // On the side away from the mean, terms decrease from one to the next.
    let odds = p / (1.0 - p);
    let sum = |first: u64, next: &dyn Fn(u64) -> Option<(u64, f64)>| {
        let (mut at, mut part, mut sum) = (first, term(first), 0.0);
        loop {
            sum += part;
            match next(at) {
                Some((after, ratio)) if part > 1e-18 * sum => (at, part) = (after, part * ratio),
                _ => return sum,
            }
        }
    };
    if (k as f64) < n as f64 * p {
        let down = |i: u64| (i > 0).then(|| (i - 1, i as f64 / ((n - i + 1) as f64 * odds)));
        sum(k, &down).min(1.0)
    } else {
        let up = |i: u64| (i < n).then(|| (i + 1, (n - i) as f64 * odds / (i + 1) as f64));
        (1.0 - sum(k + 1, &up)).max(0.0)
    }
}

/// The smallest number below `count` from which on something holds, if there is one.
fn first(count: u64, holds: impl Fn(u64) -> bool) -> Option<u64> {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    (low < count).then_some(low)
}

/// The interval of a share of which `k` of `n` are known (Clopper & Pearson 1934): it contains the
/// share with at least this confidence.
pub(super) fn share(k: u64, n: u64, confidence: f64) -> [f64; 2] {
    let tail = (1.0 - confidence) / 2.0;
    let solve = |above: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if above(middle) { high = middle } else { low = middle }
        }
        0.5 * (low + high)
    };
    let low = if k == 0 { 0.0 } else { solve(&|p| 1.0 - binomial(k - 1, n, p) >= tail) };
    let high = if k == n { 1.0 } else { solve(&|p| binomial(k, n, p) <= tail) };
    [low, high]
}

/// An estimate of a property of the distribution that runs are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Its value in these runs.
    pub value: f64,
    /// Its interval with the requested confidence; infinite ends if too few runs are known.
    pub interval: [f64; 2],
}

/// The quantile `p` and its interval by order statistics (David & Nagaraja 2003, 7.1): whatever the
/// distribution, it contains the quantile with at least this confidence. NaN counts as infinite.
pub(super) fn quantile(values: &[f64], p: f64, confidence: f64) -> Estimate {
    let mut values: Vec<f64> =
        values.iter().map(|v| if v.is_nan() { f64::INFINITY } else { *v }).collect();
    let n = values.len() as u64;
    if n == 0 {
        return Estimate { value: f64::NAN, interval: [f64::NEG_INFINITY, f64::INFINITY] };
    }
    let tail = (1.0 - confidence) / 2.0;
    // The greatest rank below which the quantile lies with at most the probability of the tail.
    let low = first(n, |rank| binomial(rank, n, p) > tail).unwrap_or(n).checked_sub(1);
    let high = first(n, |rank| binomial(rank, n, p) >= 1.0 - tail);
    let place = p * (n - 1) as f64;
    let mut of_rank = |rank: u64| *values.select_nth_unstable_by(rank as usize, f64::total_cmp).1;
    let interval =
        [low.map_or(f64::NEG_INFINITY, &mut of_rank), high.map_or(f64::INFINITY, &mut of_rank)];
    let (below, above) = (of_rank(place.floor() as u64), of_rank(place.ceil() as u64));
    let value =
        if below == above { below } else { below + (place - place.floor()) * (above - below) };
    Estimate { value, interval }
}

/// The verdict on a threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Answer {
    /// It is met, with confidence.
    Pass,
    /// It is not met, with confidence.
    Fail,
    /// These runs leave it undecided; this many more would decide if they continue in the same way.
    /// `None`: more than a million.
    Undecided(Option<u64>),
}

/// Whether the share of which `k` of `n` are known is at least `wanted`.
pub(super) fn decide(k: u64, n: u64, wanted: f64, confidence: f64) -> Answer {
    let decided = |k: u64, n: u64| {
        let [low, high] = share(k, n, confidence);
        if low >= wanted {
            Some(Answer::Pass)
        } else if high < wanted {
            Some(Answer::Fail)
        } else {
            None
        }
    };
    if let Some(answer) = (n > 0).then(|| decided(k, n)).flatten() {
        return answer;
    }
    const MOST: u64 = 1_000_000;
    // Like the share of one more run: without a failure so far there may still be one.
    let so_far = if n == 0 { 1.0 } else { k as f64 / n as f64 };
    let would = |n: u64| decided((so_far * n as f64).round() as u64, n).is_some();
    let mut more = n.max(8);
    while !would(more) {
        more = more + more / 4;
        if more > MOST {
            return Answer::Undecided(None);
        }
    }
    let (mut low, mut high) = (n.max(more - more / 4), more);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if would(middle) { high = middle } else { low = middle }
    }
    Answer::Undecided(Some(high - n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_the_intervals_of_scipy() {
        // scipy.stats.beta.ppf
        for (k, n, low, high) in [
            (9, 10, 0.554_983_882_971_804_7, 0.997_471_421_455_538_2),
            (50, 100, 0.398_321_129_503_300_95, 0.601_678_870_496_699),
            (198, 200, 0.964_345_331_602_760_3, 0.998_786_650_986_264),
        ] {
            let [found_low, found_high] = share(k, n, 0.95);
            assert!((found_low - low).abs() < 1e-9 && (found_high - high).abs() < 1e-9);
        }
        assert_eq!(share(0, 10, 0.95)[0], 0.0);
        assert_eq!(share(10, 10, 0.95)[1], 1.0);
    }

    #[test]
    fn the_interval_of_a_median_is_that_of_the_tables() {
        // David & Nagaraja 2003: of 10 values, the 2nd and the 9th contain the median with 97.9 %,
        // the 3rd and the 8th with 89.1 %.
        let values: Vec<f64> = (1..=10).map(f64::from).collect();
        let median = quantile(&values, 0.5, 0.95);
        assert_eq!(median, Estimate { value: 5.5, interval: [2.0, 9.0] });
        assert_eq!(quantile(&values, 0.5, 0.89).interval, [3.0, 8.0]);
        // 10 values say nothing about the upper end of the 95th percentile.
        assert_eq!(quantile(&values, 0.95, 0.95).interval[1], f64::INFINITY);
        assert_eq!(quantile(&[1.0, f64::NAN], 1.0, 0.95).value, f64::INFINITY);
    }

    #[test]
    fn intervals_hold_what_they_should_as_often_as_they_should() {
        let (mut random, mut held) = (cosim_core::scenario::Random::new(&[7]), 0);
        for _ in 0..2000 {
            let values: Vec<f64> = (0..40).map(|_| random.uniform()).collect();
            let [low, high] = quantile(&values, 0.8, 0.9).interval;
            held += u32::from(low <= 0.8 && 0.8 <= high);
        }
        assert!((1800..1960).contains(&held), "{held}");
    }

    #[test]
    fn verdicts_are_open_until_the_runs_decide_and_say_how_many_more_would() {
        assert_eq!(decide(100, 100, 0.95, 0.95), Answer::Pass);
        assert_eq!(decide(50, 100, 0.95, 0.95), Answer::Fail);
        let Answer::Undecided(Some(more)) = decide(20, 20, 0.95, 0.95) else { panic!() };
        assert_eq!(decide(20 + more, 20 + more, 0.95, 0.95), Answer::Pass);
        assert_ne!(decide(19 + more, 19 + more, 0.95, 0.95), Answer::Pass);
        assert_eq!(decide(500, 1000, 0.5, 0.95), Answer::Undecided(None));
    }
}
