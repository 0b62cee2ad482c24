//! Added mass: the upper triangle of a symmetric 6 x 6 matrix, `m11` to `m66`.

use crate::groups::group;

group! {
    /// Added mass M_A with positive sign, in the body frame, axes surge, sway, heave, roll, pitch, yaw.
    AddedMass = [
        /// surge force per surge acceleration
        #[var(unit = "kg")] m11,
        /// surge force per sway acceleration
        #[var(unit = "kg")] m12,
        /// surge force per heave acceleration
        #[var(unit = "kg")] m13,
        /// surge force per roll acceleration
        #[var(unit = "kg.m")] m14,
        /// surge force per pitch acceleration
        #[var(unit = "kg.m")] m15,
        /// surge force per yaw acceleration
        #[var(unit = "kg.m")] m16,
        /// sway force per sway acceleration
        #[var(unit = "kg")] m22,
        /// sway force per heave acceleration
        #[var(unit = "kg")] m23,
        /// sway force per roll acceleration
        #[var(unit = "kg.m")] m24,
        /// sway force per pitch acceleration
        #[var(unit = "kg.m")] m25,
        /// sway force per yaw acceleration
        #[var(unit = "kg.m")] m26,
        /// heave force per heave acceleration
        #[var(unit = "kg")] m33,
        /// heave force per roll acceleration
        #[var(unit = "kg.m")] m34,
        /// heave force per pitch acceleration
        #[var(unit = "kg.m")] m35,
        /// heave force per yaw acceleration
        #[var(unit = "kg.m")] m36,
        /// roll moment per roll acceleration
        #[var(unit = "kg.m2")] m44,
        /// roll moment per pitch acceleration
        #[var(unit = "kg.m2")] m45,
        /// roll moment per yaw acceleration
        #[var(unit = "kg.m2")] m46,
        /// pitch moment per pitch acceleration
        #[var(unit = "kg.m2")] m55,
        /// pitch moment per yaw acceleration
        #[var(unit = "kg.m2")] m56,
        /// yaw moment per yaw acceleration
        #[var(unit = "kg.m2")] m66; 21]
}

impl From<AddedMass> for [[f64; 6]; 6] {
    #[rustfmt::skip]
    fn from(triangle: AddedMass) -> Self {
        let AddedMass {
            m11, m12, m13, m14, m15, m16, m22, m23, m24, m25, m26, m33, m34, m35, m36, m44, m45,
            m46, m55, m56, m66,
        } = triangle;
        [
            [m11, m12, m13, m14, m15, m16],
            [m12, m22, m23, m24, m25, m26],
            [m13, m23, m33, m34, m35, m36],
            [m14, m24, m34, m44, m45, m46],
            [m15, m25, m35, m45, m55, m56],
            [m16, m26, m36, m46, m56, m66],
        ]
    }
}

impl From<[[f64; 6]; 6]> for AddedMass {
    /// From a symmetric matrix.
    #[rustfmt::skip]
    fn from(matrix: [[f64; 6]; 6]) -> Self {
        let [
            [m11, m12, m13, m14, m15, m16],
            [_, m22, m23, m24, m25, m26],
            [_, _, m33, m34, m35, m36],
            [_, _, _, m44, m45, m46],
            [_, _, _, _, m55, m56],
            [_, _, _, _, _, m66],
        ] = matrix;
        Self {
            m11, m12, m13, m14, m15, m16, m22, m23, m24, m25, m26, m33, m34, m35, m36, m44, m45,
            m46, m55, m56, m66,
        }
    }
}
