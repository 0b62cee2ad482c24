//! Guidance and velocity control steer the vehicle along the courses: true pose, and velocity like
//! that of a navigation filter, with noise and without roll and pitch rate.

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rexrov::control::{ControllerMemory, ControllerParameters, VelocityController};
use rexrov::guidance::{Course, PurePursuit, PursuitMemory, PursuitParameters};
use rexrov::vehicle::{Inputs, Parameters, State, Vehicle};

/// Standard deviation of the velocity given to the controller (m/s, rad/s).
const SIGMA: f64 = 0.01;
/// Ticks of 10 ms between two cycles of the pursuit and of the controller, at 10 and 50 Hz.
const PURSUIT: usize = 10;
const CONTROLLER: usize = 2;

/// Mean distances from the course (m).
#[derive(Debug)]
struct Errors {
    horizontal: f64,
    vertical: f64,
}

/// Uniform noise.
fn noise(random: &mut ChaCha12Rng) -> f64 {
    let unit = random.next_u64() as f64 / u64::MAX as f64;
    SIGMA * 12.0_f64.sqrt() * (unit - 0.5)
}

/// Follows a course from its start to its end; the velocity is measured every `measured` ticks.
fn run(text: &str, measured: usize, loss: [f64; 8]) -> Errors {
    let course = Course::parse(text).unwrap();
    let start = [0.0, 0.0, course.depth(0.0).unwrap_or(20.0)];
    let limit = (course.length() / 0.3 * 1.2 * 100.0) as usize;
    let vehicle = Vehicle::new(&Parameters::default()).unwrap();
    let pursuit = PurePursuit::new(&PursuitParameters::default(), course).unwrap();
    let controller = VelocityController::new(&ControllerParameters::default()).unwrap();
    let (mut guided, mut controlled) = (PursuitMemory::default(), ControllerMemory::default());
    let mut random = ChaCha12Rng::seed_from_u64(1);
    let (mut state, mut inputs) = (State::at_rest(start, [0.0; 3]), Inputs::default());
    let (mut command, mut velocity) = ([0.0; 4], [0.0; 6]);
    let (mut horizontal, mut vertical, mut count) = (0.0, 0.0, 0.0);
    for tick in 0..limit {
        let truth = vehicle.outputs(&state, &inputs);
        if tick % measured == 0 {
            let [u, v, w, _, _, r] = truth.nu.map(|value| value + noise(&mut random));
            velocity = [u, v, w, 0.0, 0.0, r];
        }
        if tick % PURSUIT == 0 {
            let [x, y, z] = truth.p_ned;
            let guidance = pursuit.update(&mut guided, [x, y, z, truth.euler[2]]);
            if guidance.finished {
                return Errors { horizontal: horizontal / count, vertical: vertical / count };
            }
            command = guidance.command;
            horizontal += guidance.cross_track.abs();
            vertical += guidance.vertical_track.abs();
            count += 1.0;
        }
        if tick % CONTROLLER == 0 {
            let demand = controller.update(&mut controlled, command, velocity, &loss);
            inputs.thruster_force = core::array::from_fn(|i| demand.force[i] * (1.0 - loss[i]));
        }
        vehicle.step(&mut state, &inputs, 0.01);
    }
    panic!("not at the end after 1.2 times its time");
}

#[test]
fn every_course_is_followed_on_a_noisy_velocity_at_10_to_100_hz() {
    for (name, text) in Course::BUILT_IN {
        // After the sharp turn of BE1, the one wide place; at the kinks of HELIX, the deep ones.
        let horizontal = if name == "BE1" { 0.025 } else { 0.01 };
        let vertical = if name == "HELIX" { 0.04 } else { 0.012 };
        for measured in [1, 2, 5, 10] {
            let errors = run(text, measured, [0.0; 8]);
            assert!(errors.horizontal < horizontal, "{name} {measured} {errors:?}");
            assert!(errors.vertical < vertical, "{name} {measured} {errors:?}");
        }
    }
}

#[test]
fn with_any_one_or_two_thrusters_lost_the_vehicle_still_dives() {
    for text in [Course::DIVE, Course::HELIX] {
        for (i, j) in (0..8).flat_map(|i| (i..8).map(move |j| (i, j))) {
            let mut loss = [0.0; 8];
            (loss[i], loss[j]) = (1.0, 1.0);
            let errors = run(text, CONTROLLER, loss);
            let (horizontal, vertical) = if i == j { (0.01, 0.04) } else { (0.04, 0.15) };
            assert!(errors.horizontal < horizontal, "{i} {j} {errors:?}");
            assert!(errors.vertical < vertical, "{i} {j} {errors:?}");
        }
    }
}
