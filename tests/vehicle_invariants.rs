//! Laws that the equations of motion obey for any state and any coefficients.

#![allow(clippy::needless_range_loop, reason = "indices as the equations have them")]

use approx::assert_relative_eq;
use nalgebra::{Matrix6, Vector6};
use proptest::prelude::*;
use rexrov::attitude;
use rexrov::vehicle::{
    Inputs, ParameterSet, Parameters, ReducedModel, State, ThrusterMode, Vehicle,
};

fn velocities() -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-1.5..1.5)
}

fn angles() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-3.0..3.0)
}

/// Coefficients with a random symmetric positive definite added mass.
fn vehicles() -> impl Strategy<Value = Parameters> {
    (prop::array::uniform6(prop::array::uniform6(-20.0..20.0)), 100.0..4000.0).prop_map(
        |(g, mass)| {
            let g = Matrix6::from_fn(|i, j| g[i][j]);
            let a: Matrix6<f64> = g * g.transpose() + Matrix6::identity() * 50.0;
            let added_mass = core::array::from_fn(|i| core::array::from_fn(|j| a[(i, j)]));
            Parameters { mass, added_mass, ..Parameters::default() }
        },
    )
}

/// The same vehicle without drag, weight and buoyancy.
fn ideal(mut p: Parameters) -> Parameters {
    p.linear_damping = [0.0; 6];
    p.quadratic_damping = [0.0; 6];
    p.gravity = 0.0;
    p.buoyancy = Some(0.0);
    p
}

fn mass_matrix(p: &Parameters) -> Matrix6<f64> {
    let m = p.mass_matrix();
    Matrix6::from_fn(|i, j| m[i][j])
}

fn kinetic_energy(p: &Parameters, nu: &[f64; 6]) -> f64 {
    let nu = Vector6::from(*nu);
    0.5 * nu.dot(&(mass_matrix(p) * nu))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn rotate(r: &[[f64; 3]; 3], a: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| (0..3).map(|j| r[i][j] * a[j]).sum())
}

/// Linear impulse and angular impulse about the origin, both in NED.
fn world_impulse(p: &Parameters, state: &State) -> ([f64; 3], [f64; 3]) {
    let h = mass_matrix(p) * Vector6::from(state.nu);
    let r = attitude::rotation(state.quaternion);
    let linear = rotate(&r, [h[0], h[1], h[2]]);
    let spin = rotate(&r, [h[3], h[4], h[5]]);
    let orbit = cross(state.p_ned, linear);
    (linear, core::array::from_fn(|i| spin[i] + orbit[i]))
}

fn state(nu: [f64; 6], euler: [f64; 3]) -> State {
    State { nu, ..State::at_rest([1.0, -2.0, 20.0], euler) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn coriolis_forces_do_no_work(p in vehicles(), nu in velocities(), euler in angles()) {
        let vehicle = Vehicle::new(&ideal(p)).unwrap();
        let dot = vehicle.derivative(&state(nu, euler), &Inputs::default()).nu;
        let power = Vector6::from(nu).dot(&(mass_matrix(&p) * Vector6::from(dot)));
        prop_assert!(power.abs() < 1e-9 * (1.0 + kinetic_energy(&p, &nu)), "{power}");
    }

    #[test]
    fn world_impulse_is_conserved_without_forces(
        p in vehicles(), nu in velocities(), euler in angles()
    ) {
        let p = ideal(p);
        let vehicle = Vehicle::new(&p).unwrap();
        let mut state = state(nu, euler);
        let before = world_impulse(&p, &state);
        for _ in 0..500 {
            vehicle.step(&mut state, &Inputs::default(), 0.002);
        }
        let after = world_impulse(&p, &state);
        let size = before.0.iter().chain(&before.1).fold(1.0_f64, |m, x| m.max(x.abs()));
        for i in 0..3 {
            prop_assert!((after.0[i] - before.0[i]).abs() < 1e-6 * size, "{before:?} {after:?}");
            prop_assert!((after.1[i] - before.1[i]).abs() < 1e-6 * size, "{before:?} {after:?}");
        }
    }

    #[test]
    fn energy_never_rises_without_thrust(p in vehicles(), nu in velocities(), euler in angles()) {
        let vehicle = Vehicle::new(&p).unwrap();
        let mut state = state(nu, euler);
        let energy = |s: &State| {
            let r = attitude::rotation(s.quaternion);
            let depth_of_buoyancy = s.p_ned[2] + rotate(&r, p.centre_of_buoyancy)[2];
            kinetic_energy(&p, &s.nu) - p.weight() * s.p_ned[2]
                + p.buoyancy_force() * depth_of_buoyancy
        };
        let mut last = energy(&state);
        for _ in 0..300 {
            vehicle.step(&mut state, &Inputs::default(), 0.01);
            let now = energy(&state);
            prop_assert!(now <= last + 1e-7 * last.abs(), "{last} -> {now}");
            last = now;
        }
    }

    #[test]
    fn a_steady_current_only_adds_its_velocity(
        p in vehicles(), nu in velocities(), euler in angles(),
        current in prop::array::uniform3(-1.0..1.0), force in prop::array::uniform8(-500.0..500.0)
    ) {
        let vehicle = Vehicle::new(&p).unwrap();
        let still = Inputs { thruster_force: force, ..Inputs::default() };
        let flowing = Inputs { current_ned: current, ..still };
        let mut a = state(nu, euler);
        let mut b = a;
        let r = attitude::rotation(b.quaternion);
        for i in 0..3 {
            b.nu[i] += (0..3).map(|j| r[j][i] * current[j]).sum::<f64>();
        }
        for _ in 0..200 {
            vehicle.step(&mut a, &still, 0.01);
            vehicle.step(&mut b, &flowing, 0.01);
        }
        for i in 0..3 {
            let drift = b.p_ned[i] - a.p_ned[i];
            prop_assert!((drift - 2.0 * current[i]).abs() < 1e-4, "{drift} {current:?}");
        }
        for i in 3..6 {
            prop_assert!((a.nu[i] - b.nu[i]).abs() < 1e-4);
        }
    }

    #[test]
    fn the_reduced_model_is_the_full_one_in_level_trim(
        u in -1.5..1.5, v in -1.5..1.5, w in -1.5..1.5, r in -1.0..1.0,
        force in prop::array::uniform8(-500.0..500.0)
    ) {
        let mut p = Parameters::preset(ParameterSet::UuvDiagonal);
        p.propulsion.mode = ThrusterMode::Force;
        let inputs = Inputs { thruster_force: force, ..Inputs::default() };
        let state = state([u, v, w, 0.0, 0.0, r], [0.0, 0.0, 1.0]);
        let full = Vehicle::new(&p).unwrap().derivative(&state, &inputs).nu;
        let reduced = ReducedModel::new(&p).unwrap().acceleration([u, v, w, r], &force);
        for (i, k) in [0, 1, 2, 5].into_iter().enumerate() {
            prop_assert!((full[k] - reduced[i]).abs() < 1e-9, "{full:?} {reduced:?}");
        }
    }

    #[test]
    fn the_length_of_the_quaternion_has_no_effect(
        nu in velocities(), euler in angles(), length in 0.5..2.0
    ) {
        let vehicle = Vehicle::new(&Parameters::default()).unwrap();
        let a = state(nu, euler);
        let b = State { quaternion: a.quaternion.map(|c| c * length), ..a };
        let (x, y) = (vehicle.outputs(&a, &Inputs::default()), vehicle.outputs(&b, &Inputs::default()));
        for i in 0..6 {
            prop_assert!((x.nu_dot[i] - y.nu_dot[i]).abs() < 1e-9);
        }
        for i in 0..3 {
            prop_assert!((x.v_ned[i] - y.v_ned[i]).abs() < 1e-12);
        }
    }
}

#[test]
fn the_length_of_the_quaternion_returns_to_one() {
    let vehicle = Vehicle::new(&Parameters::default()).unwrap();
    let mut state = state([0.3, 0.1, 0.0, 0.5, -0.4, 0.6], [0.3, 0.2, 1.0]);
    state.quaternion = state.quaternion.map(|c| 1.2 * c);
    for _ in 0..3000 {
        vehicle.step(&mut state, &Inputs::default(), 0.01);
    }
    let norm: f64 = state.quaternion.iter().map(|c| c * c).sum();
    assert_relative_eq!(norm, 1.0, epsilon = 1e-9);
}

#[test]
fn mass_matrix_is_symmetric_and_positive_definite_in_every_set() {
    for set in [ParameterSet::Uuv, ParameterSet::UuvDiagonal, ParameterSet::Paper] {
        let m = mass_matrix(&Parameters::preset(set));
        assert_eq!(m, m.transpose());
        assert!(m.symmetric_eigenvalues().min() > 500.0);
    }
}

#[test]
fn a_minute_of_mixed_thrust_agrees_between_step_sizes() {
    let vehicle = Vehicle::new(&Parameters::default()).unwrap();
    let run = |h: f64, steps_per_second: usize| {
        let mut state = state([0.0; 6], [0.1, -0.05, 0.7]);
        for i in 0..60 * steps_per_second {
            // Commands change at 50 Hz, like the controller's, and equally in both runs.
            let t = (i * 50 / steps_per_second) as f64 / 50.0;
            let thruster_force =
                core::array::from_fn(|k| 100.0 * libm::sin((0.2 + 0.05 * k as f64) * t));
            let current_ned = [0.1, -0.2, 0.02];
            let inputs = Inputs { thruster_force, current_ned, ..Inputs::default() };
            vehicle.step(&mut state, &inputs, h);
        }
        state
    };
    let (coarse, fine) = (run(0.01, 100), run(0.001, 1000));
    for i in 0..3 {
        let difference = coarse.p_ned[i] - fine.p_ned[i];
        assert!(difference.abs() < 1e-6, "{difference:e} m on axis {i}");
    }
}

/// The state as 21 numbers.
fn flat(x: &State) -> Vec<f64> {
    [&x.p_ned[..], &x.quaternion, &x.nu, &x.rotor_speed].concat()
}

/// `x + h k`, number by number.
fn moved(x: &State, k: &[f64], h: f64) -> State {
    let sum: Vec<f64> = flat(x).iter().zip(k).map(|(x, k)| x + h * k).collect();
    let part = |begin: usize, end: usize| &sum[begin..end];
    State {
        p_ned: part(0, 3).try_into().unwrap(),
        quaternion: part(3, 7).try_into().unwrap(),
        nu: part(7, 13).try_into().unwrap(),
        rotor_speed: part(13, 21).try_into().unwrap(),
    }
}

#[test]
fn a_step_with_rotors_in_closed_form_is_a_general_runge_kutta_of_many_short_ones() {
    for mode in [ThrusterMode::ForceWithLag, ThrusterMode::Force, ThrusterMode::RotorSpeed] {
        let mut p = Parameters::default();
        p.propulsion.mode = mode;
        let vehicle = Vehicle::new(&p).unwrap();
        let inputs = Inputs {
            thruster_force: [50.0, -20.0, 3000.0, 10.0, 100.0, 80.0, -90.0, -60.0],
            thruster_speed: [50.0, -20.0, 30.0, 1e5, 100.0, 80.0, -90.0, -60.0],
            wrench: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            current_ned: [0.1, -0.2, 0.03],
            thruster_loss: [0.0, 1.0, 0.3, -0.05, 2.0, 0.0, 0.5, 0.0],
        };
        let mut stepped = state([0.3, 0.2, -0.1, 0.05, -0.04, 0.1], [0.2, -0.1, 2.0]);
        let mut general = stepped;
        let (drive, parts) = (vehicle.drive(&inputs), 20);
        let (long, h) = (0.01, 0.01 / f64::from(parts));
        for _ in 0..100 {
            vehicle.step(&mut stepped, &inputs, long);
            for _ in 0..parts {
                let f = |x: &State| {
                    let rate = vehicle.derivative(x, &inputs);
                    assert_eq!(rate, vehicle.rate(x, &drive));
                    flat(&rate)
                };
                let k1 = f(&general);
                let k2 = f(&moved(&general, &k1, 0.5 * h));
                let k3 = f(&moved(&general, &k2, 0.5 * h));
                let k4 = f(&moved(&general, &k3, h));
                let mut slope = k1;
                for (k, weight) in [(k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                    slope.iter_mut().zip(k).for_each(|(s, k)| *s += weight * k);
                }
                general = moved(&general, &slope, h / 6.0);
            }
        }
        for (place, (a, b)) in flat(&stepped).iter().zip(flat(&general)).enumerate() {
            assert!((a - b).abs() < 1e-5 * b.abs().max(0.1), "{mode:?}, {place}: {a} and {b}");
        }
        for (a, b) in stepped.rotor_speed.iter().zip(general.rotor_speed) {
            assert!((a - b).abs() <= 1e-8 * b.abs(), "{mode:?}: {a} and {b}");
        }
    }
}
