//! Directional derivatives of the vehicle against dual numbers, differences and known structure.
//!
//! The dual numbers run through `oracle`, an independent implementation of the equations of motion
//! in the form of the paper, term by term, for any number type.

use crate::oracle::{
    self, COEFFICIENTS, Draw, IN, OUT, STATE, flat_outputs, flat_parameters, flat_state, inputs_of,
    parameters_of, state_of,
};
use num_dual::Dual64;
use proptest::prelude::*;
use rexrov::vehicle::{Inputs, Parameters, Sensitivity, State, ThrusterMode, Vehicle};

const MODES: [ThrusterMode; 3] =
    [ThrusterMode::ForceWithLag, ThrusterMode::Force, ThrusterMode::RotorSpeed];

/// Random numbers enough for parameters, a point and a direction.
fn numbers() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0, 420)
}

/// A vehicle, a point and a direction.
struct Case {
    parameters: Parameters,
    vehicle: Vehicle,
    c: [f64; COEFFICIENTS],
    x: [f64; STATE],
    u: [f64; IN],
    dx: [f64; STATE],
    du: [f64; IN],
    dc: [f64; COEFFICIENTS],
}

impl Case {
    fn new(numbers: &[f64], mode: ThrusterMode) -> Self {
        let mut draw = Draw::new(numbers);
        let parameters = draw.parameters(mode);
        let vehicle = Vehicle::new(&parameters).unwrap();
        let (x, u) = (draw.state(), draw.inputs(&parameters.propulsion));
        let c = flat_parameters(&parameters);
        // Relative to the coefficient, which may be a mass or a thrust gain.
        let dc = core::array::from_fn(|i| c[i] * draw.array::<1>(1.0)[0]);
        let (dx, du) = (draw.array(1.0), draw.array(1.0));
        Self { parameters, vehicle, c, x, u, dx, du, dc }
    }

    /// Change of derivative and outputs along the direction.
    fn along(&self) -> ([f64; STATE], [f64; OUT]) {
        let (x, u) = (state_of(&self.x), inputs_of(&self.u));
        let tangent = self.vehicle.tangent(&x, &u);
        let (dx, du) = (state_of(&self.dx), inputs_of(&self.du));
        let (rate, outputs) = tangent.along(&dx, &du);
        assert_eq!(rate, tangent.derivative(&dx, &du));
        assert_eq!(outputs, tangent.outputs(&dx, &du));
        (flat_state(&rate), flat_outputs(&outputs))
    }

    /// Change of derivative and outputs along the direction of the coefficients.
    fn with_coefficients(&self) -> ([f64; STATE], [f64; OUT]) {
        let (x, u) = (state_of(&self.x), inputs_of(&self.u));
        let d = Sensitivity::new(&self.parameters, &parameters_of(&self.dc, &self.parameters));
        let (rate, outputs) = self.vehicle.tangent(&x, &u).with_coefficients(&d);
        (flat_state(&rate), flat_outputs(&outputs))
    }

    /// The same model with its coefficients a distance `h` along their direction.
    fn with_moved_coefficients(&self, h: f64) -> ([f64; STATE], [f64; OUT]) {
        let c = core::array::from_fn(|i| self.c[i] + h * self.dc[i]);
        let vehicle = Vehicle::new(&parameters_of(&c, &self.parameters)).unwrap();
        let (x, u) = (state_of(&self.x), inputs_of(&self.u));
        let (rate, outputs) = (vehicle.derivative(&x, &u), vehicle.outputs(&x, &u));
        (flat_state(&rate), flat_outputs(&outputs))
    }

    fn values(&self, x: &[f64; STATE], u: &[f64; IN]) -> ([f64; STATE], [f64; OUT]) {
        let (x, u) = (state_of(x), inputs_of(u));
        let (rate, outputs) = (self.vehicle.derivative(&x, &u), self.vehicle.outputs(&x, &u));
        (flat_state(&rate), flat_outputs(&outputs))
    }

    /// Minimum speed through the water: at zero the second derivative of the damping jumps, so
    /// differences across it are not valid.
    fn slowest(&self) -> f64 {
        let x = state_of(&self.x);
        let r = rexrov::attitude::rotation(x.quaternion);
        let current = |j: usize| (0..3).map(|i| r[i][j] * self.u[22 + i]).sum::<f64>();
        let nu_r = (0..6).map(|i| if i < 3 { x.nu[i] - current(i) } else { x.nu[i] });
        nu_r.fold(f64::INFINITY, |least, speed| least.min(speed.abs()))
    }

    /// Derivative and outputs a distance `h` along the direction.
    fn moved(&self, h: f64) -> ([f64; STATE], [f64; OUT]) {
        let x = core::array::from_fn(|i| self.x[i] + h * self.dx[i]);
        let u = core::array::from_fn(|i| self.u[i] + h * self.du[i]);
        self.values(&x, &u)
    }
}

/// Compares vector by vector (position, attitude, ...), relative to the size of the vector.
fn close(what: &str, got: &[f64], want: &[f64], tolerance: f64) -> Result<(), TestCaseError> {
    close_at(what, got, want, want, tolerance)
}

/// Relative to the size of another vector.
fn close_at(
    what: &str,
    got: &[f64],
    want: &[f64],
    sizes: &[f64],
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let groups: &[usize] =
        if got.len() == STATE { &oracle::STATE_GROUPS } else { &oracle::OUT_GROUPS };
    let mut begin = 0;
    for &n in groups {
        let group = begin..begin + n;
        let size = sizes[group.clone()].iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        for (g, w) in got[group.clone()].iter().zip(&want[group.clone()]) {
            let bad = format!("{what} {group:?}: {g}, expected {w} in a vector of size {size}");
            prop_assert!((g - w).abs() <= tolerance * size, "{}", bad);
        }
        begin += n;
    }
    Ok(())
}

/// Central difference of two vectors 2 h apart, and the scale of its errors: differences of large
/// values have large rounding errors.
fn difference(a: &[f64], b: &[f64], h: f64) -> (Vec<f64>, Vec<f64>) {
    let slope = |(a, b): (&f64, &f64)| (a - b) / (2.0 * h);
    let slopes: Vec<f64> = a.iter().zip(b).map(slope).collect();
    let sizes = slopes.iter().zip(a).map(|(s, a)| s.abs().max(1e-4 * a.abs())).collect();
    (slopes, sizes)
}

/// The scale of the error of one coefficient's effect: below a thousandth of its unit large terms
/// have cancelled each other, and only their rounding is left.
fn at_least(effect: f64) -> f64 {
    effect.abs().max(1e-3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_oracle_is_the_model(numbers in numbers()) {
        for mode in MODES {
            let case = Case::new(&numbers, mode);
            let (rate, outputs) = case.values(&case.x, &case.u);
            let (want_rate, want_outputs) =
                oracle::model(&case.parameters, &case.c, &case.x, &case.u);
            close("derivative", &rate, &want_rate, 1e-13)?;
            close("outputs", &outputs, &want_outputs, 1e-13)?;
        }
    }

    #[test]
    fn it_is_what_dual_numbers_give(numbers in numbers()) {
        for mode in MODES {
            let case = Case::new(&numbers, mode);
            let (rate, outputs) = case.along();
            let x = core::array::from_fn(|i| Dual64::new(case.x[i], case.dx[i]));
            let u = core::array::from_fn(|i| Dual64::new(case.u[i], case.du[i]));
            let c = case.c.map(Dual64::from);
            let (want_rate, want_outputs) = oracle::model(&case.parameters, &c, &x, &u);
            close("derivative", &rate, &want_rate.map(|d| d.eps), 1e-12)?;
            close("outputs", &outputs, &want_outputs.map(|d| d.eps), 1e-12)?;
        }
    }

    #[test]
    fn it_is_the_limit_of_differences(numbers in numbers()) {
        for mode in MODES {
            let case = Case::new(&numbers, mode);
            let (rate, outputs) = case.along();
            let h = 2e-5;
            prop_assume!(case.slowest() > 10.0 * h);
            let ((a, y_a), (b, y_b)) = (case.moved(h), case.moved(-h));
            let (slopes, sizes) = difference(&a, &b, h);
            close_at("derivative", &rate, &slopes, &sizes, 1e-6)?;
            let (slopes, sizes) = difference(&y_a, &y_b, h);
            close_at("outputs", &outputs, &slopes, &sizes, 1e-6)?;
        }
    }

    #[test]
    fn coefficients_move_it_as_dual_numbers_say(numbers in numbers()) {
        for mode in MODES {
            let case = Case::new(&numbers, mode);
            let (rate, outputs) = case.with_coefficients();
            let c = core::array::from_fn(|i| Dual64::new(case.c[i], case.dc[i]));
            let (x, u) = (case.x.map(Dual64::from), case.u.map(Dual64::from));
            let (want_rate, want_outputs) = oracle::model(&case.parameters, &c, &x, &u);
            close("derivative", &rate, &want_rate.map(|d| d.eps), 1e-12)?;
            close("outputs", &outputs, &want_outputs.map(|d| d.eps), 1e-12)?;
        }
    }

    /// One after the other, so that no sum hides a small one.
    #[test]
    fn each_coefficient_moves_it_as_dual_numbers_say(numbers in numbers()) {
        for mode in MODES {
            let mut case = Case::new(&numbers, mode);
            let (x, u) = (case.x.map(Dual64::from), case.u.map(Dual64::from));
            let all = case.dc;
            for k in 0..COEFFICIENTS {
                case.dc = core::array::from_fn(|i| if i == k { all[i] } else { 0.0 });
                let (rate, outputs) = case.with_coefficients();
                let c = core::array::from_fn(|i| Dual64::new(case.c[i], case.dc[i]));
                let (want_rate, want_outputs) = oracle::model(&case.parameters, &c, &x, &u);
                let (want_rate, want_outputs) = (want_rate.map(|d| d.eps), want_outputs.map(|d| d.eps));
                let what = format!("along {k}");
                close_at(&what, &rate, &want_rate, &want_rate.map(at_least), 1e-12)?;
                close_at(&what, &outputs, &want_outputs, &want_outputs.map(at_least), 1e-12)?;
            }
        }
    }

    #[test]
    fn coefficients_move_it_as_differences_do(numbers in numbers()) {
        for mode in MODES {
            let case = Case::new(&numbers, mode);
            let (rate, outputs) = case.with_coefficients();
            let h = 1e-6;
            let ahead = case.with_moved_coefficients(h);
            let behind = case.with_moved_coefficients(-h);
            let (slopes, sizes) = difference(&ahead.0, &behind.0, h);
            close_at("derivative", &rate, &slopes, &sizes, 1e-6)?;
            let (slopes, sizes) = difference(&ahead.1, &behind.1, h);
            close_at("outputs", &outputs, &slopes, &sizes, 1e-6)?;
        }
    }

    #[test]
    fn a_start_turns_with_its_angles(numbers in numbers()) {
        let [roll, pitch, yaw, d_roll, d_pitch, d_yaw] = core::array::from_fn(|i| 1.5 * numbers[i]);
        let at = |h: f64| {
            State::at_rest([0.0; 3], [roll + h * d_roll, pitch + h * d_pitch, yaw + h * d_yaw])
        };
        let (euler, d_euler) = ([roll, pitch, yaw], [d_roll, d_pitch, d_yaw]);
        let d = State::d_at_rest([1.0, 2.0, 3.0], euler, d_euler);
        let (a, b) = (at(1e-5), at(-1e-5));
        for i in 0..4 {
            let slope = (a.quaternion[i] - b.quaternion[i]) / 2e-5;
            prop_assert!((d.quaternion[i] - slope).abs() < 1e-9, "{} {slope}", d.quaternion[i]);
        }
        prop_assert_eq!((d.p_ned, d.nu), ([1.0, 2.0, 3.0], [0.0; 6]));
    }

    #[test]
    fn it_is_linear_in_the_direction(numbers in numbers()) {
        for mode in MODES {
            let mut case = Case::new(&numbers, mode);
            let (rate, outputs) = case.along();
            let (mut sum, mut y_sum) = ([0.0; STATE], [0.0; OUT]);
            let (dx, du) = (case.dx, case.du);
            for axis in 0..STATE + IN {
                (case.dx, case.du) = ([0.0; STATE], [0.0; IN]);
                let weight = if axis < STATE {
                    case.dx[axis] = 1.0;
                    dx[axis]
                } else {
                    case.du[axis - STATE] = 1.0;
                    du[axis - STATE]
                };
                let (column, y_column) = case.along();
                sum.iter_mut().zip(column).for_each(|(s, c)| *s += weight * c);
                y_sum.iter_mut().zip(y_column).for_each(|(s, c)| *s += weight * c);
            }
            close("derivative", &sum, &rate, 1e-12)?;
            close("outputs", &y_sum, &outputs, 1e-12)?;
        }
    }

    /// Which output depends on which input or state: measured from differences of the model, exact
    /// in the tangent.
    #[test]
    fn it_is_zero_where_nothing_depends(numbers in numbers()) {
        for mode in MODES {
            let mut case = Case::new(&numbers, mode);
            let still = case.values(&case.x, &case.u);
            for axis in 0..STATE + IN {
                (case.dx, case.du) = ([0.0; STATE], [0.0; IN]);
                if axis < STATE { case.dx[axis] = 1.0 } else { case.du[axis - STATE] = 1.0 }
                let (slopes, moved) = (case.along(), case.moved(0.01));
                let unmoved = |a: &[f64], b: &[f64], slope: &[f64]| {
                    (0..a.len()).all(|i| a[i] != b[i] || slope[i].abs() < 1e-9)
                };
                prop_assert!(unmoved(&still.0, &moved.0, &slopes.0), "{mode:?} axis {axis}");
                prop_assert!(unmoved(&still.1, &moved.1, &slopes.1), "{mode:?} axis {axis}");
            }
        }
    }
}

/// Names of what changes when one entry of state or inputs changes.
fn moved_by(mode: ThrusterMode, direction: impl Fn(&mut State, &mut Inputs)) -> Vec<&'static str> {
    let mut p = Parameters::default();
    p.propulsion.mode = mode;
    let vehicle = Vehicle::new(&p).unwrap();
    let x = State {
        nu: [0.3, -0.2, 0.1, 0.05, -0.04, 0.2],
        rotor_speed: [100.0, -200.0, 300.0, 50.0, -60.0, 70.0, 80.0, -90.0],
        ..State::at_rest([1.0, 2.0, 3.0], [0.3, -0.4, 2.0])
    };
    let u = Inputs {
        thruster_force: [100.0; 8],
        thruster_speed: [-70.0; 8],
        current_ned: [0.3, 0.2, -0.1],
        ..Inputs::default()
    };
    let (mut dx, mut du) = (state_of(&[0.0; STATE]), inputs_of(&[0.0; IN]));
    direction(&mut dx, &mut du);
    let (rate, outputs) = vehicle.tangent(&x, &u).along(&dx, &du);
    let all = flat_state(&rate).into_iter().chain(flat_outputs(&outputs));
    oracle::NAMES.into_iter().zip(all).filter(|(_, d)| *d != 0.0).map(|(name, _)| name).collect()
}

const ACCELERATIONS: [&str; 15] = [
    "u'",
    "v'",
    "w'",
    "p'",
    "q'",
    "r'",
    "nu_dot[0]",
    "nu_dot[1]",
    "nu_dot[2]",
    "nu_dot[3]",
    "nu_dot[4]",
    "nu_dot[5]",
    "specific_force[0]",
    "specific_force[1]",
    "specific_force[2]",
];

#[test]
fn a_position_moves_only_itself() {
    for mode in MODES {
        assert_eq!(moved_by(mode, |x, _| x.p_ned[1] = 1.0), ["p_ned[1]"]);
    }
}

#[test]
fn a_rotor_moves_its_own_lag_its_own_thrust_and_the_accelerations() {
    for mode in [ThrusterMode::ForceWithLag, ThrusterMode::RotorSpeed] {
        let mut expected = ACCELERATIONS.to_vec();
        expected.insert(6, "rotor[2]'");
        expected.extend(["thrust[2]", "rotor_speed[2]"]);
        assert_eq!(moved_by(mode, |x, _| x.rotor_speed[2] = 1.0), expected);
    }
    assert!(moved_by(ThrusterMode::Force, |x, _| x.rotor_speed[2] = 1.0).is_empty());
}

#[test]
fn a_command_acts_only_in_its_mode_and_through_the_lag_if_there_is_one() {
    let force = |_: &mut State, u: &mut Inputs| u.thruster_force[2] = 1.0;
    let speed = |_: &mut State, u: &mut Inputs| u.thruster_speed[2] = 1.0;
    assert_eq!(moved_by(ThrusterMode::ForceWithLag, force), ["rotor[2]'"]);
    assert_eq!(moved_by(ThrusterMode::RotorSpeed, speed), ["rotor[2]'"]);
    let mut expected = ACCELERATIONS.to_vec();
    expected.extend(["thrust[2]", "rotor_speed[2]"]);
    assert_eq!(moved_by(ThrusterMode::Force, force), expected);
    assert!(moved_by(ThrusterMode::ForceWithLag, speed).is_empty());
    assert!(moved_by(ThrusterMode::Force, speed).is_empty());
    assert!(moved_by(ThrusterMode::RotorSpeed, force).is_empty());
}

#[test]
fn a_loss_moves_its_own_thrust_and_the_accelerations() {
    for mode in MODES {
        let mut expected = ACCELERATIONS.to_vec();
        expected.push("thrust[2]");
        assert_eq!(moved_by(mode, |_, u| u.thruster_loss[2] = 1.0), expected);
    }
}

#[test]
fn a_wrench_moves_the_accelerations_only() {
    for mode in MODES {
        assert_eq!(moved_by(mode, |_, u| u.wrench[5] = 1.0), ACCELERATIONS);
    }
}

/// Change of the target of rotor 0 with its command, at a command.
fn command_slope(mode: ThrusterMode, command: f64) -> f64 {
    let mut p = Parameters::default();
    p.propulsion.mode = mode;
    let vehicle = Vehicle::new(&p).unwrap();
    let all = |value| Inputs {
        thruster_force: [value; 8],
        thruster_speed: [value; 8],
        ..Inputs::default()
    };
    let (x, u) = (State::default(), all(command));
    let change = vehicle.tangent(&x, &u).derivative(&state_of(&[0.0; STATE]), &all(1.0));
    change.rotor_speed[0] * p.propulsion.rotor_time_constant
}

#[test]
fn the_slope_of_a_command_ends_at_its_limit_and_is_finite_at_zero() {
    let p = Parameters::default().propulsion;
    let lag = |force| command_slope(ThrusterMode::ForceWithLag, force);
    approx::assert_relative_eq!(lag(-3.1), 100.0 / (2.0 * 3.1), max_relative = 1e-12);
    assert!(lag(p.thrust_limit) > 0.0 && lag(p.thrust_limit * 1.000_001) == 0.0);
    assert_eq!(lag(0.0), 0.0);
    assert!(lag(f64::from_bits(1)).is_finite());
    let fastest = p.speed(p.thrust_limit);
    let speed = |speed| command_slope(ThrusterMode::RotorSpeed, speed);
    approx::assert_relative_eq!(speed(-fastest), 1.0, max_relative = 1e-12);
    assert_eq!(speed(-fastest * 1.000_001), 0.0);
}

#[test]
fn everything_is_finite_where_roll_and_yaw_are_one_axis() {
    let half = core::f64::consts::FRAC_1_SQRT_2;
    let x = State { quaternion: [half, 0.0, half, 0.0], ..State::default() };
    let vehicle = Vehicle::new(&Parameters::default()).unwrap();
    let u = Inputs::default();
    let d = State { quaternion: [0.1, 0.2, 0.3, 0.4], ..state_of(&[0.0; STATE]) };
    let (rate, outputs) = vehicle.tangent(&x, &u).along(&d, &u);
    assert!(flat_state(&rate).iter().all(|d| d.is_finite()));
    assert!(flat_outputs(&outputs).iter().all(|d| d.is_finite()), "{outputs:?}");
}
