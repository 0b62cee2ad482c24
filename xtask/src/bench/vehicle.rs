//! One RK4 step of the vehicle: in Rust, in C of the same mathematics, and through the FMU.

use super::{Row, timer};
use crate::{package, paths, process};
use anyhow::{Context, Result, ensure};
use cosim::fmi::{Fmu, Instance, Logging};
use cosim::time::Time;
use rexrov::vehicle::{Inputs, Parameters, State, Vehicle};
use std::{
    hint::black_box,
    io::Write,
    path::PathBuf,
    process::{Command, Stdio},
};

const CALLS: u32 = 200_000;
const STEP_S: f64 = 0.01;

pub(super) fn measure() -> Result<Vec<Row>> {
    let rust = plain_rust()?;
    let c = plain_c()?;
    let (fmu, with_outputs) = (through_fmu()?, plain_rust_with_outputs()?);
    let row = |what: &str, value: String, goal| Row { what: what.into(), value, goal };
    Ok(vec![
        row("RexROV step in C -O3", format!("{c:.0} ns"), ""),
        row("RexROV step in Rust", format!("{rust:.0} ns"), ""),
        row("  Rust over C", format!("{:.2}", rust / c), "at most 1.3"),
        row("RexROV step and outputs in Rust", format!("{with_outputs:.0} ns"), ""),
        row("RexROV doStep through the FMU", format!("{:.0} ns", fmu.step), ""),
        row("  doStep over Rust", format!("{:.2}", fmu.step / with_outputs), "at most 1.3"),
        row("RexROV set + doStep + get through the FMU", format!("{:.0} ns", fmu.cycle), ""),
        row("  all three over Rust", format!("{:.2}", fmu.cycle / with_outputs), "at most 1.15"),
    ])
}

/// The vehicle in motion, all thrusters at work, in a current.
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

fn plain_rust() -> Result<f64> {
    let vehicle = Vehicle::new(&Parameters::default())?;
    let (mut state, inputs) = setting();
    Ok(timer::nanoseconds(CALLS, || vehicle.step(&mut state, black_box(&inputs), STEP_S)))
}

fn plain_rust_with_outputs() -> Result<f64> {
    let vehicle = Vehicle::new(&Parameters::default())?;
    let (mut state, inputs) = setting();
    Ok(timer::nanoseconds(CALLS, || {
        vehicle.step(&mut state, black_box(&inputs), STEP_S);
        black_box(vehicle.outputs(&state, &inputs));
    }))
}

/// What a master does at every step: eight forces set, one step, the pose read. And the step alone.
struct FmuTimes {
    cycle: f64,
    step: f64,
}

fn through_fmu() -> Result<FmuTimes> {
    package::run()?;
    let fmu = Fmu::open(&paths::fmus().join("RexROV.fmu"))?;
    let reference = |name: &str| -> Result<u32> {
        let variable = fmu.description().variables.iter().find(|v| v.name == name);
        Ok(variable.with_context(|| format!("RexROV has no {name}"))?.value_reference)
    };
    let (_, inputs) = setting();
    let forces =
        (0..8).map(|i| reference(&format!("thruster[{i}].force"))).collect::<Result<Vec<_>>>()?;
    let motion = ["x", "y", "z", "roll", "pitch", "yaw"].map(|axis| format!("pose.{axis}"));
    let motion = motion.iter().map(|name| reference(name)).collect::<Result<Vec<_>>>()?;
    let mut instance = Instance::new(fmu.clone(), "bench", &Logging::default())?;
    let (zero, step) = (Time::default(), Time::from_seconds(STEP_S, "step")?);
    instance.enter_initialization(zero, Time::from_seconds(1e6, "stop time")?)?;
    instance.exit_initialization()?;
    let mut now = zero;
    let mut pose = [0.0; 6];
    let mut outcome = Ok(());
    let mut timed = |whole: bool| {
        timer::nanoseconds(CALLS, || {
            let set = match whole {
                true => instance.set_real(&forces, black_box(&inputs.thruster_force)),
                false => Ok(()),
            };
            let stepped = set.and_then(|()| instance.do_step(now, step));
            let cycle = match whole {
                true => stepped.and_then(|()| instance.get_real(&motion, &mut pose)),
                false => stepped,
            };
            if outcome.is_ok() {
                outcome = cycle;
            }
            now = now + step;
            black_box(&pose);
        })
    };
    let times = FmuTimes { cycle: timed(true), step: timed(false) };
    outcome?;
    Ok(times)
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

/// What the C program reads: parameters, state, inputs, step size, number of steps.
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
