//! One RK4 step of the vehicle: in Rust, in C of the same mathematics, and through the FMU's C
//! interface.

use super::component::Component;
use super::timer::{repeat, rounds};
use super::{Bar, Row, row};
use crate::{paths, process};
use anyhow::{Context, Result, ensure};
use rexrov::vehicle::{Inputs, Outputs, Parameters, State, Vehicle};
use std::{
    hint::black_box,
    io::Write,
    path::PathBuf,
    process::{Command, Stdio},
};

const TIMES: u32 = 500;
const STEP_S: f64 = 0.01;

pub(super) fn measure() -> Result<Vec<Row>> {
    let vehicle = Vehicle::new(&Parameters::default())?;
    let (state, inputs) = setting();
    let (mut alone, mut stepped) = (state, state);
    let (mut u, mut y) = (inputs, [0.0; 26]);
    let (fmu, driven) = (Component::stepping("RexROV")?, Component::stepping("RexROV")?);
    let (set, get) = (forces(&fmu)?, seen(&fmu)?);
    // A communication step is divided into the same number of integrator steps, on both sides.
    let parts = (STEP_S / fmu.integrator_step_s()?).ceil() as u32;
    let (mut got, mut got_driven, mut other) = ([0.0; 26], [0.0; 26], false);
    let times = rounds(
        TIMES,
        [
            &mut repeat(|| vehicle.step(&mut alone, black_box(&inputs), STEP_S)),
            &mut repeat(|| {
                u.thruster_force = *black_box(&inputs.thruster_force);
                (0..parts).for_each(|_| vehicle.step(&mut stepped, &u, STEP_S / f64::from(parts)));
                y = read(&vehicle.outputs(&stepped, &u));
                black_box(&mut y);
            }),
            &mut repeat(|| fmu.step(STEP_S)),
            &mut repeat(|| {
                fmu.set(&set, black_box(&inputs.thruster_force));
                fmu.step(STEP_S);
                fmu.get(&get, &mut got);
                black_box(&mut got);
            }),
            &mut repeat(|| {
                other = !other;
                let by = f64::from(u8::from(other));
                driven.set(&set, black_box(&inputs.thruster_force.map(|force| force + by)));
                driven.step(STEP_S);
                driven.get(&get, &mut got_driven);
                black_box(&mut got_driven);
            }),
        ],
    );
    fmu.check()?;
    driven.check()?;
    let c = plain_c()?;
    let bar = || Bar::AtMost(1.15);
    Ok(vec![
        row("RexROV step in C -O3", c, "ns", Bar::None),
        row("RexROV step in Rust", times.ns(0), "ns", Bar::None),
        row("  Rust over C", times.ns(0) / c, "", Bar::AtMost(1.3)),
        row(format!("RexROV {parts} steps and outputs in Rust"), times.ns(1), "ns", Bar::None),
        row("RexROV doStep of 10 ms through the FMU", times.ns(2), "ns", Bar::None),
        row("RexROV set 8 + doStep + get 26 through the FMU", times.ns(3), "ns", Bar::None),
        row("  all three over Rust, commands as before", times.ratio(3, 1), "", bar()),
        row("  all three over Rust, new commands every step", times.ratio(4, 1), "", bar()),
    ])
}

/// The outputs that the paper's loop reads: those connected to sensors, filter and controller.
fn read(y: &Outputs) -> [f64; 26] {
    let mut seen = [0.0; 26];
    seen[..3].copy_from_slice(&y.p_ned);
    seen[3..6].copy_from_slice(&y.euler);
    seen[6..12].copy_from_slice(&y.nu);
    seen[12..15].copy_from_slice(&y.nu_dot[3..]);
    seen[15..18].copy_from_slice(&y.specific_force);
    seen[18..].copy_from_slice(&y.thrust);
    seen
}

/// The same by name, in that order.
fn seen(fmu: &Component) -> Result<Vec<u32>> {
    let groups = [
        ("pose", "x y z roll pitch yaw"),
        ("velocity", "u v w p q r"),
        ("acceleration", "p q r"),
        ("specific_force", "x y z"),
    ];
    let members = groups.iter().flat_map(|(group, members)| {
        members.split(' ').map(move |member| format!("{group}.{member}"))
    });
    let thrusts = (0..8).map(|i| format!("thruster[{i}].thrust"));
    members.chain(thrusts).map(|name| fmu.reference(&name)).collect()
}

fn forces(fmu: &Component) -> Result<Vec<u32>> {
    (0..8).map(|i| fmu.reference(&format!("thruster[{i}].force"))).collect()
}

/// The vehicle in motion, with all thrusters running, in a current.
fn setting() -> (State, Inputs) {
    let mut state = State::at_rest([0.0, 0.0, 20.0], [0.05, -0.03, 0.4]);
    state.nu = [0.3, 0.02, 0.01, 0.01, -0.02, 0.1];
    let inputs = Inputs {
        thruster_force: [50.0, -20.0, 30.0, 10.0, 100.0, 80.0, -90.0, -60.0],
        wrench: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        current_ned: [0.1, -0.2, 0.03],
        ..Inputs::default()
    };
    (state, inputs)
}

/// Compiles `bench/rexrov.c` and lets it step the same vehicle, from the same numbers.
fn plain_c() -> Result<f64> {
    let program = compile()?;
    let mut child = Command::new(&program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .with_context(|| program.display().to_string())?;
    let bytes: Vec<u8> = numbers()?.iter().flat_map(|number| number.to_le_bytes()).collect();
    child.stdin.take().context("no pipe to the C program")?.write_all(&bytes)?;
    let output = child.wait_with_output()?;
    ensure!(output.status.success(), "{} failed", program.display());
    let text = String::from_utf8(output.stdout)?;
    let first = text.lines().next().context("the C program printed nothing")?;
    Ok(first.parse()?)
}

fn compile() -> Result<PathBuf> {
    let program = paths::target().join("bench-rexrov");
    let source = paths::root().join("xtask/bench/rexrov.c");
    process::run(
        Command::new("cc")
            .args(["-O3", "-DREXROV_MAIN", "-o"])
            .args([&program, &source])
            .arg("-lm"),
    )?;
    Ok(program)
}

/// The input of the C program: parameters, state, inputs, step size, number of steps.
fn numbers() -> Result<Vec<f64>> {
    let p = Parameters::default();
    let thrusters = &p.propulsion;
    let (state, inputs) = setting();
    let mass = p.mass_matrix();
    let inverse = nalgebra::Matrix6::from_fn(|i, j| mass[i][j])
        .cholesky()
        .context("the mass matrix is not positive definite")?
        .inverse();
    let mut numbers = vec![
        p.mass,
        p.weight(),
        p.buoyancy_force(),
        1.0 / thrusters.rotor_time_constant,
        thrusters.thrust_gain,
        thrusters.thrust_limit,
    ];
    numbers.extend(p.centre_of_buoyancy);
    numbers.extend(p.inertia.matrix().concat());
    numbers.extend(p.symmetric_added_mass().concat());
    numbers.extend(inverse.iter());
    numbers.extend(p.linear_damping);
    numbers.extend(p.quadratic_damping);
    for thruster in thrusters.thrusters {
        numbers.extend(thruster.unit_wrench());
    }
    numbers.extend(state.p_ned);
    numbers.extend(state.quaternion);
    numbers.extend(state.nu);
    numbers.extend(state.rotor_speed);
    numbers.extend(inputs.thruster_force);
    numbers.extend(inputs.wrench);
    numbers.extend(inputs.current_ned);
    numbers.extend([STEP_S, 3e6]);
    Ok(numbers)
}
