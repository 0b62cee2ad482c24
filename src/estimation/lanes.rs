//! The innermost loops of a filter: over the covariance, and over the hypotheses of a monitor.
//!
//! Their lengths are constants, and they are also compiled for 256-bit vectors, for processors that
//! support them. Each element of a result comes from the same operations in the same order at any
//! width, and none is fused, so all processors give the same bits.
#![allow(unsafe_code, reason = "code for wide vectors is called where the processor has them")]

use core::ops::{AddAssign, Mul};

use nalgebra::SMatrix;

use super::belief::{Column, Row};
use super::kalman::Sequence;
use super::transition::{ROWS, Transition};

/// Matrices of up to this many rows are too small for a wide vector to pay for the check.
#[cfg(target_arch = "x86_64")]
const SMALL: usize = 4;

/// Defines a function that is compiled twice, for any processor and for wide vectors; the first
/// constant is the size of the matrix.
macro_rules! for_any_width {
    (
        $(#[$doc:meta])*
        fn $name:ident<const $size:ident: usize $(, const $n:ident: usize)*>($($arg:ident: $of:ty),* $(,)?) $body:block
    ) => {
        $(#[$doc])*
        pub(super) fn $name<const $size: usize $(, const $n: usize)*>($($arg: $of),*) {
            #[inline(always)]
            fn narrow<const $size: usize $(, const $n: usize)*>($($arg: $of),*) $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide<const $size: usize $(, const $n: usize)*>($($arg: $of),*) {
                    narrow::<$size $(, $n)*>($($arg),*);
                }

                if $size > SMALL && std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor supports the features that `wide` is compiled for.
                    unsafe { wide::<$size $(, $n)*>($($arg),*) };
                    return;
                }
            }
            narrow::<$size $(, $n)*>($($arg),*);
        }
    };
}

/// Calls a function with the smallest of a few constants that is not below `$order`, as its second
/// argument.
///
/// The orders of the filters without optional states of the velocity log are 16 and 30.
macro_rules! with_length {
    ($order:expr, $n:ident, $call:ident $(::<$more:ident>)? ($($arg:expr),* $(,)?)) => {
        match $order {
            ..=16 if $n > 16 => $call::<$n, 16 $(, $more)?>($($arg),*),
            17..=30 if $n > 30 => $call::<$n, 30 $(, $more)?>($($arg),*),
            _ => $call::<$n, $n $(, $more)?>($($arg),*),
        }
    };
}
pub(super) use with_length;

for_any_width! {
/// `P <- P - sum_k s_k K_k K_k^T` with gains K and variances s, for the first `L` rows and columns.
fn reduce<const N: usize, const L: usize, const K: usize>(
    p: &mut [[f64; N]; N],
    updates: &[(&Column<N>, f64); K],
) {
    let mut g = [[0.0; L]; K];
    for k in 0..K {
        let (gain, root) = (&updates[k].0.data.0[0], updates[k].1.sqrt());
        for i in 0..L {
            g[k][i] = gain[i] * root;
        }
    }
    for j in 0..L {
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
        let (share, innovation) = (1.0 / sequence.variance[k], sequence.innovation[k]);
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
/// `P <- F P F^T`, for the first `L` rows and columns; at most `A` states have a row in F.
fn propagate<const N: usize, const L: usize, const A: usize>(
    p: &mut [[f64; N]; N],
    f: &Transition<N>,
) {
    // Columns of P F^T for the states that have a row.
    let mut states = [0; A];
    let mut changed = [[0.0; L]; A];
    for (((state, elements), of), column) in f.rows().zip(&mut states).zip(&mut changed) {
        *of = state;
        *column = combine(p, elements);
    }
    let mut factors = [1.0; L];
    for (i, factor) in f.scaled() {
        factors[i] = factor;
        for j in 0..L {
            p[i][j] *= factor;
            p[j][i] *= factor;
        }
    }
    // The product with F from the left: for states without a row it is a factor, ...
    let states = &states[..f.rows().count().min(A)];
    for (&i, column) in states.iter().zip(&changed) {
        for j in 0..L {
            let value = factors[j] * column[j];
            p[i][j] = value;
            p[j][i] = value;
        }
    }
    // ... and for states with a row a sum.
    let mut turned = [[0.0; A]; L];
    for k in 0..L {
        for a in 0..A {
            turned[k][a] = changed[a][k];
        }
    }
    for (b, (j, elements)) in f.rows().enumerate() {
        let sum: [f64; A] = combine(&turned, elements);
        for (&i, &value) in states.iter().zip(&sum).take(b + 1) {
            p[i][j] = value;
            p[j][i] = value;
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

/// How many hypotheses are processed at a time.
pub(super) const CHUNK: usize = 32;

/// A vector for each of `CHUNK` hypotheses: column i contains their components i. Single precision
/// is enough to distinguish them.
pub(super) type Chunk<const N: usize> = SMatrix<f32, CHUNK, N>;

for_any_width! {
/// `v <- F v` of many vectors at once.
fn advance<const N: usize>(chunks: &mut [Chunk<N>], f: &Transition<N>) {
    let mut changed = [[0.0_f32; CHUNK]; ROWS];
    for chunk in chunks {
        let v = &mut chunk.data.0;
        for ((_, elements), changed) in f.rows().zip(&mut changed) {
            *changed = combine(v, elements);
        }
        for ((state, _), changed) in f.rows().zip(&changed) {
            v[state] = *changed;
        }
        for (state, factor) in f.scaled() {
            let factor = factor as f32;
            v[state].iter_mut().for_each(|x| *x *= factor);
        }
    }
}
}

/// A scalar measurement that was fused: its row h, the gain K, the innovation y and its variance S; and
/// the direct effect on it of the thrust that each thruster loses.
pub(super) struct Heard<'a, const N: usize, const T: usize> {
    pub(super) row: &'a Row<N>,
    pub(super) gain: &'a Column<N>,
    pub(super) innovation: f64,
    pub(super) s: f64,
    pub(super) direct: &'a [f64; T],
}

for_any_width! {
/// `r = h^T V + direct`, `C += r y / S`, `J += r^2 / S`, `V -= K r` of many vectors V at once; `T` divides
/// the length of a chunk.
fn hear<const N: usize, const T: usize>(
    chunks: &mut [Chunk<N>],
    c: &mut [f32],
    j: &mut [f32],
    heard: &Heard<'_, N, T>,
) {
    let direct: [f32; CHUNK] = core::array::from_fn(|i| heard.direct[i % T] as f32);
    let (by_innovation, by_response) =
        ((heard.innovation / heard.s) as f32, (1.0 / heard.s) as f32);
    let sums = c.chunks_exact_mut(CHUNK).zip(j.chunks_exact_mut(CHUNK));
    for (chunk, (c, j)) in chunks.iter_mut().zip(sums) {
        let v = &mut chunk.data.0;
        let mut response: [f32; CHUNK] = combine(v, heard.row.iter());
        for i in 0..CHUNK {
            response[i] += direct[i];
            c[i] += by_innovation * response[i];
            j[i] += response[i] * response[i] * by_response;
        }
        let states = v.iter_mut().zip(heard.gain.as_slice());
        for (column, &gain) in states.filter(|(_, gain)| **gain != 0.0) {
            let gain = gain as f32;
            for i in 0..CHUNK {
                column[i] -= gain * response[i];
            }
        }
    }
}
}

#[cfg(test)]
mod tests {
    use super::*;

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
        reduce::<N, 16, 2>(&mut reduced, &[(&gains[0], 1.0), (&gains[1], 1.0)]);
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
        for rows in [0, 1, 4, 5, 12, 13, 16] {
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
