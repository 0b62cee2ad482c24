//! The posterior Cramér-Rao bound of inertial navigation: no estimator that uses these sensors has
//! a smaller mean square error.
//!
//! With Gaussian noise the bound is the covariance recursion with its Jacobians taken at the true
//! motion, averaged over missions (Tichavský, Muravchik & Nehorai 1998; Bar-Shalom, Li &
//! Kirubarajan 2001 ch. 2.7). It shares no code with the filters that it judges: the attitude error
//! is on the left (`R = Exp(phi) R^`, phi along NED axes), and matrices are dense.
//!
//! ```text
//! p' = v,  v' = R (f - b_a) + g e_z,  R' = R [omega - b_g]x
//! F: dv/dphi = -[R f]x,  dv/db_a = -R,  dphi/db_g = -R
//! ```

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::kinematics::skew;
use super::parameters::{NavigationParameters, SensorErrors};
use super::sensor::euler;
use crate::ParameterError;
use crate::sensors::Gaussian;

const P: usize = 0;
const V: usize = 3;
const PHI: usize = 6;
const B_A: usize = 9;
const B_G: usize = 12;
const STATES: usize = 15;

/// The true motion at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueMotion {
    /// Rotation from body to NED.
    pub rotation: Matrix3<f64>,
    /// Velocity over ground, body (m/s).
    pub velocity: Vector3<f64>,
    /// Specific force, body (m/s2).
    pub specific_force: Vector3<f64>,
}

/// Lower bounds of the standard deviations of any estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Position, NED (m).
    pub position: [f64; 3],
    /// Roll, pitch, heading (rad).
    pub euler: [f64; 3],
    /// Velocity over ground, body (m/s).
    pub velocity: [f64; 3],
}

/// The recursion.
#[derive(Clone, Debug)]
pub struct InertialBound {
    covariance: SMatrix<f64, STATES, STATES>,
    parameters: NavigationParameters,
    /// Samples of the inertial unit a second (Hz).
    rate_hz: f64,
    /// Errors of estimators that reach the bound, one for each sample.
    errors: Vec<SVector<f64, STATES>>,
    noise: Gaussian,
}

impl InertialBound {
    /// Before the first measurement. The parameters are those of a filter, without sensor states.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &NavigationParameters, rate_hz: f64) -> Result<Self, ParameterError> {
        p.check()?;
        let (start, sensors) = (&p.start, &p.sensors);
        let mut sigma = SVector::<f64, STATES>::zeros();
        for i in 0..3 {
            sigma[P + i] = start.position_sigma[i];
            sigma[V + i] = start.velocity_sigma;
            sigma[PHI + i] = if i < 2 { start.tilt_sigma } else { start.heading_sigma };
            sigma[B_A + i] = sensors.accelerometer.turn_on_sigma;
            sigma[B_G + i] = sensors.gyro.turn_on_sigma;
        }
        let covariance = SMatrix::from_diagonal(&sigma.component_mul(&sigma));
        let (errors, noise) = (Vec::new(), Gaussian::new(0, 0_u64));
        Ok(Self { covariance, parameters: *p, rate_hz, errors, noise })
    }

    /// With this many samples of the errors, drawn with a seed: how measures of a mission scatter if
    /// its estimator reaches the bound.
    #[must_use]
    pub fn with_samples(self, count: usize, seed: u64) -> Self {
        let mut noise = Gaussian::new(seed, 0_u64);
        let sigma = self.covariance.diagonal().map(f64::sqrt);
        let errors = (0..count).map(|_| sigma.map(|sigma| sigma * noise.draw())).collect();
        Self { errors, noise, ..self }
    }

    /// The errors of the position in the samples, NED (m).
    pub fn position_errors(&self) -> impl Iterator<Item = [f64; 3]> {
        self.errors.iter().map(|error| [error[P], error[P + 1], error[P + 2]])
    }

    /// Propagates by `dt` seconds of this motion.
    pub fn predict(&mut self, motion: &TrueMotion, dt: f64) {
        let r = &motion.rotation;
        let mut f = SMatrix::<f64, STATES, STATES>::zeros();
        let mut block = |i, j, m: Matrix3<f64>| f.fixed_view_mut::<3, 3>(i, j).copy_from(&m);
        block(P, V, Matrix3::identity());
        block(V, PHI, -skew(&(r * motion.specific_force)));
        block(V, B_A, -r);
        block(PHI, B_G, -r);
        let SensorErrors { accelerometer: a, gyro: g, .. } = self.parameters.sensors;
        let densities = [0.0, a.noise_density, g.noise_density, a.random_walk, g.random_walk];
        let noise = SVector::<f64, STATES>::from_fn(|i, _| densities[i / 3] * densities[i / 3]);
        let half_variance = noise * (0.5 * dt);
        let half = SMatrix::from_diagonal(&half_variance);
        let f = f * dt;
        let f = SMatrix::identity() + f + f * f * 0.5;
        self.covariance = f * (self.covariance + half) * f.transpose() + half;
        let mut draw = || half_variance.map(|variance| variance.sqrt() * self.noise.draw());
        self.errors.iter_mut().for_each(|error| *error = f * (*error + draw()) + draw());
    }

    /// Roll, pitch and heading were measured.
    pub fn attitude(&mut self, motion: &TrueMotion) {
        let s = &self.parameters.sensors;
        let variance = [s.tilt_sigma, s.tilt_sigma, s.heading_sigma].map(|sigma| sigma * sigma);
        let mut h = SMatrix::<f64, 3, STATES>::zeros();
        h.fixed_view_mut::<3, 3>(0, PHI).copy_from(&euler_by_turn(&motion.rotation));
        self.update(&h, &variance);
    }

    /// The depth was measured.
    pub fn depth(&mut self, motion: &TrueMotion) {
        let lever = motion.rotation * Vector3::from(self.parameters.mounting.pressure);
        let h = place(&lever).fixed_rows::<1>(2).into_owned();
        let sigma = self.parameters.sensors.depth_sigma;
        self.update(&h, &[sigma * sigma]);
    }

    /// The position was measured.
    pub fn fix(&mut self, motion: &TrueMotion) {
        let lever = motion.rotation * Vector3::from(self.parameters.mounting.fix);
        let h = place(&lever).fixed_rows::<2>(0).into_owned();
        let sigma = self.parameters.sensors.fix_sigma;
        self.update(&h, &[sigma * sigma; 2]);
    }

    /// The velocity over ground was measured at the velocity log. The rate at that instant is known
    /// from one gyro sample.
    pub fn dvl(&mut self, motion: &TrueMotion) {
        let lever = skew(&Vector3::from(self.parameters.mounting.dvl));
        let mut h = self.velocity_rows(motion);
        h.fixed_view_mut::<3, 3>(0, B_G).copy_from(&lever);
        let s = &self.parameters.sensors;
        let rate_variance = s.gyro.noise_density * s.gyro.noise_density * self.rate_hz;
        let variance = core::array::from_fn(|i| {
            s.dvl_sigma * s.dvl_sigma + lever.row(i).norm_squared() * rate_variance
        });
        self.update(&h, &variance);
    }

    /// The present bounds.
    #[must_use]
    pub fn limits(&self, motion: &TrueMotion) -> Limits {
        let p = &self.covariance;
        let mut turn = SMatrix::<f64, 3, STATES>::zeros();
        turn.fixed_view_mut::<3, 3>(0, PHI).copy_from(&euler_by_turn(&motion.rotation));
        let sigmas = |h: &SMatrix<f64, 3, STATES>| {
            let covariance = h * p * h.transpose();
            core::array::from_fn(|i| covariance[(i, i)].max(0.0).sqrt())
        };
        Limits {
            position: core::array::from_fn(|i| p[(P + i, P + i)].max(0.0).sqrt()),
            euler: sigmas(&turn),
            velocity: sigmas(&self.velocity_rows(motion)),
        }
    }

    /// Derivatives of the velocity along body axes, `R^T v`.
    fn velocity_rows(&self, motion: &TrueMotion) -> SMatrix<f64, 3, STATES> {
        let inverse = motion.rotation.transpose();
        let mut h = SMatrix::<f64, 3, STATES>::zeros();
        h.fixed_view_mut::<3, 3>(0, V).copy_from(&inverse);
        let along = motion.rotation * motion.velocity;
        h.fixed_view_mut::<3, 3>(0, PHI).copy_from(&(inverse * skew(&along)));
        h
    }

    fn update<const M: usize>(&mut self, h: &SMatrix<f64, M, STATES>, variance: &[f64; M]) {
        // Independent noise: one component after the other.
        for (i, variance) in variance.iter().enumerate() {
            let row = h.row(i);
            let correlation = self.covariance * row.transpose();
            let s = (row * correlation)[0] + variance;
            self.covariance -= correlation * correlation.transpose() / s;
            for error in &mut self.errors {
                let innovation = (row * *error)[0] + variance.sqrt() * self.noise.draw();
                *error -= correlation * (innovation / s);
            }
        }
    }
}

/// Derivatives of a point's position, `p + R l`, with the lever arm along NED axes.
fn place(lever: &Vector3<f64>) -> SMatrix<f64, 3, STATES> {
    let mut h = SMatrix::<f64, 3, STATES>::zeros();
    h.fixed_view_mut::<3, 3>(0, P).copy_from(&Matrix3::identity());
    h.fixed_view_mut::<3, 3>(0, PHI).copy_from(&-skew(lever));
    h
}

/// Derivatives of roll, pitch and heading by a small rotation about NED axes.
fn euler_by_turn(rotation: &Matrix3<f64>) -> Matrix3<f64> {
    let [_, pitch, heading] = euler(rotation);
    let (sin, cos) = libm::sincos(heading);
    let (sin_pitch, cos_pitch) = libm::sincos(pitch);
    let secant = 1.0 / cos_pitch.max(0.05);
    Matrix3::new(
        cos * secant,
        sin * secant,
        0.0,
        -sin,
        cos,
        0.0,
        cos * sin_pitch * secant,
        sin * sin_pitch * secant,
        1.0,
    )
}
