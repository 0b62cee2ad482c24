//! The vehicle, by its directional derivatives.

use std::collections::BTreeMap;

use fmu_kit::Start;
use fmu_kit::kernel::{Group, Instance, Interface, Status, Variable};

use crate::declared::{self, Declared};
use crate::subject::{Random, entry, instance, near, put};

const NAME: &str = "RexROV";
/// Random sets of parameters, and points with each.
const SETS: u64 = 60;
const POINTS: u64 = 4;

/// Slopes of one pair of unknown and known, by set of parameters.
type Slopes = BTreeMap<(usize, usize), Vec<(u64, f64)>>;

fn variables(groups: &[Group]) -> Vec<(usize, &'static Variable)> {
    let table = entry(NAME).table();
    let all = table.variables().iter().enumerate();
    let real = |v: &Variable| groups.contains(&v.group) && matches!(v.start, Start::Real(_));
    all.filter(|(_, v)| real(v)).collect()
}

/// In initialization mode, in any thruster mode and parameter set, coefficients near those of it.
fn starting(random: &mut Random) -> Instance {
    let mut vehicle = instance(NAME, Interface::ModelExchange);
    for (_, variable) in entry(NAME).table().group(Group::Parameter) {
        match (&variable.start, variable.name.as_str()) {
            (Start::Enumeration { .. }, _) => _ = put(&mut vehicle, variable, random),
            (Start::Real(_), "buoyancy") if random.next() < 0.5 => {
                vehicle.set_real(&[variable.reference], &[18_000.0 + 500.0 * random.next()]);
            }
            (Start::Real(_), name) if name.starts_with("initial.") => {
                vehicle.set_real(&[variable.reference], &[2.0 * random.next() - 1.0]);
            }
            (Start::Real(start), _) if *start != 0.0 => {
                let value = start * (0.95 + 0.1 * random.next());
                vehicle.set_real(&[variable.reference], &[value]);
            }
            _ => {}
        }
    }
    assert_eq!(vehicle.enter_initialization_mode(), Status::Ok);
    vehicle
}

/// Commands within and beyond their limits.
fn command(vehicle: &mut Instance, random: &mut Random) {
    for (_, input) in variables(&[Group::Input]) {
        vehicle.set_real(&[input.reference], &[2.5 * near(input, random)]);
    }
}

fn see(
    vehicle: &mut Instance,
    unknowns: &[(usize, &Variable)],
    knowns: &[(usize, &Variable)],
    set: u64,
    slopes: &mut Slopes,
) {
    let references: Vec<u32> = unknowns.iter().map(|(_, v)| v.reference).collect();
    let mut column = vec![0.0; unknowns.len()];
    for (known, variable) in knowns {
        let vr = [variable.reference];
        let status = vehicle.directional_derivative(&references, &vr, &[1.0], &mut column);
        assert_eq!(status, Status::Ok);
        for ((unknown, _), slope) in unknowns.iter().zip(&column) {
            slopes.entry((*unknown, *known)).or_default().push((set, *slope));
        }
    }
}

fn check(declared: &Declared, slopes: &Slopes) {
    let name = |index: usize| &entry(NAME).table().variables()[index].name;
    for (pair, kind) in declared.iter().filter(|(pair, _)| !slopes.contains_key(pair)) {
        let start = &entry(NAME).table().variables()[pair.1].start;
        assert!(matches!(start, Start::Enumeration { .. }) && kind == "dependent", "{pair:?}");
    }
    for ((unknown, known), seen) in slopes {
        let (pair, kind) = (
            format!("{} along {}", name(*unknown), name(*known)),
            declared.get(&(*unknown, *known)).map(String::as_str),
        );
        let moves = seen.iter().any(|(_, slope)| *slope != 0.0);
        assert_eq!(moves, kind.is_some(), "{pair}: moves or is declared, not both");
        let first = seen[0].1;
        match kind {
            Some("constant") => assert!(seen.iter().all(|(_, s)| *s == first), "{pair}"),
            Some("fixed") => {
                let with: BTreeMap<u64, f64> = seen.iter().copied().collect();
                assert!(seen.iter().all(|(set, slope)| with[set] == *slope), "{pair}");
                assert!(seen.iter().any(|(_, s)| *s != first), "{pair} is constant");
            }
            other => assert!(matches!(other, None | Some("dependent")), "{pair}: {other:?}"),
        }
    }
}

#[test]
fn derivatives_and_outputs_depend_on_what_they_are_said_to() {
    let knowns = variables(&[Group::Input, Group::State, Group::Time]);
    let unknowns = variables(&[Group::Output, Group::Derivative]);
    let mut slopes = Slopes::new();
    for set in 0..SETS {
        let mut random = Random(set);
        let mut vehicle = starting(&mut random);
        assert_eq!(vehicle.exit_initialization_mode(), Status::Ok);
        assert_eq!(vehicle.enter_continuous_time_mode(), Status::Ok);
        for _ in 0..POINTS {
            command(&mut vehicle, &mut random);
            let states = variables(&[Group::State]);
            let x: Vec<f64> = states.iter().map(|(_, state)| near(state, &mut random)).collect();
            assert_eq!(vehicle.set_continuous_states(&x), Status::Ok);
            see(&mut vehicle, &unknowns, &knowns, set, &mut slopes);
        }
    }
    let mut declared = declared::list(NAME, "Outputs");
    declared.extend(declared::list(NAME, "Derivatives"));
    check(&declared, &slopes);
}

#[test]
fn initial_values_depend_on_what_they_are_said_to() {
    let knowns = variables(&[Group::Parameter, Group::Input, Group::Time]);
    let unknowns = variables(&[Group::Output, Group::State, Group::Derivative]);
    let mut slopes = Slopes::new();
    for set in 0..SETS {
        let mut random = Random(500 + set);
        let mut vehicle = starting(&mut random);
        command(&mut vehicle, &mut random);
        see(&mut vehicle, &unknowns, &knowns, set, &mut slopes);
    }
    check(&declared::list(NAME, "InitialUnknowns"), &slopes);
}
