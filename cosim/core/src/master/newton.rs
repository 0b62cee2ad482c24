//! Solves v = g(v) for the values v of the connections at which a loop is cut.
//!
//! Newton's method on g(v) - v = 0. If g provides its derivatives, they form the Jacobian; they
//! hold the members' states, so they are exact in initialization mode and approximate at a step,
//! and they are no longer used after a step with them that does not halve the residual. Otherwise,
//! fixed-point passes are made as long as each at least halves the residual, and the Jacobian is
//! computed by forward differences, one pass of the loop per unknown, when they do not.

use cosim_base::error::Result;

/// Residual, relative to 1 + |v|, at which a loop is solved.
pub(super) const SOLVED: f64 = 1e-10;
/// Maximum number of passes of a loop, not counting those for differences.
const MAX_PASSES: u32 = 50;
/// Relative step of the differences: the square root of the precision.
const DIFFERENCE: f64 = 1.5e-8;

/// One pass of a loop.
pub(super) trait Function {
    /// g(v), into `image`.
    fn value(&mut self, v: &[f64], image: &mut [f64]) -> Result<()>;

    /// The derivative of g with respect to one unknown, at the v of the last value; returns whether
    /// it is known.
    fn column(&mut self, position: usize, column: &mut [f64]) -> Result<bool>;
}

/// The result of an iteration.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Outcome {
    /// Evaluations of g.
    pub passes: u32,
    /// Greatest residual relative to 1 + |v|.
    pub residual: f64,
    /// Number of Jacobians from the derivatives of g, and by differences.
    pub directional: u32,
    pub differences: u32,
}

impl Outcome {
    pub(super) fn converged(self) -> bool {
        self.residual <= SOLVED
    }

    fn evaluate(&mut self, v: &[f64], image: &mut [f64], g: &mut dyn Function) -> Result<()> {
        g.value(v, image)?;
        self.passes += 1;
        self.residual = residual(v, image);
        Ok(())
    }
}

/// Iterates from `v`. The last evaluation of `g` uses the values that `v` has at the end.
pub(super) fn solve(v: &mut [f64], g: &mut dyn Function) -> Result<Outcome> {
    let mut image = vec![0.0; v.len()];
    let mut outcome = Outcome::default();
    outcome.evaluate(v, &mut image, g)?;
    let mut has_derivatives = true;
    for _ in 0..MAX_PASSES {
        if outcome.converged() || !outcome.residual.is_finite() {
            break;
        }
        let last = outcome.residual;
        if has_derivatives {
            let step = derivative_step(v, &image, g)?;
            has_derivatives = step.is_some();
            if let Some(step) = step {
                outcome.directional += 1;
                v.iter_mut().zip(step).for_each(|(v, s)| *v += s);
                outcome.evaluate(v, &mut image, g)?;
                has_derivatives = outcome.residual <= 0.5 * last;
                continue;
            }
        }
        let (begin, begin_image) = (v.to_vec(), image.clone());
        v.copy_from_slice(&image);
        outcome.evaluate(v, &mut image, g)?;
        if outcome.residual <= 0.5 * last {
            continue;
        }
        outcome.differences += 1;
        let Some(step) = difference_step(&begin, &begin_image, &mut outcome.passes, g)? else {
            // The last evaluation was for a difference.
            outcome.evaluate(v, &mut image, g)?;
            break;
        };
        v.iter_mut().zip(begin.iter().zip(step)).for_each(|(v, (b, s))| *v = b + s);
        outcome.evaluate(v, &mut image, g)?;
    }
    Ok(outcome)
}

/// NaN if any value is NaN.
fn residual(v: &[f64], image: &[f64]) -> f64 {
    let parts = v.iter().zip(image).map(|(v, g)| (g - v).abs() / (1.0 + v.abs()));
    parts.fold(0.0, |most, part| if part <= most { most } else { part })
}

/// Rows of (dg/dv - 1 | v - g), with zeros for dg/dv.
fn rows(v: &[f64], image: &[f64]) -> Vec<Vec<f64>> {
    let n = v.len();
    let row = |i: usize| {
        let mut row = vec![0.0; n + 1];
        (row[i], row[n]) = (-1.0, v[i] - image[i]);
        row
    };
    (0..n).map(row).collect()
}

/// The Newton step with the derivatives of `g`.
fn derivative_step(v: &[f64], image: &[f64], g: &mut dyn Function) -> Result<Option<Vec<f64>>> {
    let (mut rows, mut column) = (rows(v, image), vec![0.0; v.len()]);
    for position in 0..v.len() {
        if !g.column(position, &mut column)? {
            return Ok(None);
        }
        rows.iter_mut().zip(&column).for_each(|(row, slope)| row[position] += slope);
    }
    Ok(eliminate(rows))
}

/// The Newton step from `v` with its image; `None` if the Jacobian is singular.
fn difference_step(
    v: &[f64],
    image: &[f64],
    passes: &mut u32,
    g: &mut dyn Function,
) -> Result<Option<Vec<f64>>> {
    let mut rows = rows(v, image);
    let (mut shifted, mut moved) = (v.to_vec(), vec![0.0; v.len()]);
    for column in 0..v.len() {
        shifted[column] = v[column] + DIFFERENCE * (1.0 + v[column].abs());
        let width = shifted[column] - v[column];
        g.value(&shifted, &mut moved)?;
        *passes += 1;
        shifted[column] = v[column];
        for (i, row) in rows.iter_mut().enumerate() {
            row[column] += (moved[i] - image[i]) / width;
        }
    }
    Ok(eliminate(rows))
}

/// Gaussian elimination with partial pivoting of rows (matrix | right side).
fn eliminate(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for column in 0..n {
        let pivot =
            (column..n).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))?;
        rows.swap(column, pivot);
        let (above, below) = rows.split_at_mut(column + 1);
        let top = &above[column];
        if top[column].abs() < 1e-12 || !top[column].is_finite() {
            return None;
        }
        for row in below {
            let factor = row[column] / top[column];
            row.iter_mut().zip(top).for_each(|(value, top)| *value -= factor * top);
        }
    }
    let mut solution = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[i][j] * solution[j]).sum();
        solution[i] = (rows[i][n] - known) / rows[i][i];
    }
    Some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values, and derivatives if they are provided; counts evaluations, keeps the last argument.
    struct Counted<G> {
        g: G,
        slope: Option<f64>,
        calls: u32,
        last: Vec<f64>,
    }

    impl<G: Fn(&[f64], &mut [f64])> Counted<G> {
        fn new(slope: Option<f64>, g: G) -> Self {
            Self { g, slope, calls: 0, last: Vec::new() }
        }
    }

    impl<G: Fn(&[f64], &mut [f64])> Function for Counted<G> {
        fn value(&mut self, v: &[f64], image: &mut [f64]) -> Result<()> {
            self.calls += 1;
            self.last = v.to_vec();
            (self.g)(v, image);
            Ok(())
        }

        fn column(&mut self, _: usize, column: &mut [f64]) -> Result<bool> {
            column.fill(self.slope.unwrap_or_default());
            Ok(self.slope.is_some())
        }
    }

    #[test]
    fn a_contraction_needs_no_jacobian() {
        let (mut v, mut g) = ([0.0], Counted::new(None, |v, g| g[0] = 0.1 * v[0] + 0.9));
        let outcome = solve(&mut v, &mut g).unwrap();
        assert!(outcome.converged() && outcome.passes == g.calls && g.calls < 14, "{outcome:?}");
        assert!((v[0] - 1.0).abs() < 1e-9 && outcome.differences == 0);
    }

    #[test]
    fn an_expansion_is_solved_by_newton() {
        // A saddle and a cube: fixed-point passes diverge.
        let mut v = [0.5, 0.5, 0.5];
        let mut g = Counted::new(None, |v, g| {
            g.copy_from_slice(&[2.0 * v[1] + 1.0, 3.0 * v[0] - v[2], 7.0 - 5.0 * v[2].powi(3)]);
        });
        let outcome = solve(&mut v, &mut g).unwrap();
        assert!(outcome.converged() && outcome.differences > 0);
        assert_eq!(g.last, v);
        assert!((v[2] + 5.0 * v[2].powi(3) - 7.0).abs() < 1e-8);
        assert!((v[0] - 2.0 * v[1] - 1.0).abs() < 1e-8);
    }

    #[test]
    fn known_derivatives_save_passes_and_wrong_ones_do_no_harm() {
        let g = |v: &[f64], g: &mut [f64]| g[0] = 5.0 - 3.0 * v[0];
        let mut exact = Counted::new(Some(-3.0), g);
        let outcome = solve(&mut [0.0], &mut exact).unwrap();
        assert!(outcome.converged() && exact.calls == 2 && outcome.directional == 1);
        let mut wrong = Counted::new(Some(0.5), g);
        let outcome = solve(&mut [0.0], &mut wrong).unwrap();
        assert!(outcome.converged() && outcome.differences == 1, "{outcome:?}");
    }

    #[test]
    fn what_has_no_solution_is_reported() {
        let mut g = Counted::new(None, |v, g| g[0] = v[0] + 1.0);
        assert!(!solve(&mut [0.0], &mut g).unwrap().converged());
    }
}
