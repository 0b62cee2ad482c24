//! Motions of the vehicle with known results: force balances and small oscillations.

use approx::assert_relative_eq;
use rexrov::vehicle::{
    Inputs, ParameterSet, Parameters, ReducedModel, State, ThrusterMode, Vehicle,
};

const STEP: f64 = 0.01;

fn diagonal_sets() -> [Parameters; 2] {
    [ParameterSet::Paper, ParameterSet::UuvDiagonal].map(Parameters::preset)
}

/// The set with its weight set equal to its buoyancy, for motions without heave.
fn neutral(mut p: Parameters) -> Parameters {
    p.buoyancy = Some(p.buoyancy_force());
    p.gravity = p.buoyancy_force() / p.mass;
    p
}

fn simulate(p: &Parameters, inputs: &Inputs, seconds: f64) -> State {
    let vehicle = Vehicle::new(p).unwrap();
    let mut state = State::default();
    for _ in 0..(seconds / STEP).round() as usize {
        vehicle.step(&mut state, inputs, STEP);
    }
    state
}

#[test]
fn floats_up_at_the_speed_where_drag_balances_buoyancy() {
    for (p, speed) in diagonal_sets().iter().zip([0.11824, 0.22977]) {
        let state = simulate(p, &Inputs::default(), 60.0);
        assert_relative_eq!(state.nu[2], -speed, epsilon = 1e-5);
    }
}

#[test]
fn surge_reaches_the_speed_where_drag_balances_thrust() {
    // Directions of thrusters 4 to 7 at 45 degrees: four times cos(45 deg) forward.
    let full = 4.0 * 2000.0 * core::f64::consts::FRAC_1_SQRT_2;
    for (force, speed) in [(89.79, 0.300), (707.1, 0.92342), (full, 2.70008)] {
        for p in diagonal_sets() {
            let inputs = Inputs { wrench: [force, 0.0, 0.0, 0.0, 0.0, 0.0], ..Inputs::default() };
            let state = simulate(&neutral(p), &inputs, 120.0);
            assert_relative_eq!(state.nu[0], speed, epsilon = 2e-5);
        }
    }
}

#[test]
fn the_four_horizontal_thrusters_at_their_limit_give_full_speed() {
    let mut p = neutral(Parameters::preset(ParameterSet::UuvDiagonal));
    p.propulsion.mode = ThrusterMode::Force;
    // Above the limit on purpose. They are 0.129 m above the centre of gravity, so the bow drops:
    // no moment from it here.
    p.propulsion.thrusters.iter_mut().skip(4).for_each(|t| t.lz = 0.0);
    let thruster_force = [0.0, 0.0, 0.0, 0.0, 3000.0, 3000.0, -3000.0, -3000.0];
    let state = simulate(&p, &Inputs { thruster_force, ..Inputs::default() }, 60.0);
    assert_relative_eq!(state.nu[0], 2.70008, epsilon = 2e-5);
}

#[test]
fn yaw_reaches_the_rate_where_damping_balances_the_moment() {
    let inputs = Inputs { wrench: [0.0, 0.0, 0.0, 0.0, 0.0, 259.52], ..Inputs::default() };
    for p in diagonal_sets() {
        let state = simulate(&neutral(p), &inputs, 60.0);
        assert_relative_eq!(state.nu[5], 0.611023, epsilon = 2e-6);
    }
}

/// Period (s) and damping ratio of a small oscillation of Euler angle `axis`, from the times of its
/// first zero crossings and the heights of its first extremes.
fn oscillation(p: &Parameters, axis: usize) -> (f64, f64) {
    // Small enough that quadratic damping does not matter.
    let mut angles = [0.0; 3];
    angles[axis] = 1e-4;
    let vehicle = Vehicle::new(&neutral(*p)).unwrap();
    let mut state = State::at_rest([0.0; 3], angles);
    let (mut last, mut crossings, mut extremes) = (1e-4, Vec::new(), vec![0.0_f64]);
    let h = 1e-3;
    for i in 0..20_000 {
        vehicle.step(&mut state, &Inputs::default(), h);
        let angle = vehicle.outputs(&state, &Inputs::default()).euler[axis];
        if angle * last < 0.0 {
            crossings.push((f64::from(i) + last / (last - angle)) * h);
            extremes.push(0.0);
        }
        let peak = extremes.last_mut().unwrap();
        *peak = peak.max(angle.abs());
        last = angle;
    }
    let decrement = (extremes[1] / extremes[3]).ln();
    let ratio = decrement / decrement.hypot(core::f64::consts::TAU);
    (crossings[2] - crossings[0], ratio)
}

#[test]
fn roll_and_pitch_swing_like_a_damped_pendulum() {
    for (p, [roll, pitch]) in diagonal_sets().iter().zip([[2.754, 3.422], [2.743, 3.409]]) {
        for (axis, expected) in [(0, roll), (1, pitch)] {
            let (period, ratio) = oscillation(p, axis);
            // The list gives undamped periods, 0.15 % shorter than the damped ones.
            let undamped = period * (1.0 - ratio * ratio).sqrt();
            assert_relative_eq!(undamped, expected, epsilon = 0.006);
            assert_relative_eq!(ratio, 0.055, epsilon = 0.006);
        }
    }
}

#[test]
fn straight_surge_is_directionally_unstable_by_the_munk_moment() {
    let p = neutral(Parameters::preset(ParameterSet::UuvDiagonal));
    let a = [p.added_mass[0][0], p.added_mass[1][1], p.added_mass[5][5]];
    // Growth rate of a small disturbance of sway and yaw rate about a steady surge u.
    let growth = |u: f64| {
        let (m11, m22, m66) = (p.mass + a[0], p.mass + a[1], p.inertia.zz + a[2]);
        let j = [
            [-p.linear_damping[1] / m22, -m11 * u / m22],
            [-(a[1] - a[0]) * u / m66, -p.linear_damping[5] / m66],
        ];
        let (trace, det) = (j[0][0] + j[1][1], j[0][0] * j[1][1] - j[0][1] * j[1][0]);
        0.5 * (trace + (trace * trace - 4.0 * det).sqrt())
    };
    assert!(growth(0.078) < 0.0 && growth(0.080) > 0.0, "{} {}", growth(0.078), growth(0.080));

    let vehicle = Vehicle::new(&p).unwrap();
    let u: f64 = 0.3;
    let drag = (p.linear_damping[0] + p.quadratic_damping[0] * u) * u;
    let inputs = Inputs { wrench: [drag, 0.0, 0.0, 0.0, 0.0, 0.0], ..Inputs::default() };
    let mut state = State { nu: [u, 1e-9, 0.0, 0.0, 0.0, -1e-9], ..State::default() };
    let mut rates = Vec::new();
    for _ in 0..6000 {
        vehicle.step(&mut state, &inputs, STEP);
        rates.push(state.nu[5].abs());
    }
    let measured = (rates[5999] / rates[4999]).ln() / 10.0;
    assert_relative_eq!(measured, growth(u), epsilon = 1e-4);
    assert_relative_eq!(measured, 0.13, epsilon = 0.005);
}

#[test]
fn uncontrolled_sway_in_a_turn_reaches_half_a_metre_a_second() {
    // Surge and turn rate held at 0.3 m/s and 0.33 rad/s: sway settles where its drag balances the
    // centripetal force of vehicle and added mass.
    let p = neutral(Parameters::preset(ParameterSet::UuvDiagonal));
    let model = ReducedModel::new(&p).unwrap();
    let mut v = 0.0;
    for _ in 0..100_000 {
        v += STEP * model.acceleration([0.3, v, 0.0, 0.33], &[0.0; 8])[1];
    }
    assert_relative_eq!(v, -0.47, epsilon = 0.01);
}

#[test]
fn the_accelerometer_shows_minus_g_at_rest_in_any_attitude() {
    let p = Parameters::default();
    let buoyancy = Some(p.weight());
    let p = Parameters { centre_of_buoyancy: [0.0; 3], buoyancy, ..p };
    let vehicle = Vehicle::new(&p).unwrap();
    let level = vehicle.outputs(&State::default(), &Inputs::default());
    assert_relative_eq!(level.specific_force[2], -9.81, epsilon = 1e-12);
    let bow_up = State::at_rest([0.0; 3], [0.0, core::f64::consts::FRAC_PI_2, 0.0]);
    let out = vehicle.outputs(&bow_up, &Inputs::default());
    assert_relative_eq!(out.specific_force[0], 9.81, epsilon = 1e-12);
}

#[test]
fn rotor_speed_follows_its_command_as_a_first_order_lag() {
    let mut p = Parameters::default();
    p.propulsion.mode = ThrusterMode::RotorSpeed;
    let inputs = Inputs { thruster_speed: [100.0; 8], ..Inputs::default() };
    let state = simulate(&p, &inputs, 0.05);
    assert_relative_eq!(state.rotor_speed[3], 100.0 * (1.0 - (-1.0_f64).exp()), epsilon = 1e-3);
    p.propulsion.mode = ThrusterMode::ForceWithLag;
    let inputs = Inputs { thruster_force: [-3.1; 8], ..Inputs::default() };
    let state = simulate(&p, &inputs, 2.0);
    assert_relative_eq!(state.rotor_speed[0], -100.0, epsilon = 1e-9);
    let thrust = Vehicle::new(&p).unwrap().outputs(&state, &inputs).thrust[0];
    assert_relative_eq!(thrust, -3.1, epsilon = 1e-9);
}
