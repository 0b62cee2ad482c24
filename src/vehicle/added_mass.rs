//! Added mass: the upper triangle of a symmetric 6 x 6 matrix, `m11` to `m66`.

use fmu_quantity::{Member, Variables};

/// Axes surge, sway, heave, roll, pitch, yaw, body frame.
const TRIANGLE: [Member; 21] = [
    Member::new("m11", "surge force per surge acceleration").unit("kg"),
    Member::new("m12", "surge force per sway acceleration").unit("kg"),
    Member::new("m13", "surge force per heave acceleration").unit("kg"),
    Member::new("m14", "surge force per roll acceleration").unit("kg.m"),
    Member::new("m15", "surge force per pitch acceleration").unit("kg.m"),
    Member::new("m16", "surge force per yaw acceleration").unit("kg.m"),
    Member::new("m22", "sway force per sway acceleration").unit("kg"),
    Member::new("m23", "sway force per heave acceleration").unit("kg"),
    Member::new("m24", "sway force per roll acceleration").unit("kg.m"),
    Member::new("m25", "sway force per pitch acceleration").unit("kg.m"),
    Member::new("m26", "sway force per yaw acceleration").unit("kg.m"),
    Member::new("m33", "heave force per heave acceleration").unit("kg"),
    Member::new("m34", "heave force per roll acceleration").unit("kg.m"),
    Member::new("m35", "heave force per pitch acceleration").unit("kg.m"),
    Member::new("m36", "heave force per yaw acceleration").unit("kg.m"),
    Member::new("m44", "roll moment per roll acceleration").unit("kg.m2"),
    Member::new("m45", "roll moment per pitch acceleration").unit("kg.m2"),
    Member::new("m46", "roll moment per yaw acceleration").unit("kg.m2"),
    Member::new("m55", "pitch moment per pitch acceleration").unit("kg.m2"),
    Member::new("m56", "pitch moment per yaw acceleration").unit("kg.m2"),
    Member::new("m66", "yaw moment per yaw acceleration").unit("kg.m2"),
];

/// Added mass M_A with positive sign.
#[derive(Clone, Copy, Debug, Variables)]
pub(super) struct AddedMass {
    /// The upper triangle, row by row.
    #[var(flatten, elements = TRIANGLE)]
    triangle: [f64; 21],
}

/// Where the element of a row and a column is in the triangle.
fn place(i: usize, j: usize) -> usize {
    let (row, column) = (i.min(j), i.max(j));
    row * (11 - row) / 2 + column
}

impl From<[[f64; 6]; 6]> for AddedMass {
    /// With mirrored elements averaged: printed tables differ in the last digit.
    fn from(matrix: [[f64; 6]; 6]) -> Self {
        let mut triangle = [0.0; 21];
        for i in 0..6 {
            for j in i..6 {
                triangle[place(i, j)] = 0.5 * (matrix[i][j] + matrix[j][i]);
            }
        }
        Self { triangle }
    }
}

impl From<AddedMass> for [[f64; 6]; 6] {
    fn from(AddedMass { triangle }: AddedMass) -> Self {
        core::array::from_fn(|i| core::array::from_fn(|j| triangle[place(i, j)]))
    }
}
