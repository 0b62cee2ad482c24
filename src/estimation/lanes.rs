//! The innermost loops of a filter: over the covariance, and over the hypotheses of a monitor.
//!
//! Their lengths are constants, and they are also compiled for vectors of 256 and 512 bits, for
//! processors that support them. Each element of a result comes from the same operations in the same
//! order at any width, and none is fused, so all processors give the same bits.
//!
//! Outer loops run over a set of states: over a range, the compiler would make vectors of what is far
//! apart in memory.
#![allow(unsafe_code, reason = "code for wide vectors is called where the processor has them")]

use core::ops::{AddAssign, Mul};

use super::belief::{Column, Row, states_in};
use super::kalman::Sequence;
use super::transition::{GROUPS, Group, Transition};

/// Matrices of up to this many rows are too small for a wide vector to pay for the check.
#[cfg(target_arch = "x86_64")]
const SMALL: usize = 4;

/// Defines a function that is compiled for any processor and for wide vectors; the first constant is
/// the size of the matrix.
macro_rules! for_any_width {
    (
        $(#[$doc:meta])*
        fn $name:ident<const $size:ident: usize $(, const $n:ident: usize)*>($($arg:ident: $of:ty),* $(,)?) $body:block
    ) => {
        $(#[$doc])*
        pub(in crate::estimation) fn $name<const $size: usize $(, const $n: usize)*>($($arg: $of),*) {
            #[inline(always)]
            fn narrow<const $size: usize $(, const $n: usize)*>($($arg: $of),*) $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide<const $size: usize $(, const $n: usize)*>($($arg: $of),*) {
                    narrow::<$size $(, $n)*>($($arg),*);
                }

                #[target_feature(enable = "avx512f,avx512vl")]
                fn widest<const $size: usize $(, const $n: usize)*>($($arg: $of),*) {
                    narrow::<$size $(, $n)*>($($arg),*);
                }

                use std::arch::is_x86_feature_detected as has;
                if $size > SMALL {
                    // SAFETY: the processor supports the features that the called one is compiled for.
                    unsafe {
                        if has!("avx512f") && has!("avx512vl") {
                            return widest::<$size $(, $n)*>($($arg),*);
                        } else if has!("avx2") {
                            return wide::<$size $(, $n)*>($($arg),*);
                        }
                    }
                }
            }
            narrow::<$size $(, $n)*>($($arg),*);
        }
    };
}

/// Calls a function with the smallest of a few constants that is not below `$order`, as its second
/// argument.
///
/// The orders of the filters without optional states of the velocity log are 16 and 30; vectors have
/// a multiple of four elements.
macro_rules! with_length {
    ($order:expr, $n:ident, $call:ident $(::<$more:ident>)? ($($arg:expr),* $(,)?)) => {
        match $order {
            ..=16 if $n > 16 => $call::<$n, 16 $(, $more)?>($($arg),*),
            17..=32 if $n > 32 => $call::<$n, 32 $(, $more)?>($($arg),*),
            _ => $call::<$n, $n $(, $more)?>($($arg),*),
        }
    };
}
pub(super) use with_length;

mod hypotheses;

pub(super) use hypotheses::{HYPOTHESES, Heard, Numbers, Vectors, advance, drive, hear};

for_any_width! {
/// `P <- P - sum_k s_k K_k K_k^T` with gains K and variances s, for a set of states among the first
/// `L`.
fn reduce<const N: usize, const L: usize, const K: usize>(
    p: &mut [[f64; N]; N],
    states: u64,
    updates: &[(&Column<N>, f64); K],
) {
    let mut g = [[0.0; L]; K];
    for k in 0..K {
        let (gain, root) = (&updates[k].0.data.0[0], updates[k].1.sqrt());
        for i in 0..L {
            g[k][i] = gain[i] * root;
        }
    }
    for j in states_in(states) {
        let own: [f64; K] = core::array::from_fn(|k| g[k][j]);
        let column = &mut p[j];
        for i in 0..L {
            let mut value = column[i];
            // g_i g_j is the same for (i, j) and (j, i): symmetry is exact.
            for k in 0..K {
                value -= own[k] * g[k][i];
            }
            column[i] = value;
        }
    }
}
}

/// The sum of multiples of columns, over their first `L` rows.
#[inline(always)]
fn combine<T: Scalar, const N: usize, const L: usize>(
    columns: &[[T; N]],
    terms: impl Iterator<Item = (usize, f64)>,
) -> [T; L] {
    let mut sum = [T::default(); L];
    for (k, factor) in terms {
        let (column, factor) = (&columns[k], T::of(factor));
        for i in 0..L {
            sum[i] += factor * column[i];
        }
    }
    sum
}

/// A number of double or single precision.
trait Scalar: Copy + Default + Mul<Output = Self> + AddAssign {
    fn of(value: f64) -> Self;
}

impl Scalar for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
}

impl Scalar for f32 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as Self
    }
}

for_any_width! {
/// Gains from correlations `P h_k`, in place, and `correction += sum_k K_k y_k`, over the first `L`
/// rows.
fn weigh<const N: usize, const L: usize>(
    columns: &mut [Column<N>],
    sequence: &Sequence,
    correction: &mut Column<N>,
) {
    let mut own = [[0.0; L]; 3];
    let mut sum = [0.0; L];
    for (k, column) in columns.iter_mut().enumerate().take(3) {
        let column = &mut column.data.0[0];
        let mut rest = [0.0; L];
        rest.copy_from_slice(&column[..L]);
        for (earlier, weight) in own[..k].iter().zip(sequence.weights[k]) {
            for i in 0..L {
                rest[i] -= weight * earlier[i];
            }
        }
        let (share, innovation) = (sequence.share[k], sequence.innovation[k]);
        for i in 0..L {
            let gain = rest[i] * share;
            column[i] = gain;
            sum[i] += innovation * gain;
        }
        own[k] = rest;
    }
    correction.as_mut_slice()[..L].copy_from_slice(&sum);
}
}

for_any_width! {
/// `into_k <- P h_k` for rows h.
fn correlate<const N: usize, const L: usize>(
    p: &[[f64; N]; N],
    rows: &[Row<N>],
    into: &mut [Column<N>],
) {
    for (row, into) in rows.iter().zip(into) {
        let sum: [f64; L] = combine(p, row.iter());
        into.as_mut_slice()[..L].copy_from_slice(&sum);
    }
}
}

for_any_width! {
/// `P <- F P F^T`, for the first `L` rows and columns.
fn propagate<const N: usize, const L: usize>(p: &mut [[f64; N]; N], f: &Transition<N>) {
    // Rows of F P for the states of the groups, and as columns those of P F^T.
    let mut changed = [[[0.0; L]; 3]; GROUPS];
    for (group, rows) in f.groups().iter().zip(&mut changed) {
        let whole = L - L % 16;
        for from in (0..whole).step_by(16) {
            let sums = combine_three::<_, N, N, 16>(&group.rows, group.support, p, from);
            (0..3).for_each(|r| rows[r][from..from + 16].copy_from_slice(&sums[r]));
        }
        for from in (whole..L).step_by(4).map(|from| from.min(L - 4)) {
            let sums = combine_three::<_, N, N, 4>(&group.rows, group.support, p, from);
            (0..3).for_each(|r| rows[r][from..from + 4].copy_from_slice(&sums[r]));
        }
    }
    for (group, rows) in f.groups().iter().zip(&changed) {
        for (state, row) in group.states().zip(rows) {
            for k in 0..L {
                p[k][state] = row[k];
            }
        }
    }
    // F times these columns, where they meet the rows of groups.
    for last in 0..f.groups().len() {
        let groups = &f.groups()[..=last];
        let from = groups.iter().map(|group| group.states().start).min().unwrap_or(0);
        let end = groups.iter().map(|group| group.states().end).max().unwrap_or(0);
        match end - from {
            ..=4 => meet::<N, L, 4>(p, groups, from.min(N - 4), &mut changed),
            ..=8 if N >= 8 => meet::<N, L, 8>(p, groups, from.min(N - 8), &mut changed),
            ..=12 if N >= 12 => meet::<N, L, 12>(p, groups, from.min(N - 12), &mut changed),
            _ => meet::<N, L, L>(p, groups, 0, &mut changed),
        }
    }
    for (group, rows) in f.groups().iter().zip(&changed) {
        for (state, row) in group.states().zip(rows) {
            p[state][..L].copy_from_slice(row);
        }
    }
    for (i, factor) in f.scaled() {
        for j in 0..L {
            p[i][j] *= factor;
            p[j][i] *= factor;
        }
    }
}
}

/// Three rows of F, non-zero in a set of states, times `W` columns of a matrix.
#[inline(always)]
fn combine_three<T: Scalar, const N: usize, const M: usize, const W: usize>(
    rows: &[[T; N]; 3],
    states: u64,
    matrix: &[[T; M]; N],
    from: usize,
) -> [[T; W]; 3] {
    let mut sums = [[T::default(); W]; 3];
    for k in states_in(states) {
        let by = &matrix[k][from..from + W];
        for r in 0..3 {
            for i in 0..W {
                sums[r][i] += rows[r][k] * by[i];
            }
        }
    }
    sums
}

/// Rows and columns of a symmetric matrix where the last of some groups meets all of them, among `W`
/// columns.
#[inline(always)]
fn meet<const N: usize, const L: usize, const W: usize>(
    p: &[[f64; N]; N],
    groups: &[Group<N>],
    from: usize,
    into: &mut [[[f64; L]; 3]; GROUPS],
) {
    let b = groups.len() - 1;
    let Group { rows, support, .. } = &groups[b];
    let sums = combine_three::<_, N, N, W>(rows, *support, p, from);
    for (a, other) in groups.iter().enumerate() {
        for (r, i) in groups[b].states().enumerate() {
            // Symmetric to the last bit.
            for (c, j) in other.states().enumerate().filter(|(_, j)| *j <= i || a < b) {
                into[b][r][j] = sums[r][j - from];
                into[a][c][i] = sums[r][j - from];
            }
        }
    }
}

for_any_width! {
/// From the derivatives M of some rates at the middle of a midpoint step, and A at its beginning, those of
/// the step's change: `M <- dt M (I + dt/2 A)`. The rates are those of the first `R` states.
fn midpoint<const W: usize, const R: usize>(
    middle: &mut [[f64; W]; R],
    first: &[[f64; W]; R],
    dt: f64,
) {
    for row in middle {
        let mut sum = *row;
        for k in 0..R {
            let factor = 0.5 * dt * row[k];
            if factor != 0.0 {
                for j in 0..W {
                    sum[j] += factor * first[k][j];
                }
            }
        }
        for j in 0..W {
            row[j] = dt * sum[j];
        }
    }
}
}

for_any_width! {
/// Whether the first `L` rows and columns of P are positive definite, except for exactly known
/// states: Cholesky's pivots of the correlation matrix may not be negative by more than rounding.
fn factorize<const N: usize, const L: usize>(p: &[[f64; N]; N], positive: &mut bool) {
    let mut scale = [0.0; L];
    for i in 0..L {
        let variance = p[i][i];
        *positive &= variance >= 0.0;
        scale[i] = if variance > 0.0 { 1.0 / variance.sqrt() } else { 0.0 };
    }
    // Above the diagonal the columns of the factor contain unused values.
    let mut l = [[0.0; L]; L];
    for j in 0..L {
        let mut column = [0.0; L];
        for i in 0..L {
            column[i] = p[j][i] * scale[i] * scale[j];
        }
        for earlier in &l[..j] {
            let factor = earlier[j];
            for i in 0..L {
                column[i] -= factor * earlier[i];
            }
        }
        let pivot = column[j];
        *positive &= pivot >= -1e-9;
        let root = pivot.max(0.0).sqrt();
        if root > 1e-7 {
            for i in 0..L {
                l[j][i] = column[i] / root;
            }
        }
    }
}
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SMatrix;

    const N: usize = 20;

    /// Numbers without a pattern.
    fn number(i: usize, j: usize) -> f64 {
        ((i * 37 + j * 61 + i * j) % 101) as f64 / 7.0 - 6.1
    }

    fn symmetric() -> [[f64; N]; N] {
        core::array::from_fn(|j| core::array::from_fn(|i| number(i.min(j), i.max(j))))
    }

    #[test]
    fn wide_vectors_give_the_bits_of_plain_loops() {
        let p = symmetric();
        let g: [[f64; N]; 2] =
            core::array::from_fn(|k| core::array::from_fn(|i| number(i, k + 50)));
        let mut reduced = p;
        let gains = g.map(Column::from);
        reduce::<N, 16, 2>(&mut reduced, 0xffff, &[(&gains[0], 1.0), (&gains[1], 1.0)]);
        let mut row = Row::zeros();
        [2, 5, 13].iter().for_each(|&state| row[state] = number(state, 70));
        let mut correlation = [Column::zeros()];
        correlate::<N, 16>(&p, &[row], &mut correlation);
        for j in 0..N {
            for i in 0..N {
                let inside = i < 16 && j < 16;
                let less = p[j][i] - g[0][j] * g[0][i] - g[1][j] * g[1][i];
                let want = if inside { less } else { p[j][i] };
                assert_eq!(reduced[j][i].to_bits(), want.to_bits(), "({i}, {j})");
            }
            let want = row.iter().fold(0.0, |sum, (state, h)| sum + h * p[state][j]);
            assert_eq!(correlation[0][j].to_bits(), (if j < 16 { want } else { 0.0 }).to_bits());
        }
    }

    #[test]
    fn propagation_is_that_of_the_dense_matrix_and_symmetric() {
        for rows in [0, 1, 2, 4, 5, 8, 9] {
            let mut f = Transition::<N>::identity();
            for i in 0..rows {
                f.set_row(i, [(i, 0.9), (i + 2, number(i, 3)), (19, number(i, 4))]);
            }
            f.scale(17, 0.5);
            f.scale(18, 0.0);
            let before = SMatrix::from_fn(|i, j| symmetric()[j][i]);
            let mut after = before;
            f.propagate(&mut after, N);
            let want = f.dense() * before * f.dense().transpose();
            assert_eq!(after, after.transpose(), "{rows} rows");
            assert!((after - want).amax() < 1e-9, "{rows} rows: {}", after - want);
        }
    }

    #[test]
    fn a_midpoint_step_has_the_derivatives_of_the_chain_rule() {
        const DT: f64 = 0.1;
        let [first, middle] =
            [3, 40].map(|of| core::array::from_fn(|i| core::array::from_fn(|j| number(i, j + of))));
        let mut change: [[f64; 16]; 8] = middle;
        change[2][1] = 0.0;
        let dense = |rows: &[[f64; 16]; 8]| {
            SMatrix::<f64, 16, 16>::from_fn(|i, j| rows.get(i).map_or(0.0, |row| row[j]))
        };
        let half = SMatrix::<f64, 16, 16>::identity() + dense(&first) * (0.5 * DT);
        let want = dense(&change) * half * DT;
        midpoint(&mut change, &first, DT);
        assert!((dense(&change) - want).amax() < 1e-12);
    }

    #[test]
    fn a_matrix_is_positive_if_its_least_eigenvalue_is() {
        let a =
            SMatrix::<f64, N, N>::from_fn(|i, j| number(i, j) * f64::from(1_u8 + (j % 3) as u8));
        for (least, positive) in [(1.0, true), (-1.0, false)] {
            let eigen = (a * a.transpose()).symmetric_eigen();
            let mut values = eigen.eigenvalues;
            values[7] = least;
            let p = eigen.eigenvectors * SMatrix::from_diagonal(&values);
            let p = p * eigen.eigenvectors.transpose();
            let mut got = true;
            factorize::<N, N>(&p.data.0, &mut got);
            assert_eq!(got, positive);
        }
    }
}
