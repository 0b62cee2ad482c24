//! Solves v = g(v) for the values v of the connections at which a loop is cut.
//!
//! Fixed-point passes as long as each at least halves the residual; else Newton's method on
//! g(v) - v = 0 with the Jacobian by forward differences, one pass of the loop per unknown.

use crate::error::Result;

/// Residual, relative to 1 + |v|, at which a loop is solved.
const SOLVED: f64 = 1e-10;
/// Passes of a loop, those for differences left out.
const MAX_PASSES: u32 = 50;
/// Relative step of the differences: the root of the precision.
const DIFFERENCE: f64 = 1.5e-8;

/// The function g: one pass of a loop, the second argument from the first.
pub(super) type Loop<'a> = dyn FnMut(&[f64], &mut [f64]) -> Result<()> + 'a;

/// How an iteration ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outcome {
    /// Evaluations of g.
    pub passes: u32,
    /// Greatest residual relative to 1 + |v|.
    pub residual: f64,
}

impl Outcome {
    pub(super) fn converged(self) -> bool {
        self.residual <= SOLVED
    }
}

/// Iterates from `v`. The last call of `g` is with the values that `v` has at the end.
pub(super) fn solve(v: &mut [f64], g: &mut Loop) -> Result<Outcome> {
    let mut image = vec![0.0; v.len()];
    g(v, &mut image)?;
    let mut outcome = Outcome { passes: 1, residual: residual(v, &image) };
    for _ in 0..MAX_PASSES {
        if outcome.converged() || !outcome.residual.is_finite() {
            break;
        }
        let last = outcome.residual;
        let (begin, begin_image) = (v.to_vec(), image.clone());
        v.copy_from_slice(&image);
        g(v, &mut image)?;
        outcome = Outcome { passes: outcome.passes + 1, residual: residual(v, &image) };
        if outcome.residual <= 0.5 * last {
            continue;
        }
        let step = newton_step(&begin, &begin_image, &mut outcome.passes, g)?;
        let Some(step) = step else {
            break;
        };
        v.iter_mut().zip(begin.iter().zip(step)).for_each(|(v, (b, s))| *v = b + s);
        g(v, &mut image)?;
        outcome = Outcome { passes: outcome.passes + 1, residual: residual(v, &image) };
    }
    Ok(outcome)
}

/// NaN when any value is.
fn residual(v: &[f64], image: &[f64]) -> f64 {
    let parts = v.iter().zip(image).map(|(v, g)| (g - v).abs() / (1.0 + v.abs()));
    parts.fold(0.0, |most, part| if part <= most { most } else { part })
}

/// The step of Newton from `v` with its image; `None` where the Jacobian is singular.
fn newton_step(
    v: &[f64],
    image: &[f64],
    passes: &mut u32,
    g: &mut Loop,
) -> Result<Option<Vec<f64>>> {
    let n = v.len();
    // Rows of (dg/dv - 1 | v - g).
    let mut rows: Vec<Vec<f64>> =
        (0..n).map(|i| vec![0.0; n].into_iter().chain([v[i] - image[i]]).collect()).collect();
    let (mut shifted, mut moved) = (v.to_vec(), vec![0.0; n]);
    for column in 0..n {
        shifted[column] = v[column] + DIFFERENCE * (1.0 + v[column].abs());
        let width = shifted[column] - v[column];
        g(&shifted, &mut moved)?;
        *passes += 1;
        shifted[column] = v[column];
        for (i, row) in rows.iter_mut().enumerate() {
            row[column] = (moved[i] - image[i]) / width - f64::from(u8::from(i == column));
        }
    }
    Ok(eliminate(rows))
}

/// Gauss's elimination with partial pivoting of rows (matrix | right side).
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

    #[test]
    fn a_contraction_needs_no_jacobian() {
        let mut v = [0.0];
        let mut calls = 0;
        let outcome = solve(&mut v, &mut |v, g| {
            calls += 1;
            g[0] = 0.1 * v[0] + 0.9;
            Ok(())
        });
        let outcome = outcome.unwrap();
        assert!(outcome.converged() && outcome.passes == calls && calls < 14, "{calls}");
        assert!((v[0] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn an_expansion_is_solved_by_newton() {
        // A saddle and a cube: fixed-point passes run away.
        let mut v = [0.5, 0.5, 0.5];
        let mut last = vec![];
        let outcome = solve(&mut v, &mut |v, g| {
            last = v.to_vec();
            g.copy_from_slice(&[2.0 * v[1] + 1.0, 3.0 * v[0] - v[2], 7.0 - 5.0 * v[2].powi(3)]);
            Ok(())
        });
        assert!(outcome.unwrap().converged());
        assert_eq!(last, v);
        assert!((v[2] + 5.0 * v[2].powi(3) - 7.0).abs() < 1e-8);
        assert!((v[0] - 2.0 * v[1] - 1.0).abs() < 1e-8);
    }

    #[test]
    fn what_has_no_solution_is_told() {
        let outcome = solve(&mut [0.0], &mut |v, g| {
            g[0] = v[0] + 1.0;
            Ok(())
        });
        assert!(!outcome.unwrap().converged());
    }
}
