//! Mean, root mean square and quantiles of samples; quantiles of the chi-square distribution.

/// Arithmetic mean; NaN for no values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Root mean square; NaN for no values.
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// The quantile `p` (0 to 1) of the finite values, linear between order statistics
/// (Hyndman and Fan's type 7, the default of R and NumPy); NaN for no finite values.
pub fn quantile(values: &[f64], p: f64) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = p.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The quantile `p` of the chi-square distribution with so many degrees of freedom.
pub fn chi_square_quantile(p: f64, freedom: f64) -> f64 {
    let (mut low, mut high) = (0.0, freedom + 20.0 * (freedom.sqrt() + 10.0));
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if lower_gamma(0.5 * freedom, 0.5 * middle) < p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The regularized lower incomplete gamma function P(a, x): its series, or the continued fraction of
/// the rest (Abramowitz & Stegun 6.5.29 and 6.5.31), whichever converges fast.
fn lower_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let scale = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > 1e-17 * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return scale * sum;
    }
    // Lentz's method.
    let (mut b, mut d) = (x + 1.0 - a, 1.0 / (x + 1.0 - a));
    let (mut c, mut fraction) = (f64::MAX, d);
    for i in 1..10_000 {
        let i = f64::from(i);
        let factor = -i * (i - a);
        b += 2.0;
        d = 1.0 / (factor * d + b);
        c = b + factor / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-16 {
            break;
        }
    }
    1.0 - scale * fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_agree_with_numpy() {
        // numpy.quantile([3, 1, 4, 1, 5], [0, .05, .5, .95, 1])
        let sample = [3.0, 1.0, 4.0, 1.0, 5.0];
        let expected = [(0.0, 1.0), (0.05, 1.0), (0.5, 3.0), (0.95, 4.8), (1.0, 5.0)];
        for (p, value) in expected {
            assert!((quantile(&sample, p) - value).abs() < 1e-12, "p = {p}");
        }
    }

    #[test]
    fn values_that_are_not_finite_do_not_count() {
        assert_eq!(quantile(&[f64::NAN, 2.0, f64::INFINITY], 0.5), 2.0);
        assert!(quantile(&[f64::NAN], 0.5).is_nan());
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn root_mean_square_of_a_constant_is_its_size() {
        assert_eq!(root_mean_square(&[-2.0; 7]), 2.0);
        assert_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
    }

    #[test]
    fn quantiles_of_chi_square_are_those_of_scipy() {
        // scipy.stats.chi2.ppf(p, k)
        for (p, k, value) in [
            (0.025, 2.0, 0.050_635_615_968_579_8),
            (0.975, 2.0, 7.377_758_908_227_871),
            (0.95, 1.0, 3.841_458_820_694_124),
            (0.975, 300.0, 349.874_466_9),
            (0.025, 6000.0, 5787.2),
        ] {
            let found = chi_square_quantile(p, k);
            assert!((found / value - 1.0).abs() < 1e-4, "{p} {k}: {found}");
        }
    }
}
