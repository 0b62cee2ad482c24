//! Propellers that lose part of their thrust while their rotors turn as before.

use approx::assert_relative_eq;
use rexrov::vehicle::{Inputs, Parameters, State, ThrusterMode, Vehicle};

const MODES: [ThrusterMode; 3] =
    [ThrusterMode::ForceWithLag, ThrusterMode::Force, ThrusterMode::RotorSpeed];

fn vehicle(mode: ThrusterMode) -> Vehicle {
    let mut p = Parameters::default();
    p.propulsion.mode = mode;
    Vehicle::new(&p).unwrap()
}

fn state() -> State {
    State {
        rotor_speed: [100.0, -200.0, 300.0, 50.0, -60.0, 70.0, 80.0, -90.0],
        ..State::at_rest([0.0, 0.0, 20.0], [0.1, -0.1, 1.0])
    }
}

fn commanded() -> Inputs {
    Inputs {
        thruster_force: [30.0, -20.0, 3000.0, 10.0, 100.0, 80.0, -90.0, -60.0],
        thruster_speed: [50.0, -20.0, 30.0, 1e5, 100.0, 80.0, -90.0, -60.0],
        ..Inputs::default()
    }
}

#[test]
fn a_loss_takes_its_fraction_of_the_thrust_and_nothing_of_the_rotor() {
    let loss = [0.0, 1.0, 2.0, 0.5, -0.1, 0.0, 0.25, 0.0];
    for mode in MODES {
        let (vehicle, x) = (vehicle(mode), state());
        let damaged = Inputs { thruster_loss: loss, ..commanded() };
        let (sound, hit) = (vehicle.outputs(&x, &commanded()), vehicle.outputs(&x, &damaged));
        for ((hit, sound), loss) in hit.thrust.iter().zip(sound.thrust).zip(loss) {
            assert_relative_eq!(*hit, (1.0 - loss) * sound, max_relative = 1e-14);
        }
        assert_eq!(hit.rotor_speed, sound.rotor_speed);
        let (a, b) = (vehicle.derivative(&x, &commanded()), vehicle.derivative(&x, &damaged));
        assert_eq!(a.rotor_speed, b.rotor_speed);
        assert_ne!(a.nu, b.nu);
        assert_eq!(b.nu, hit.nu_dot);
    }
}

#[test]
fn a_lost_propeller_is_one_that_is_not_there() {
    let mut without = Parameters::default();
    without.propulsion.mode = ThrusterMode::Force;
    let (vehicle, x) = (Vehicle::new(&without).unwrap(), state());
    let mut stopped = commanded();
    stopped.thruster_force[4] = 0.0;
    let mut lost = commanded();
    lost.thruster_loss[4] = 1.0;
    assert_eq!(vehicle.derivative(&x, &stopped).nu, vehicle.derivative(&x, &lost).nu);
}

#[test]
fn the_rotor_speed_is_that_of_the_state_or_of_the_force_that_acts_at_once() {
    for mode in [ThrusterMode::ForceWithLag, ThrusterMode::RotorSpeed] {
        assert_eq!(vehicle(mode).outputs(&state(), &commanded()).rotor_speed, state().rotor_speed);
    }
    let y = vehicle(ThrusterMode::Force).outputs(&state(), &commanded());
    for (thrust, w) in y.thrust.iter().zip(y.rotor_speed) {
        assert_relative_eq!(*thrust, 0.00031 * w * w.abs(), max_relative = 1e-14);
    }
}
