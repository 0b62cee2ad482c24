//! The transition matrix F of a prediction, kept as its non-zero elements.
//!
//! Most states only depend on themselves; F P F^T costs in proportion to the elements that say
//! otherwise. Elements are given row by row.

use nalgebra::{Matrix3, SMatrix};

use super::belief::{Column, add_scaled};

/// Elements off the diagonal that there is room for.
const ELEMENTS: usize = 144;
/// Rows with such elements.
const ROWS: usize = 16;

/// F: a diagonal, and rows with elements beside it.
#[derive(Clone, Copy, Debug)]
pub struct Transition<const N: usize> {
    diagonal: Column<N>,
    rows: [Row; ROWS],
    row_count: usize,
    columns: [u8; ELEMENTS],
    values: [f64; ELEMENTS],
    element_count: usize,
    /// Whether a row without elements has a diagonal other than one.
    scaled: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Row {
    state: u8,
    from: u8,
    to: u8,
}

impl<const N: usize> Transition<N> {
    /// The identity: nothing changes.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            diagonal: Column::repeat(1.0),
            rows: [Row::default(); ROWS],
            row_count: 0,
            columns: [0; ELEMENTS],
            values: [0.0; ELEMENTS],
            element_count: 0,
            scaled: false,
        }
    }

    /// A state that depends on its own past alone: `x <- factor x`.
    pub fn scale(&mut self, state: usize, factor: f64) {
        self.diagonal[state] = factor;
        self.scaled = true;
    }

    /// Sets the rows of three states in a row: blocks of derivatives by three states in a row, each
    /// given with the first of them.
    pub fn set_rows<'a>(
        &mut self,
        state: usize,
        blocks: impl IntoIterator<Item = &'a (usize, Matrix3<f64>)> + Clone,
    ) {
        for i in 0..3 {
            let elements =
                |(from, m): &'a (usize, Matrix3<f64>)| [0, 1, 2].map(|j| (from + j, m[(i, j)]));
            self.set_row(state + i, blocks.clone().into_iter().flat_map(elements));
        }
    }

    /// Sets the row of a state: pairs of a state and the derivative by it. Rows are set once each.
    pub fn set_row(&mut self, state: usize, row: impl IntoIterator<Item = (usize, f64)>) {
        let from = self.element_count as u8;
        self.diagonal[state] = 0.0;
        row.into_iter().for_each(|(column, value)| {
            if column == state {
                self.diagonal[state] += value;
            } else if value != 0.0 && self.element_count < ELEMENTS {
                self.columns[self.element_count] = column as u8;
                self.values[self.element_count] = value;
                self.element_count += 1;
            }
        });
        if self.row_count < ROWS {
            let to = self.element_count as u8;
            self.rows[self.row_count] = Row { state: state as u8, from, to };
            self.row_count += 1;
        }
    }

    /// Each row with its elements off the diagonal.
    fn rows(&self) -> impl Iterator<Item = (usize, impl Iterator<Item = (usize, f64)> + Clone)> {
        self.rows[..self.row_count].iter().map(|row| {
            let range = row.from as usize..row.to as usize;
            let columns = self.columns[range.clone()].iter().map(|&column| column as usize);
            (row.state as usize, columns.zip(self.values[range].iter().copied()))
        })
    }

    /// The matrix with all its zeros.
    #[must_use]
    pub fn dense(&self) -> SMatrix<f64, N, N> {
        let mut f = SMatrix::from_diagonal(&self.diagonal);
        for (i, elements) in self.rows() {
            for (j, value) in elements {
                f[(i, j)] = value;
            }
        }
        f
    }

    /// `F v`.
    #[must_use]
    pub fn apply(&self, v: &Column<N>) -> Column<N> {
        let mut result = self.diagonal.component_mul(v);
        for (i, elements) in self.rows() {
            result[i] += elements.map(|(j, value)| value * v[j]).sum::<f64>();
        }
        result
    }

    /// `F^T v`.
    #[must_use]
    pub fn apply_transposed(&self, v: &Column<N>) -> Column<N> {
        let mut result = self.diagonal.component_mul(v);
        for (i, elements) in self.rows() {
            for (j, value) in elements {
                result[j] += value * v[i];
            }
        }
        result
    }

    /// `v <- F v` of many vectors at once; column i of `v` holds their components i.
    pub(super) fn apply_to_columns<const K: usize>(&self, v: &mut SMatrix<f64, K, N>) {
        let mut changed = [[0.0; K]; ROWS];
        let is_row = self.combine(v.as_slice(), K, &mut changed);
        let v = v.as_mut_slice();
        for ((i, _), column) in self.rows().zip(&changed) {
            v[i * K..(i + 1) * K].copy_from_slice(column);
        }
        for i in (0..N).filter(|&i| self.scaled && !is_row[i] && self.diagonal[i] != 1.0) {
            v[i * K..(i + 1) * K].iter_mut().for_each(|x| *x *= self.diagonal[i]);
        }
    }

    /// `P <- F P F^T` of a symmetric P, of which the first `order` rows and columns count.
    pub(super) fn propagate(&self, p: &mut SMatrix<f64, N, N>, order: usize) {
        let mut changed = [[0.0; N]; ROWS];
        let is_row = self.combine(p.as_slice(), order, &mut changed);
        let scaled = (0..order).filter(|&i| self.scaled && !is_row[i] && self.diagonal[i] != 1.0);
        for i in scaled {
            for j in 0..order {
                p[(j, i)] *= self.diagonal[i];
                p[(i, j)] *= self.diagonal[i];
            }
        }
        // `changed` holds columns of P F^T; F from the left matters in the rows that it changes.
        for (a, (i, elements)) in self.rows().enumerate() {
            for (b, row) in self.rows[..self.row_count].iter().enumerate().skip(a) {
                let (j, column) = (row.state as usize, &changed[b]);
                let mut sum = self.diagonal[i] * column[i];
                for (k, value) in elements.clone() {
                    sum += value * column[k];
                }
                p[(i, j)] = sum;
                p[(j, i)] = sum;
            }
        }
        for (a, row) in self.rows[..self.row_count].iter().enumerate() {
            let i = row.state as usize;
            for j in (0..order).filter(|&j| !is_row[j]) {
                let value = self.diagonal[j] * changed[a][j];
                p[(j, i)] = value;
                p[(i, j)] = value;
            }
        }
    }

    /// The first `order` elements of the columns of `V F^T` for the rows of F that are not diagonal, V
    /// of `K` rows; and which they are.
    fn combine<const K: usize>(
        &self,
        v: &[f64],
        order: usize,
        into: &mut [[f64; K]; ROWS],
    ) -> [bool; N] {
        let column = |k: usize| &v[k * K..k * K + order];
        let mut is_row = [false; N];
        for ((i, elements), sum) in self.rows().zip(into) {
            is_row[i] = true;
            let own = self.diagonal[i];
            for (s, value) in sum.iter_mut().zip(column(i)) {
                *s = own * value;
            }
            for (k, factor) in elements {
                add_scaled(sum, factor, column(k));
            }
        }
        is_row
    }
}
