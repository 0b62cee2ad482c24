//! The declarations of the mathematics: names are unique, numbers lie in their order, and start
//! values are within their bounds.

use fmu_quantity::{Declarations, Field, Reader, Start, Variables, Writer};
use rexrov::control::ControllerParameters;
use rexrov::environment::DisturbanceParameters;
use rexrov::estimation::paper::EkfParameters;
use rexrov::estimation::{ModelErrors, NavigationParameters};
use rexrov::guidance::PursuitParameters;
use rexrov::sensors::*;
use rexrov::vehicle::{Inputs, Outputs, Parameters, State};
use std::collections::HashSet;

fn declared<Q: Variables>(quantities: &Q) -> Declarations {
    let mut list = Declarations::new();
    quantities.declare(&Field::default(), &mut list);
    list
}

/// The numbers 1, 2, 3 … as loaded from a flat array, for a group of Reals.
fn numbered<Q: Variables>() -> (Q, Vec<f64>) {
    let numbers: Vec<f64> = (0..Q::COUNT.reals).map(|i| 1.0 + i as f64).collect();
    (Q::load(&mut Reader { reals: &numbers, ..Reader::default() }), numbers)
}

fn in_order<Q: Variables + Copy>() {
    let (loaded, numbers) = numbered::<Q>();
    let starts: Vec<Start> = declared(&loaded).into_iter().map(|d| d.start).collect();
    assert_eq!(starts, numbers.iter().map(|n| Start::Real(*n)).collect::<Vec<_>>());
    let mut stored = vec![0.0; numbers.len()];
    loaded.store(&mut Writer { reals: &mut stored, ..Writer::default() });
    assert_eq!(stored, numbers);
    let (mut walked, mut copy) = (Vec::new(), loaded);
    copy.zip_reals(&loaded, &mut |own, number| {
        assert_eq!(*own, number);
        walked.push(number);
    });
    assert_eq!(walked, numbers);
}

#[test]
fn numbers_lie_in_the_order_of_their_names() {
    in_order::<State>();
    in_order::<Inputs>();
    in_order::<Outputs>();
    in_order::<ImuTruth>();
    in_order::<ImuSample>();
    in_order::<DvlTruth>();
}

#[test]
fn the_inputs_of_a_thruster_are_together() {
    let (inputs, _) = numbered::<Inputs>();
    assert_eq!((inputs.thruster_force[0], inputs.thruster_loss[0]), (1.0, 3.0));
    assert_eq!((inputs.thruster_speed[7], inputs.wrench[0]), (23.0, 25.0));
    let names: Vec<String> = declared(&inputs).into_iter().map(|d| d.field.name).collect();
    assert_eq!(names[2..5], ["thruster[0].loss", "thruster[1].force", "thruster[1].speed"]);
    assert_eq!(names[32], "current.down");
}

#[test]
fn start_values_are_within_their_bounds_and_names_are_unique() {
    let all = [
        declared(&ImuParameters::default()),
        declared(&AhrsParameters::default()),
        declared(&DvlParameters::default()),
        declared(&GpsParameters::default()),
        declared(&PressureParameters::default()),
        declared(&TachometerParameters::default()),
        declared(&NavigationParameters::default()),
        declared(&ModelErrors::default()),
        declared(&EkfParameters::default()),
        declared(&PursuitParameters::default()),
        declared(&ControllerParameters::default()),
        declared(&DisturbanceParameters::default()),
        declared(&Parameters::default()),
    ];
    for list in all {
        let mut names = HashSet::new();
        for quantity in &list {
            let field = &quantity.field;
            assert!(names.insert(&field.name), "{} twice", field.name);
            if let Start::Real(value) = quantity.start {
                assert!(field.unit.is_some() || field.name == "guard_speed", "{}", field.name);
                let (min, max) = (field.min.unwrap_or(f64::MIN), field.max.unwrap_or(f64::MAX));
                assert!((min..=max).contains(&value), "{} = {value}", field.name);
            }
        }
    }
}
