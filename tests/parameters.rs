//! Unphysical parameters are rejected, by name and with the reason.

use rexrov::vehicle::{ParameterSet, Parameters, Vehicle};

fn refused(change: impl FnOnce(&mut Parameters)) -> String {
    let mut p = Parameters::default();
    change(&mut p);
    Vehicle::new(&p).unwrap_err().to_string()
}

#[test]
fn every_named_set_is_accepted() {
    for set in [ParameterSet::Uuv, ParameterSet::UuvDiagonal, ParameterSet::Paper] {
        assert!(Vehicle::new(&Parameters::preset(set)).is_ok());
    }
}

#[test]
fn the_sets_have_the_weight_and_buoyancy_of_their_sources() {
    let near = |a: f64, b: f64| assert!((a - b).abs() < 0.01, "{a} {b}");
    let uuv = Parameters::default();
    near(uuv.weight(), 18274.75);
    near(uuv.buoyancy_force(), 18538.26);
    let paper = Parameters::preset(ParameterSet::Paper);
    near(paper.weight(), 18276.03);
    near(paper.buoyancy_force(), 18393.9972);
}

#[test]
fn values_out_of_range_are_named() {
    assert_eq!(
        refused(|p| p.mass = -1.0),
        "parameter `mass` = -1: must be at least 1e-9, and finite"
    );
    assert!(refused(|p| p.density = f64::NAN).starts_with("parameter `density` = NaN"));
    assert!(refused(|p| p.buoyancy = Some(-1.0)).contains("`buoyancy`"));
    assert!(refused(|p| p.linear_damping[4] = -1.0).contains("`linear_damping.q`"));
    assert!(refused(|p| p.propulsion.rotor_time_constant = 0.0).contains("`rotor_time_constant`"));
    assert!(refused(|p| p.propulsion.thrusters[6].psi_deg = f64::INFINITY).contains("[6].psi_deg"));
}

#[test]
fn matrices_must_be_symmetric_and_positive_definite() {
    let message = refused(|p| p.added_mass[4][1] = 100.0);
    assert!(message.contains("`added_mass[4][1]` = 100"), "{message}");
    assert!(message.contains("added_mass[1][4] = -5.8488"), "{message}");
    // Entered with the sign of the derivatives, as in equations 12 to 14.
    let message = refused(|p| p.added_mass = p.added_mass.map(|row| row.map(|a| -a)));
    assert!(message.contains("must be positive definite"), "{message}");
    let message = refused(|p| p.inertia.xy = 1e4);
    assert!(message.starts_with("parameter `inertia`"), "{message}");
}

#[test]
fn an_error_can_be_told_from_outside() {
    let p = Parameters { mass: 0.0, ..Parameters::default() };
    let error = Vehicle::new(&p).unwrap_err().within("vehicle");
    assert_eq!(error.name, "vehicle.mass");
}
