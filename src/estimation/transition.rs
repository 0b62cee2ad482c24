//! The transition matrix F of a prediction, kept as its non-zero elements.
//!
//! Most states only depend on themselves; F P F^T costs in proportion to the elements that say
//! otherwise. Elements are given row by row.

use nalgebra::SMatrix;

use super::belief::Column;

/// Elements off the diagonal that there is room for.
const ELEMENTS: usize = 160;
/// Rows with such elements.
const ROWS: usize = 16;

/// F: a diagonal, and rows with elements beside it.
#[derive(Clone, Copy, Debug)]
pub struct Transition<const N: usize> {
    diagonal: Column<N>,
    rows: [Row; ROWS],
    row_count: usize,
    elements: [(u8, f64); ELEMENTS],
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
            elements: [(0, 0.0); ELEMENTS],
            element_count: 0,
            scaled: false,
        }
    }

    /// A state that depends on its own past alone: `x <- factor x`.
    pub fn scale(&mut self, state: usize, factor: f64) {
        self.diagonal[state] = factor;
        self.scaled = true;
    }

    /// Sets the row of a state: pairs of a state and the derivative by it. Rows are set once each.
    pub fn set_row(&mut self, state: usize, row: impl IntoIterator<Item = (usize, f64)>) {
        let from = self.element_count as u8;
        self.diagonal[state] = 0.0;
        for (column, value) in row {
            if column == state {
                self.diagonal[state] += value;
            } else if value != 0.0 && self.element_count < ELEMENTS {
                self.elements[self.element_count] = (column as u8, value);
                self.element_count += 1;
            }
        }
        if self.row_count < ROWS {
            let to = self.element_count as u8;
            self.rows[self.row_count] = Row { state: state as u8, from, to };
            self.row_count += 1;
        }
    }

    fn rows(&self) -> impl Iterator<Item = (usize, &[(u8, f64)])> {
        self.rows[..self.row_count].iter().map(|row| {
            (row.state as usize, &self.elements[row.from as usize..row.to as usize])
        })
    }

    /// The matrix with all its zeros.
    #[must_use]
    pub fn dense(&self) -> SMatrix<f64, N, N> {
        let mut f = SMatrix::from_diagonal(&self.diagonal);
        for (i, elements) in self.rows() {
            for &(j, value) in elements {
                f[(i, j as usize)] = value;
            }
        }
        f
    }

    /// `F v`.
    #[must_use]
    pub fn apply(&self, v: &Column<N>) -> Column<N> {
        let mut result = self.diagonal.component_mul(v);
        for (i, elements) in self.rows() {
            result[i] += elements.iter().map(|&(j, value)| value * v[j as usize]).sum::<f64>();
        }
        result
    }

    /// `F^T v`.
    #[must_use]
    pub fn apply_transposed(&self, v: &Column<N>) -> Column<N> {
        let mut result = self.diagonal.component_mul(v);
        for (i, elements) in self.rows() {
            for &(j, value) in elements {
                result[j as usize] += value * v[i];
            }
        }
        result
    }

    /// `P <- F P F^T` of a symmetric P whose first `order` states exist.
    pub(super) fn propagate(&self, p: &mut SMatrix<f64, N, N>, order: usize) {
        let mut changed = [[0.0; N]; ROWS];
        let mut is_row = [false; N];
        for ((i, elements), column) in self.rows().zip(&mut changed) {
            is_row[i] = true;
            self.combine(p, i, elements, order, column);
        }
        if self.scaled {
            for i in (0..order).filter(|&i| !is_row[i] && self.diagonal[i] != 1.0) {
                for j in 0..order {
                    p[(j, i)] *= self.diagonal[i];
                    p[(i, j)] *= self.diagonal[i];
                }
            }
        }
        // `changed` holds P F^T; F from the left only matters in the rows that are not the diagonal.
        for (a, (i, elements)) in self.rows().enumerate() {
            for (b, (j, _)) in self.rows().enumerate().skip(a) {
                let column = &changed[b];
                let mut sum = self.diagonal[i] * column[i];
                for &(k, value) in elements {
                    sum += value * column[k as usize];
                }
                p[(i, j)] = sum;
                p[(j, i)] = sum;
            }
            for j in (0..order).filter(|&j| !is_row[j]) {
                let value = self.diagonal[j] * changed[a][j];
                p[(i, j)] = value;
                p[(j, i)] = value;
            }
        }
    }

    /// Column `i` of P F^T.
    #[inline]
    fn combine(
        &self,
        p: &SMatrix<f64, N, N>,
        i: usize,
        elements: &[(u8, f64)],
        order: usize,
        into: &mut [f64; N],
    ) {
        let p = p.as_slice();
        let own = self.diagonal[i];
        for (sum, value) in into.iter_mut().zip(&p[i * N..i * N + order]) {
            *sum = own * value;
        }
        for &(k, factor) in elements {
            let k = k as usize;
            for (sum, value) in into.iter_mut().zip(&p[k * N..k * N + order]) {
                *sum += factor * value;
            }
        }
    }
}
