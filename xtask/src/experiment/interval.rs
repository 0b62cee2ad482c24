//! How accurately a number of seeds determines a value.

use cosim::report::quantile;

/// Samples drawn.
const RESAMPLES: usize = 400;

/// The 95 % interval of a statistic of `n` seeds by the bootstrap (Efron 1979): the statistic of
/// samples of the seeds, drawn with replacement and always the same. It receives the drawn
/// positions.
pub(crate) fn bootstrap(n: usize, statistic: impl Fn(&[usize]) -> f64) -> [f64; 2] {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut draw = || {
        // xorshift64* (Vigna 2016).
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        let bits = state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33;
        (bits as usize) % n.max(1)
    };
    let values: Vec<f64> =
        (0..RESAMPLES).map(|_| statistic(&(0..n).map(|_| draw()).collect::<Vec<_>>())).collect();
    [0.025, 0.975].map(|p| quantile(&values, p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_mean_is_that_of_its_standard_deviation() {
        // 0 and 1 in equal parts: standard deviation 0.5, of the mean of 400 therefore 0.025.
        let mean = |drawn: &[usize]| drawn.iter().map(|i| (i % 2) as f64).sum::<f64>() / 400.0;
        let [low, high] = bootstrap(400, mean);
        assert!((low - 0.451).abs() < 0.008 && (high - 0.549).abs() < 0.008, "{low} {high}");
    }
}
