//! Vectors, rotations and means of any number type, and their derivatives by dual numbers.

use num_dual::{Dual64, DualNum};

pub trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

pub type V3<D> = [D; 3];
pub type M3<D> = [[D; 3]; 3];

pub fn lift<D: Number, const K: usize>(v: [f64; K]) -> [D; K] {
    v.map(D::from)
}

pub fn plus<D: Number, const K: usize>(a: [D; K], b: [D; K]) -> [D; K] {
    core::array::from_fn(|i| a[i] + b[i])
}

pub fn minus<D: Number, const K: usize>(a: [D; K], b: [D; K]) -> [D; K] {
    core::array::from_fn(|i| a[i] - b[i])
}

pub fn times<D: Number, const K: usize>(a: [D; K], s: impl Into<D>) -> [D; K] {
    let s = s.into();
    a.map(|x| x * s)
}

pub fn cross<D: Number>(a: V3<D>, b: V3<D>) -> V3<D> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn image<D: Number>(m: &M3<D>, v: V3<D>) -> V3<D> {
    core::array::from_fn(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

pub fn transposed<D: Number>(m: &M3<D>) -> M3<D> {
    core::array::from_fn(|i| core::array::from_fn(|j| m[j][i]))
}

/// Quaternion of a rotation vector: a series at zero angle, so that its derivative exists.
pub fn exp<D: Number>(phi: V3<D>) -> [D; 4] {
    let square: D = phi.iter().map(|&x| x * x).sum();
    let (w, scale) = if square.re() < 1e-12 {
        (-square / 8.0 + 1.0, -square / 48.0 + 0.5)
    } else {
        let angle = square.sqrt();
        ((angle / 2.0).cos(), (angle / 2.0).sin() / angle)
    };
    [w, phi[0] * scale, phi[1] * scale, phi[2] * scale]
}

pub fn product<D: Number>([a, x, y, z]: [D; 4], [b, u, v, w]: [D; 4]) -> [D; 4] {
    [
        a * b - x * u - y * v - z * w,
        a * u + x * b + y * w - z * v,
        a * v + y * b + z * u - x * w,
        a * w + z * b + x * v - y * u,
    ]
}

/// Rotation vector of a quaternion near one.
fn small_log<D: Number>([w, x, y, z]: [D; 4]) -> V3<D> {
    [x, y, z].map(|c| c * 2.0 / w)
}

/// R of a unit quaternion: `v -> q (0, v) q*`.
pub fn matrix<D: Number>(q: [D; 4]) -> M3<D> {
    let conjugate = [q[0], -q[1], -q[2], -q[3]];
    let column = |j: usize| {
        let unit = core::array::from_fn(|i| D::from(if i == j + 1 { 1.0 } else { 0.0 }));
        product(product(q, unit), conjugate)
    };
    let columns = [column(0), column(1), column(2)];
    core::array::from_fn(|i| core::array::from_fn(|j| columns[j][i + 1]))
}

/// R of roll, pitch, yaw: three rotations one after the other.
pub fn euler_matrix<D: Number>([roll, pitch, yaw]: V3<D>) -> M3<D> {
    let (o, z) = (D::one(), D::zero());
    let about_x = [[o, z, z], [z, roll.cos(), -roll.sin()], [z, roll.sin(), roll.cos()]];
    let about_y = [[pitch.cos(), z, pitch.sin()], [z, o, z], [-pitch.sin(), z, pitch.cos()]];
    let about_z = [[yaw.cos(), -yaw.sin(), z], [yaw.sin(), yaw.cos(), z], [z, z, o]];
    matrix_product(&about_z, &matrix_product(&about_y, &about_x))
}

pub fn matrix_product<D: Number>(a: &M3<D>, b: &M3<D>) -> M3<D> {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])
    })
}

/// A mean: numbers, and an attitude whose error is three of them starting at `theta`.
#[derive(Clone, Copy, Debug)]
pub struct Point<D, const N: usize> {
    pub x: [D; N],
    pub q: [D; 4],
    pub theta: Option<usize>,
}

impl<const N: usize> Point<f64, N> {
    /// Moved by an error: `x + e`, `q Exp(e_theta)`.
    fn moved(&self, e: &[Dual64; N]) -> Point<Dual64, N> {
        let mut x = plus(lift(self.x), *e);
        let mut q = lift(self.q);
        if let Some(t) = self.theta {
            (0..3).for_each(|i| x[t + i] = Dual64::from(0.0));
            q = product(q, exp([e[t], e[t + 1], e[t + 2]]));
        }
        Point { x, q, theta: self.theta }
    }

    /// The error that leads from here to another mean.
    fn error_of(&self, other: &Point<Dual64, N>) -> [Dual64; N] {
        let mut e = minus(other.x, lift(self.x));
        if let Some(t) = self.theta {
            let [w, x, y, z]: [Dual64; 4] = lift(self.q);
            let turn = small_log(product([w, -x, -y, -z], other.q));
            e[t..t + 3].copy_from_slice(&turn);
        }
        e
    }

    /// Derivatives of a function of the mean by its error.
    pub fn rows<const M: usize>(
        &self,
        f: impl Fn(&Point<Dual64, N>) -> [Dual64; M],
    ) -> [[f64; N]; M] {
        let mut rows = [[0.0; N]; M];
        for j in 0..N {
            let e = core::array::from_fn(|i| Dual64::new(0.0, if i == j { 1.0 } else { 0.0 }));
            for (row, value) in rows.iter_mut().zip(f(&self.moved(&e))) {
                row[j] = value.eps;
            }
        }
        rows
    }

    /// Derivatives of the error of a later mean by the error of this one.
    pub fn transition(&self, f: impl Fn(&Point<Dual64, N>) -> Point<Dual64, N>) -> [[f64; N]; N] {
        let later = f(&self.moved(&[Dual64::from(0.0); N]));
        let base = Point { x: later.x.map(|d| d.re), q: later.q.map(|d| d.re), theta: self.theta };
        self.rows(|p| base.error_of(&f(p)))
    }
}

pub(super) fn part<D: Number, const N: usize>(x: &[D; N], from: usize) -> V3<D> {
    [x[from], x[from + 1], x[from + 2]]
}
