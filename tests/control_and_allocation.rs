//! Thrust allocation and the velocity controller.

use approx::assert_relative_eq;
use proptest::prelude::*;
use rexrov::allocation::Allocation;
use rexrov::control::*;
use rexrov::vehicle::{Inputs, Parameters, Propulsion, State, Thruster, Vehicle};

fn allocation() -> Allocation {
    Allocation::new(&Propulsion::default().thrusters).unwrap()
}

fn single(pattern: [f64; 4]) -> [f64; 6] {
    let [a, b, c, d] = pattern;
    allocation().wrench(&[0.0, 0.0, 0.0, 0.0, a, b, c, d])
}

#[test]
fn horizontal_patterns_give_surge_sway_and_yaw() {
    let half = core::f64::consts::FRAC_1_SQRT_2;
    let surge = single([1.0, 1.0, -1.0, -1.0]);
    assert_relative_eq!(surge[0], 4.0 * half, epsilon = 1e-12);
    assert_relative_eq!(surge[5], 0.0, epsilon = 1e-12);
    let sway = single([1.0, -1.0, 1.0, -1.0]);
    assert_relative_eq!(sway[1], 4.0 * half, epsilon = 1e-12);
    assert_relative_eq!(sway[0], 0.0, epsilon = 1e-12);
    let yaw = single([-1.0, 1.0, 1.0, -1.0]);
    assert!(yaw[5] > 2.5 && yaw[0].abs() < 1e-12 && yaw[1].abs() < 1e-12, "{yaw:?}");
    let lift = allocation().wrench(&[1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(lift[2] < -3.8 && lift[3].abs() < 1e-12 && lift[5].abs() < 1e-12, "{lift:?}");
}

#[test]
fn a_thruster_acts_along_its_axis_at_its_place() {
    let t = Thruster { lx: 1.0, ly: 2.0, lz: 3.0, theta_deg: 90.0, psi_deg: 0.0 };
    // Straight up: pitches the bow up from ahead, rolls to port from starboard.
    let expected = [0.0, 0.0, -1.0, -2.0, 1.0, 0.0];
    for (value, expected) in t.unit_wrench().iter().zip(expected) {
        assert_relative_eq!(*value, expected, epsilon = 1e-12);
    }
}

proptest! {
    #[test]
    fn allocated_forces_give_the_wrench_with_the_least_effort(
        wrench in prop::array::uniform6(-1000.0..1000.0), other in prop::array::uniform8(-1.0..1.0)
    ) {
        let allocation = allocation();
        let forces = allocation.forces(&wrench);
        let back = allocation.wrench(&forces);
        for i in 0..6 {
            prop_assert!((back[i] - wrench[i]).abs() < 1e-8, "{wrench:?} {back:?}");
        }
        // Orthogonal to everything that makes no wrench: the part of `other` in the null space.
        let seen = allocation.forces(&allocation.wrench(&other));
        let product: f64 = (0..8).map(|i| forces[i] * (other[i] - seen[i])).sum();
        prop_assert!(product.abs() < 1e-7, "{product}");
    }
}

#[test]
fn thrusters_that_cannot_act_in_all_directions_are_refused() {
    let mut thrusters = Propulsion::default().thrusters;
    for t in &mut thrusters {
        t.theta_deg = 0.0;
    }
    let error = Allocation::new(&thrusters).unwrap_err();
    assert!(error.reason.contains("rank below 6"), "{error}");
    thrusters[2].lx = f64::NAN;
    assert_eq!(Allocation::new(&thrusters).unwrap_err().name, "thrusters[2].lx");
}

struct Loop {
    vehicle: Vehicle,
    controller: VelocityController,
    memory: ControllerMemory,
    state: State,
    demand: Demand,
}

impl Loop {
    fn new() -> Self {
        Self {
            vehicle: Vehicle::new(&Parameters::default()).unwrap(),
            controller: VelocityController::new(&ControllerParameters::default()).unwrap(),
            memory: ControllerMemory::default(),
            state: State::default(),
            demand: Demand::default(),
        }
    }

    fn run(&mut self, command: [f64; 4], seconds: usize) {
        for _ in 0..50 * seconds {
            self.demand = self.controller.update(&mut self.memory, command, self.state.nu);
            assert!(self.demand.force.iter().all(|f| f.abs() <= 2000.0));
            let inputs = Inputs { thruster_force: self.demand.force, ..Inputs::default() };
            for _ in 0..2 {
                self.vehicle.step(&mut self.state, &inputs, 0.01);
            }
        }
    }
}

#[test]
fn velocity_commands_are_met_without_offset_even_in_a_turn() {
    let mut control = Loop::new();
    control.run([0.3, 0.0, 0.05, 0.2], 40);
    for (i, expected) in [(0, 0.3), (1, 0.0), (2, 0.05), (5, 0.2)] {
        assert_relative_eq!(control.state.nu[i], expected, epsilon = 2e-3);
    }
}

#[test]
fn a_step_beyond_the_limits_of_the_thrusters_does_not_wind_up() {
    let mut control = Loop::new();
    let first =
        control.controller.update(&mut ControllerMemory::default(), [1.0, 0.0, 0.0, 0.0], [0.0; 6]);
    assert!(first.wrench[0] > 5657.0 && first.force[4] == 2000.0, "{first:?}");
    let mut fastest = 0.0_f64;
    for _ in 0..20 {
        control.run([1.0, 0.0, 0.0, 0.0], 1);
        fastest = fastest.max(control.state.nu[0]);
    }
    // An integral summed up while the thrusters were at their limit would overshoot by more.
    assert!(fastest < 1.1, "{fastest}");
    assert_relative_eq!(control.state.nu[0], 1.0, epsilon = 0.01);
}

#[test]
fn an_error_that_the_thrusters_cannot_work_off_is_forgotten() {
    let p = ControllerParameters { thrust_limit: 200.0, ..ControllerParameters::default() };
    let mut control = Loop { controller: VelocityController::new(&p).unwrap(), ..Loop::new() };
    control.run([0.0, 0.0, 1.0, 0.0], 60);
    assert!(control.state.nu[2] < 0.5, "{:?}", control.state.nu);
    control.run([0.0, 0.0, 0.0, 0.0], 10);
    assert_relative_eq!(control.state.nu[2], 0.0, epsilon = 0.02);
}

#[test]
fn gains_out_of_range_are_named() {
    let mut p = ControllerParameters::default();
    p.linear.p = -1.0;
    assert_eq!(VelocityController::new(&p).unwrap_err().name, "linear.p");
    let p = ControllerParameters { mass: 0.0, ..ControllerParameters::default() };
    assert_eq!(VelocityController::new(&p).unwrap_err().name, "mass");
}
