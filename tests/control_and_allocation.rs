//! Thrust allocation and the velocity controller.

use approx::assert_relative_eq;
use nalgebra::{SMatrix, SVector};
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
fn without_a_geometry_there_is_no_allocation() {
    let mut thrusters = Propulsion::default().thrusters;
    thrusters[2].lx = f64::NAN;
    assert_eq!(Allocation::new(&thrusters).unwrap_err().name, "thruster[2].lx");
    thrusters[2].lx = 1e200;
    assert!(Allocation::new(&thrusters).unwrap_err().reason.contains("size"));
    let error = Allocation::new(&[ABSENT; 8]).unwrap_err();
    assert!(error.reason.contains("at least one thruster"), "{error}");
}

const ABSENT: Thruster = Thruster { lx: 0.0, ly: 0.0, lz: 0.0, theta_deg: 0.0, psi_deg: 0.0 };

/// What thrusters deliver for given commands.
fn given(command: &[f64; 8], loss: &[f64; 8]) -> [f64; 8] {
    core::array::from_fn(|i| command[i] * (1.0 - loss[i]))
}

/// The allocation matrix of thrusters with losses.
fn effective(loss: &[f64; 8]) -> SMatrix<f64, 6, 8> {
    let columns = Propulsion::default().thrusters.map(|t| t.unit_wrench());
    SMatrix::from_fn(|i, j| columns[j][i] * (1.0 - loss[j]))
}

fn lost(thrusters: &[usize]) -> [f64; 8] {
    core::array::from_fn(|i| f64::from(u8::from(thrusters.contains(&i))))
}

/// Every one and every two thrusters.
fn losses() -> impl Iterator<Item = [f64; 8]> {
    (0..8).flat_map(|i| (i..8).map(move |j| lost(&[i, j])))
}

proptest! {
    #[test]
    fn without_loss_the_allocation_is_the_pseudo_inverse_to_the_bit(
        wrench in prop::array::uniform6(-1000.0..1000.0)
    ) {
        let mut cache = None;
        let with = |loss: f64, cache: &mut _| {
            allocation().forces_with_loss(&[loss; 8], cache, &wrench).map(f64::to_bits)
        };
        let healthy = allocation().forces(&wrench).map(f64::to_bits);
        for none in [0.0, -0.0, -1.0, f64::NAN] {
            prop_assert_eq!(with(none, &mut cache), healthy);
        }
        // Also after a loss that was a false alarm.
        prop_assert!(with(0.5, &mut cache) != healthy);
        prop_assert_eq!(with(0.0, &mut cache), healthy);
    }

    #[test]
    fn with_one_or_two_thrusters_lost_the_rest_gives_the_wrench_while_the_rank_is_six(
        wrench in prop::array::uniform6(-1000.0..1000.0)
    ) {
        let mut met = 0;
        for loss in losses() {
            let forces = allocation().forces_with_loss(&loss, &mut None, &wrench);
            prop_assert!((0..8).all(|i| loss[i] == 0.0 || forces[i] == 0.0));
            if effective(&loss).rank(1e-6) == 6 {
                let back = allocation().wrench(&given(&forces, &loss));
                for i in 0..6 {
                    prop_assert!((back[i] - wrench[i]).abs() < 1e-3, "{loss:?} {back:?}");
                }
                met += 1;
            }
        }
        // All but two of the vertical ones or two horizontal ones on a diagonal.
        prop_assert_eq!(met, 8 + 28 - 6 - 2);
    }

    #[test]
    fn with_any_loss_the_thrusts_are_the_smallest_that_come_nearest_to_the_wrench(
        loss in prop::array::uniform8(prop_oneof![Just(0.0), Just(1.0), 0.0..0.8]),
        wrench in prop::array::uniform6(-1000.0..1000.0), other in prop::array::uniform8(-1.0..1.0)
    ) {
        let a = effective(&loss);
        let forces = |wrench: SVector<f64, 6>| {
            SVector::from(allocation().forces_with_loss(&loss, &mut None, &wrench.into()))
        };
        let (demand, other) = (SVector::from(wrench), SVector::from(other));
        let found = forces(demand);
        prop_assert!(found.norm() <= 16.0 * demand.norm(), "{found}");
        // Except in directions in which the thrusters hardly act: the normal equations, and
        // orthogonal to everything that makes no wrench.
        let squares = (a * a.transpose()).symmetric_eigenvalues();
        prop_assume!(squares.iter().all(|s| !(1e-9..0.03).contains(s)));
        let residual = a.transpose() * (a * found - demand);
        prop_assert!(residual.norm() <= 1e-6 * demand.norm(), "{residual}");
        let product = found.dot(&(other - forces(a * other)));
        prop_assert!(product.abs() <= 1e-5 * demand.norm(), "{product}");
    }
}

#[test]
fn the_cache_follows_the_losses() {
    let (mut cache, wrench) = (None, [100.0, 20.0, -50.0, 10.0, 5.0, 30.0]);
    for loss in losses() {
        let fresh = allocation().forces_with_loss(&loss, &mut None, &wrench);
        assert_eq!(allocation().forces_with_loss(&loss, &mut cache, &wrench), fresh);
        assert_eq!(allocation().forces_with_loss(&loss, &mut cache, &wrench), fresh);
    }
}

#[test]
fn a_thruster_that_hardly_pushes_is_not_asked_for_the_impossible() {
    let mut loss = lost(&[0, 1]);
    loss[1] = 0.985;
    // The direction in which only this thruster acts.
    let a = effective(&loss);
    let squares = (a * a.transpose()).symmetric_eigen();
    let least = squares.eigenvalues.imin();
    // The pseudo-inverse alone would require more than 5000 N.
    assert!(squares.eigenvalues[least].sqrt() < 0.02);
    let wrench = SVector::from(squares.eigenvectors.column(least)) * 100.0;
    let forces = allocation().forces_with_loss(&loss, &mut None, &wrench.into());
    let most = SVector::from(forces).amax();
    assert!(most < 1600.0, "{most}");
}

#[test]
fn a_vehicle_without_some_thrusters_is_one_that_has_lost_them() {
    let wrench = [100.0, 20.0, -50.0, 10.0, 5.0, 30.0];
    for loss in losses() {
        let mut thrusters = Propulsion::default().thrusters;
        (0..8).filter(|&i| loss[i] == 1.0).for_each(|i| thrusters[i] = ABSENT);
        let forces = Allocation::new(&thrusters).unwrap().forces(&wrench);
        let expected = allocation().forces_with_loss(&loss, &mut None, &wrench);
        for (force, expected) in forces.iter().zip(expected) {
            assert_relative_eq!(*force, expected, epsilon = 1e-3);
        }
    }
}

struct Loop {
    vehicle: Vehicle,
    controller: VelocityController,
    memory: ControllerMemory,
    state: State,
    demand: Demand,
    /// For each thruster, as known to the controller and as in the vehicle.
    loss: [f64; 8],
}

impl Loop {
    fn new() -> Self {
        Self {
            vehicle: Vehicle::new(&Parameters::default()).unwrap(),
            controller: VelocityController::new(&ControllerParameters::default()).unwrap(),
            memory: ControllerMemory::default(),
            state: State::default(),
            demand: Demand::default(),
            loss: [0.0; 8],
        }
    }

    fn run(&mut self, command: [f64; 4], seconds: usize) {
        for _ in 0..50 * seconds {
            self.demand =
                self.controller.update(&mut self.memory, command, self.state.nu, &self.loss);
            assert!(self.demand.force.iter().all(|f| f.abs() <= 2000.0));
            let inputs = Inputs {
                thruster_force: given(&self.demand.force, &self.loss),
                ..Inputs::default()
            };
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
    let first = control.controller.update(
        &mut ControllerMemory::default(),
        [1.0, 0.0, 0.0, 0.0],
        [0.0; 6],
        &[0.0; 8],
    );
    assert!(first.wrench[0] > 5657.0 && first.force[4] == 2000.0, "{first:?}");
    let mut fastest = 0.0_f64;
    for _ in 0..20 {
        control.run([1.0, 0.0, 0.0, 0.0], 1);
        fastest = fastest.max(control.state.nu[0]);
    }
    // An integral accumulated while the thrusters were at their limit would overshoot by more.
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
fn velocity_commands_are_met_with_any_two_thrusters_lost() {
    for command in [[0.3, 0.0, 0.05, 0.1], [0.3, 0.0, -0.1, 0.05]] {
        let [u, v, w, r] = command;
        for loss in losses() {
            let mut control = Loop { loss, ..Loop::new() };
            control.run(command, 60);
            for (i, expected) in [(0, u), (1, v), (2, w), (5, r)] {
                assert_relative_eq!(control.state.nu[i], expected, epsilon = 5e-3);
            }
        }
    }
}

#[test]
fn gains_out_of_range_are_named() {
    let mut p = ControllerParameters::default();
    p.linear.p = -1.0;
    assert_eq!(VelocityController::new(&p).unwrap_err().name, "linear.p");
    let p = ControllerParameters { mass: 0.0, ..ControllerParameters::default() };
    assert_eq!(VelocityController::new(&p).unwrap_err().name, "mass");
}
