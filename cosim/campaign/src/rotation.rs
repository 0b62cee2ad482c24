//! Vectors and rotations in space.

/// A vector.
pub(super) type Vector = [f64; 3];

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

pub(super) fn norm([x, y, z]: Vector) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// The rows of an orthogonal matrix.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rotation([Vector; 3]);

impl Rotation {
    pub(super) const NONE: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// By an angle about the third axis (rad).
    pub(super) fn about_third(angle: f64) -> Self {
        let (sine, cosine) = libm::sincos(angle);
        Self([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    }

    /// A rotated vector.
    pub(super) fn of(&self, [x, y, z]: Vector) -> Vector {
        self.0.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }

    /// The one that brings vectors closest to others in the least-squares sense, from the sums of
    /// the products of their elements: `products[i][j]` is that of element i of the others and
    /// element j of the vectors.
    ///
    /// Its quaternion is the eigenvector of the greatest eigenvalue of a symmetric matrix (Horn,
    /// Closed-form solution of absolute orientation using unit quaternions, 1987, section 4).
    pub(super) fn closest(products: [Vector; 3]) -> Self {
        let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = products;
        let [w, x, y, z] = principal([
            [xx + yy + zz, yz - zy, zx - xz, xy - yx],
            [yz - zy, xx - yy - zz, xy + yx, zx + xz],
            [zx - xz, xy + yx, yy - xx - zz, yz + zy],
            [xy - yx, zx + xz, yz + zy, zz - xx - yy],
        ]);
        Self([
            [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ])
    }
}

/// More sweeps than double precision needs: convergence is quadratic.
const SWEEPS: usize = 50;

/// The eigenvector of the greatest eigenvalue of a symmetric matrix, by Jacobi's rotations (Golub
/// and Van Loan, Matrix Computations, 8.5).
fn principal(mut matrix: [[f64; 4]; 4]) -> [f64; 4] {
    // Its rows become the eigenvectors.
    let mut vectors: [[f64; 4]; 4] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            if matrix[p][q] == 0.0 {
                continue;
            }
            let tau = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
            let tangent = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            let sine = tangent * cosine;
            let rotate = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
            for row in &mut matrix {
                (row[p], row[q]) = rotate(row[p], row[q]);
            }
            for rows in [&mut matrix, &mut vectors] {
                let pairs: [_; 4] = std::array::from_fn(|i| rotate(rows[p][i], rows[q][i]));
                (rows[p], rows[q]) = (pairs.map(|(a, _)| a), pairs.map(|(_, b)| b));
            }
            (matrix[p][q], matrix[q][p]) = (0.0, 0.0);
        }
    }
    let greatest = (0..4).max_by(|a, b| matrix[*a][*a].total_cmp(&matrix[*b][*b]));
    greatest.map_or([1.0, 0.0, 0.0, 0.0], |place| vectors[place])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of products of some vectors, rotated, with themselves.
    fn products(rotation: Rotation, vectors: &[Vector]) -> [Vector; 3] {
        let mut sums = [[0.0; 3]; 3];
        for vector in vectors {
            let rotated = rotation.of(*vector);
            for i in 0..3 {
                (0..3).for_each(|j| sums[i][j] += rotated[i] * vector[j]);
            }
        }
        sums
    }

    #[test]
    fn a_rotation_is_found_again() {
        let vectors = [[1.0, 2.0, -0.5], [-3.0, 0.4, 2.0], [0.3, -2.4, -1.5], [1.7, 0.0, 0.0]];
        let flat = [[1.0, 2.0, 0.0], [-3.0, 0.4, 0.0], [2.0, -2.4, 0.0]];
        // Half a turn about an axis between the first two; turns about each axis; none.
        let turns = [
            Rotation([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
            Rotation([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
            Rotation::about_third(2.5),
            Rotation::about_third(-1e-9),
            Rotation::NONE,
        ];
        for turn in turns {
            for points in [&vectors[..], &flat] {
                let found = Rotation::closest(products(turn, points));
                for point in points {
                    let apart = norm(minus(found.of(*point), turn.of(*point)));
                    assert!(apart < 1e-14, "{turn:?} {apart:e}");
                }
            }
        }
    }

    #[test]
    fn the_closest_is_never_a_reflection() {
        let vectors = [[1.0, 2.0, -0.5], [-3.0, 0.4, 2.0], [0.3, -2.4, -1.5]];
        let mirrored = Rotation([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let [a, b, c] = Rotation::closest(products(mirrored, &vectors)).0;
        let cross =
            [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let determinant: f64 = a.iter().zip(cross).map(|(a, b)| a * b).sum();
        assert!((determinant - 1.0).abs() < 1e-14, "{determinant}");
    }
}
