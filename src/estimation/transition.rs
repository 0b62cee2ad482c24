//! The transition matrix F of a prediction, kept as its non-zero elements.
//!
//! Most states depend only on themselves; the cost of F P F^T is proportional to the number of the
//! others, which come in groups of three consecutive states, such as the axes of a vector.

use nalgebra::{ArrayStorage, Matrix3, SMatrix, Vector3};

use super::belief::{Column, states_in};
use super::lanes::{propagate, with_length};

/// Capacity for groups of states.
pub(super) const GROUPS: usize = 3;

/// F: a diagonal, and groups of rows with more than that.
#[derive(Clone, Copy, Debug)]
pub struct Transition<const N: usize> {
    /// Zero for the states of the groups.
    diagonal: Column<N>,
    groups: [Group<N>; GROUPS],
    group_count: usize,
    /// Bit i: state i is in no group, and its diagonal element is not one.
    scaled: u64,
}

/// Rows of up to three consecutive states.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<const N: usize> {
    /// The first state, and how many there are.
    first: usize,
    size: usize,
    /// Derivatives of each by the states.
    pub(super) rows: [[f64; N]; 3],
    /// Bit i: a derivative by state i may be non-zero.
    pub(super) support: u64,
}

impl<const N: usize> Group<N> {
    /// All of a transition's groups at once, so that one block of memory is cleared.
    const NONE: [Self; GROUPS] =
        [Self { first: 0, size: 0, rows: [[0.0; N]; 3], support: 0 }; GROUPS];

    /// Its states.
    #[inline(always)]
    pub(super) fn states(&self) -> core::ops::Range<usize> {
        self.first..self.first + self.size
    }

    /// The states with non-zero derivatives, each with the derivatives by it.
    #[inline(always)]
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, [f64; 3])> {
        states_in(self.support).map(|state| (state, [0, 1, 2].map(|i| self.rows[i][state])))
    }

    /// Sets the derivatives by three consecutive states.
    #[inline(always)]
    pub(super) fn set(&mut self, first: usize, by: &Matrix3<f64>) {
        for (i, row) in self.rows.iter_mut().enumerate() {
            row[first..first + 3].copy_from_slice(&[by[(i, 0)], by[(i, 1)], by[(i, 2)]]);
        }
        self.support |= 0b111 << first;
    }

    /// Sets the derivatives by one state.
    #[inline(always)]
    pub(super) fn set_column(&mut self, state: usize, by: &Vector3<f64>) {
        (0..3).for_each(|i| self.rows[i][state] = by[i]);
        self.support |= 1 << state;
    }
}

impl<const N: usize> Transition<N> {
    const ONES: Column<N> = Column::from_array_storage(ArrayStorage([[1.0; N]]));

    /// The identity: nothing changes.
    #[must_use]
    #[inline]
    pub fn identity() -> Self {
        Self { diagonal: Self::ONES, groups: Group::NONE, group_count: 0, scaled: 0 }
    }

    /// A state that depends only on its own past, and is in no group: `x <- factor x`.
    pub fn scale(&mut self, state: usize, factor: f64) {
        self.diagonal[state] = factor;
        self.scaled |= 1 << state;
    }

    /// Sets the rows of three consecutive states: blocks of derivatives by three consecutive
    /// states, each given with the first of them.
    ///
    /// # Panics
    /// If there are too many rows.
    #[inline]
    pub fn set_rows<'a>(
        &mut self,
        state: usize,
        blocks: impl IntoIterator<Item = &'a (usize, Matrix3<f64>)>,
    ) {
        let group = self.add_group(state, 3, 0);
        blocks.into_iter().for_each(|(first, by)| group.set(*first, by));
    }

    /// Sets the row of a state: pairs of a state and the derivative by it. Rows are set once each.
    ///
    /// # Panics
    /// If there are too many rows.
    #[inline]
    pub fn set_row(&mut self, state: usize, row: impl IntoIterator<Item = (usize, f64)>) {
        let last = self.groups().last();
        let group = match last.filter(|g| g.size < 3 && g.states().end == state) {
            Some(_) => &mut self.groups[self.group_count - 1],
            None => self.add_group(state, 0, 0),
        };
        let own = group.size;
        group.size += 1;
        for (column, value) in row {
            group.rows[own][column] = value;
            group.support |= 1 << column;
        }
        self.diagonal[state] = 0.0;
    }

    /// A group of up to three consecutive states, whose rows the caller fills in: derivatives by the
    /// states of a set, where bit i is state i.
    ///
    /// # Panics
    /// If there are too many rows.
    #[inline]
    pub(super) fn add_group(&mut self, first: usize, size: usize, support: u64) -> &mut Group<N> {
        let group = &mut self.groups[self.group_count];
        self.group_count += 1;
        (group.first, group.size, group.support) = (first, size, support);
        group.states().for_each(|state| self.diagonal[state] = 0.0);
        group
    }

    /// The groups of states that depend on others.
    #[inline(always)]
    pub(super) fn groups(&self) -> &[Group<N>] {
        &self.groups[..self.group_count]
    }

    /// The states in no group that have a factor other than one.
    #[inline(always)]
    pub(super) fn scaled(&self) -> impl Iterator<Item = (usize, f64)> {
        states_in(self.scaled).map(|state| (state, self.diagonal[state]))
    }

    /// The full matrix, including zeros.
    #[must_use]
    pub fn dense(&self) -> SMatrix<f64, N, N> {
        let mut f = SMatrix::from_diagonal(&self.diagonal);
        for group in self.groups() {
            for (j, by) in group.iter() {
                group.states().zip(by).for_each(|(i, value)| f[(i, j)] = value);
            }
        }
        f
    }

    /// `F v`.
    #[must_use]
    pub fn apply(&self, v: &Column<N>) -> Column<N> {
        let mut result = self.diagonal.component_mul(v);
        for group in self.groups() {
            for (j, by) in group.iter() {
                group.states().zip(by).for_each(|(i, value)| result[i] += value * v[j]);
            }
        }
        result
    }

    /// `F^T v`.
    #[must_use]
    pub fn apply_transposed(&self, v: &Column<N>) -> Column<N> {
        let mut result = self.diagonal.component_mul(v);
        for group in self.groups() {
            for (j, by) in group.iter() {
                group.states().zip(by).for_each(|(i, value)| result[j] += value * v[i]);
            }
        }
        result
    }

    /// `P <- F P F^T` of a symmetric P, in which only the first `order` rows and columns count; all
    /// others are zero.
    pub(super) fn propagate(&self, p: &mut SMatrix<f64, N, N>, order: usize) {
        with_length!(order, N, propagate(&mut p.data.0, self));
    }
}
