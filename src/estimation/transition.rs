//! The transition matrix F of a prediction, kept as its non-zero elements.
//!
//! Most states depend only on themselves; the cost of F P F^T is proportional to the other
//! elements. Elements are given row by row.

use nalgebra::{Matrix3, SMatrix};

use super::belief::{Column, states_in};
use super::lanes::{propagate, with_length};

/// Capacity for elements in rows.
const ELEMENTS: usize = 160;
/// Rows with more than a diagonal element.
pub(super) const ROWS: usize = 16;
/// Numbers of such rows for which code is generated: a change of one state, a prediction.
const FEW: usize = 4;
const MORE: usize = 12;

/// F: a diagonal, and rows with more than that.
#[derive(Clone, Copy, Debug)]
pub struct Transition<const N: usize> {
    /// Zero for the states that have a row.
    diagonal: Column<N>,
    rows: [Row; ROWS],
    row_count: usize,
    columns: [u8; ELEMENTS],
    values: [f64; ELEMENTS],
    element_count: usize,
    /// Bit i: state i has no row, and its diagonal element is not one.
    scaled: u64,
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
            scaled: 0,
        }
    }

    /// A state that depends only on its own past, and has no row: `x <- factor x`.
    pub fn scale(&mut self, state: usize, factor: f64) {
        self.diagonal[state] = factor;
        self.scaled |= 1 << state;
    }

    /// Sets the rows of three consecutive states: blocks of derivatives by three consecutive
    /// states, each given with the first of them.
    pub fn set_rows<'a>(
        &mut self,
        state: usize,
        blocks: impl IntoIterator<Item = &'a (usize, Matrix3<f64>)> + Clone,
    ) {
        for i in state..state + 3 {
            let from = self.element_count;
            let mut own = 0.0;
            for (first, by) in blocks.clone() {
                for j in 0..3 {
                    let value = by[(i - state, j)];
                    if first + j == i { own += value } else { self.push(first + j, value) }
                }
            }
            self.end_row(i, from, own);
        }
    }

    /// Sets the row of a state: pairs of a state and the derivative by it. Rows are set once each.
    pub fn set_row(&mut self, state: usize, row: impl IntoIterator<Item = (usize, f64)>) {
        let from = self.element_count;
        let mut own = 0.0;
        for (column, value) in row {
            if column == state { own += value } else { self.push(column, value) }
        }
        self.end_row(state, from, own);
    }

    fn end_row(&mut self, state: usize, from: usize, own: f64) {
        self.push(state, own);
        self.diagonal[state] = 0.0;
        if self.row_count < ROWS {
            let (from, to) = (from as u8, self.element_count as u8);
            self.rows[self.row_count] = Row { state: state as u8, from, to };
            self.row_count += 1;
        }
    }

    fn push(&mut self, column: usize, value: f64) {
        if value != 0.0 && self.element_count < ELEMENTS {
            self.columns[self.element_count] = column as u8;
            self.values[self.element_count] = value;
            self.element_count += 1;
        }
    }

    /// The states that have a row, each with its elements: a state and the derivative by it.
    #[inline(always)]
    pub(super) fn rows(
        &self,
    ) -> impl Iterator<Item = (usize, impl Iterator<Item = (usize, f64)> + Clone)> {
        self.rows[..self.row_count].iter().map(|row| {
            let range = row.from as usize..row.to as usize;
            let columns = self.columns[range.clone()].iter().map(|&column| column as usize);
            (row.state as usize, columns.zip(self.values[range].iter().copied()))
        })
    }

    /// The states that have no row, but a factor other than one.
    #[inline(always)]
    pub(super) fn scaled(&self) -> impl Iterator<Item = (usize, f64)> {
        states_in(self.scaled).map(|state| (state, self.diagonal[state]))
    }

    /// The full matrix, including zeros.
    #[must_use]
    pub fn dense(&self) -> SMatrix<f64, N, N> {
        let mut f = SMatrix::from_diagonal(&self.diagonal);
        for (i, elements) in self.rows() {
            for (j, value) in elements {
                f[(i, j)] += value;
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

    /// `P <- F P F^T` of a symmetric P, in which only the first `order` rows and columns count; all
    /// others are zero.
    pub(super) fn propagate(&self, p: &mut SMatrix<f64, N, N>, order: usize) {
        let p = &mut p.data.0;
        if self.row_count <= FEW {
            with_length!(order, N, propagate::<FEW>(p, self));
        } else if self.row_count <= MORE {
            with_length!(order, N, propagate::<MORE>(p, self));
        } else {
            with_length!(order, N, propagate::<ROWS>(p, self));
        }
    }
}
