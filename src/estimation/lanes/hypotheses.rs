//! The loops over the hypotheses of a monitor.

use nalgebra::{SMatrix, SVector};

#[cfg(target_arch = "x86_64")]
use super::SMALL;
use super::{combine, combine_three};
use crate::estimation::belief::{Column, Row, states_in};
use crate::estimation::transition::{GROUPS, Transition};

/// How many hypotheses a monitor has; a sum for each of them fits into the registers.
pub(in crate::estimation) const HYPOTHESES: usize = 64;

/// A vector for each hypothesis: column i contains their components i. Single precision is enough to
/// distinguish them.
pub(in crate::estimation) type Vectors<const N: usize> = SMatrix<f32, HYPOTHESES, N>;
/// A number for each hypothesis.
pub(in crate::estimation) type Numbers = SVector<f32, HYPOTHESES>;

/// Hypotheses of which the new errors are computed at a time.
const TOGETHER: usize = 32;

for_any_width! {
/// `v <- F v` of many vectors v at once.
fn advance<const N: usize>(vectors: &mut Vectors<N>, f: &Transition<N>) {
    let v = &mut vectors.data.0;
    let mut rows = [[[0.0_f32; N]; 3]; GROUPS];
    for (group, rows) in f.groups().iter().zip(&mut rows) {
        for r in 0..3 {
            for k in 0..N {
                rows[r][k] = group.rows[r][k] as f32;
            }
        }
    }
    for from in (0..HYPOTHESES).step_by(TOGETHER) {
        let mut changed = [[[0.0; TOGETHER]; 3]; GROUPS];
        for (g, group) in f.groups().iter().enumerate() {
            changed[g] =
                combine_three::<_, N, HYPOTHESES, TOGETHER>(&rows[g], group.support, v, from);
        }
        for (group, changed) in f.groups().iter().zip(&changed) {
            for (state, changed) in group.states().zip(changed) {
                v[state][from..from + TOGETHER].copy_from_slice(changed);
            }
        }
    }
    for (state, factor) in f.scaled() {
        let factor = factor as f32;
        v[state].iter_mut().for_each(|x| *x *= factor);
    }
}
}

/// The same numbers for the thrusters of each restart.
#[inline(always)]
fn for_each_restart<const T: usize>(thrusters: [f32; T]) -> [f32; HYPOTHESES] {
    let mut all = [0.0; HYPOTHESES];
    all.chunks_exact_mut(T).for_each(|restart| restart.copy_from_slice(&thrusters));
    all
}

for_any_width! {
/// `v <- v - B i` of a set of states of many vectors v, with the effects B of the `T` thrusters and the
/// impulses i that they lose.
fn drive<const N: usize, const T: usize>(
    vectors: &mut Vectors<N>,
    states: u64,
    effect: &SMatrix<f64, T, N>,
    impulses: &[f64; T],
) {
    for state in states_in(states) {
        let own = &effect.data.0[state];
        let changes = for_each_restart::<T>(core::array::from_fn(|i| (own[i] * impulses[i]) as f32));
        let v = &mut vectors.data.0[state];
        for i in 0..HYPOTHESES {
            v[i] -= changes[i];
        }
    }
}
}

/// A scalar measurement that was fused: its row h, the gain K, the innovation y and its variance S; and
/// the direct effect on it of the thrust that each thruster loses.
pub(in crate::estimation) struct Heard<'a, const N: usize, const T: usize> {
    pub(in crate::estimation) row: &'a Row<N>,
    pub(in crate::estimation) gain: &'a Column<N>,
    pub(in crate::estimation) innovation: f64,
    pub(in crate::estimation) s: f64,
    pub(in crate::estimation) direct: &'a [f64; T],
}

for_any_width! {
/// `r = h^T V + direct`, `C += r y / S`, `J += r^2 / S`, `V -= K r` of many vectors V at once, which
/// repeat the order of the `T` thrusters.
fn hear<const N: usize, const T: usize>(
    vectors: &mut Vectors<N>,
    c: &mut Numbers,
    j: &mut Numbers,
    heard: &Heard<'_, N, T>,
) {
    let v = &mut vectors.data.0;
    let mut response: [f32; HYPOTHESES] = combine(v, heard.row.iter());
    let direct = for_each_restart(heard.direct.map(|effect| effect as f32));
    let (by_innovation, by_response) =
        ((heard.innovation / heard.s) as f32, (1.0 / heard.s) as f32);
    for i in 0..HYPOTHESES {
        response[i] += direct[i];
        c[i] += by_innovation * response[i];
        j[i] += response[i] * response[i] * by_response;
    }
    let states = v.iter_mut().zip(heard.gain.as_slice());
    for (column, &gain) in states.filter(|(_, gain)| **gain != 0.0) {
        let gain = gain as f32;
        for i in 0..HYPOTHESES {
            column[i] -= gain * response[i];
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

    #[test]
    fn hypotheses_advance_by_the_dense_matrix() {
        let mut f = Transition::<N>::identity();
        for i in [0, 1, 2, 4, 5, 8] {
            f.set_row(i, [(i, 0.9), (i + 2, number(i, 3)), (19, number(i, 4))]);
        }
        f.scale(17, 0.5);
        let before = Vectors::<N>::from_fn(|k, i| number(k, i) as f32);
        let mut after = before;
        advance(&mut after, &f);
        let want = before.map(f64::from) * f.dense().transpose();
        assert!((after.map(f64::from) - want).amax() < 1e-4, "{}", after.map(f64::from) - want);
    }
}
