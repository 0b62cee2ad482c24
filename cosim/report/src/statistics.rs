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
    quantile_of_sorted(&sorted, p)
}

/// The same of values in order.
pub fn quantile_of_sorted(sorted: &[f64], p: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = p.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The quantile `p` of the chi-square distribution with this many degrees of freedom, to about
/// 1e-12: the regularized incomplete gamma function, inverted by bisection.
pub fn chi_square_quantile(p: f64, freedom: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 {
        return f64::NAN;
    }
    let (mut low, mut high) = (0.0, freedom + 40.0 * libm::sqrt(2.0 * freedom) + 40.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if gamma_share(0.5 * freedom, 0.5 * middle) < p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The regularized lower incomplete gamma function: its series below the mean, its continued
/// fraction (Lentz) above it (DLMF 8.7.1, 8.9.2).
fn gamma_share(a: f64, x: f64) -> f64 {
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
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::MAX, 1.0 / b);
    let mut fraction = d;
    for n in 1..100_000 {
        let n = f64::from(n);
        let numerator = -n * (n - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
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
    fn chi_square_has_the_quantiles_of_scipy() {
        // scipy.stats.chi2.ppf
        for (p, freedom, wanted) in [
            (0.025, 2.0, 0.050_635_615_968_579_75),
            (0.975, 2.0, 7.377_758_908_227_871),
            (0.025, 200.0, 162.727_982_501_846_27),
            (0.975, 200.0, 241.057_895_506_310_93),
            (0.975, 6000.0, 6_216.591_278_981_366_5),
        ] {
            let found = chi_square_quantile(p, freedom);
            assert!((found / wanted - 1.0).abs() < 1e-9, "{p} {freedom}: {found}");
        }
    }
}
