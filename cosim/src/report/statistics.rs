//! Mean, root mean square and quantiles of samples.

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
}
