//! `rexrov-smooth`: estimates every instant of a recorded mission from the whole recording.
//!
//! The log has the columns that a navigation FMU has as inputs, and `time`; parameters have the
//! names that the FMU gives them. The output is the smoothed estimate at multiples of the filter's
//! interval, under the names of the FMU's outputs.

mod log;
mod names;
mod parameters;

use anyhow::{Context, Result, bail};
use clap::Parser;
use fmu_kit::{Declarations, Field, Variables, Writer};
use rexrov::axes;
use rexrov::estimation::{Kind, Recording, Smoothed, Smoothing};
use rexrov_fmu::nav_constant_acceleration::NavConstantAcceleration;
use rexrov_fmu::nav_dynamic::NavDynamic;
use rexrov_fmu::nav_inertial::NavInertial;
use rexrov_fmu::nav_model_aided::NavModelAided;
use rexrov_fmu::navigation_estimate::{COVARIANCE, Outputs};
use rexrov_fmu::navigator::Navigator;
use std::fs::File;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Smooths a recorded mission: estimates each instant from all measurements, earlier and later.
#[derive(Debug, Parser)]
#[command(version)]
struct Options {
    /// CSV file with the columns `time` and those of the filter's inputs; absent sensors have none,
    /// rows without a new sample may leave a sensor's cells empty
    log: PathBuf,
    /// Navigation filter, as its FMU is called
    #[arg(long, value_name = "NAME", default_value = NavModelAided::INFO.name)]
    filter: String,
    /// JSON file with parameters by their names in the FMU: {"dvl_sigma": 0.02}
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// Take the columns `NAME.input` of a recorded system and leave all others alone
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    /// Where to write the smoothed estimate [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Do not say how many samples there are of each sensor
    #[arg(short, long)]
    quiet: bool,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<()> {
    const NAMES: [&str; 4] = [
        NavConstantAcceleration::INFO.name,
        NavDynamic::INFO.name,
        NavInertial::INFO.name,
        NavModelAided::INFO.name,
    ];
    let path = match &options.filter {
        name if name == NAMES[0] => smoothed::<NavConstantAcceleration>(options),
        name if name == NAMES[1] => smoothed::<NavDynamic>(options),
        name if name == NAMES[2] => smoothed::<NavInertial>(options),
        name if name == NAMES[3] => smoothed::<NavModelAided>(options),
        name => bail!("there is no filter '{name}'; {}", names::hint(name, &NAMES)),
    }?;
    match &options.output {
        Some(file) => {
            let shown = || file.display().to_string();
            write(&path, io::BufWriter::new(File::create(file).with_context(shown)?))
                .with_context(shown)
        }
        None => write(&path, io::stdout().lock()),
    }
}

fn smoothed<N: Navigator<Filter: Smoothing>>(options: &Options) -> Result<Vec<Smoothed>> {
    let parameters = parameters::read::<N>(options.parameters.as_deref())?;
    let filter = N::filter(&parameters)?;
    let mut recording = filter.recording();
    log::read(&options.log, options.component.as_deref(), &mut recording)?;
    if !options.quiet {
        report(&recording);
    }
    Ok(filter.smooth(&recording))
}

/// Prints how many samples of each sensor there are.
fn report(recording: &Recording) {
    for (kind, name) in [
        (Kind::Imu, "imu"),
        (Kind::Thrust, "propulsion"),
        (Kind::Ahrs, "ahrs"),
        (Kind::Depth, "pressure"),
        (Kind::Dvl, "dvl"),
        (Kind::Fix, "fix"),
    ] {
        match recording.count(kind) {
            (0, 0) => {}
            (fit, 0) => eprintln!("{name}: {fit} samples"),
            (fit, unfit) => eprintln!("{name}: {fit} samples, and {unfit} not fit to be used"),
        }
    }
}

/// The output for an instant, with the names of the FMUs.
#[derive(Clone, Copy, Debug, Default, Variables)]
struct Columns {
    /// Pose
    #[var(elements = axes::POSE)]
    pose: [f64; 6],
    /// Velocity over ground, body frame
    #[var(elements = axes::VELOCITY)]
    velocity: [f64; 6],
    /// Current
    #[var(elements = axes::HORIZONTAL_VELOCITY)]
    current: [f64; 2],
    /// Standard deviation of the pose
    #[var(elements = axes::POSE)]
    sigma: [f64; 6],
    /// Standard deviation of the velocity
    #[var(elements = axes::LINEAR_VELOCITY)]
    velocity_sigma: [f64; 3],
    /// Covariance of the pose
    #[var(elements = COVARIANCE)]
    covariance: [f64; 15],
}

impl From<Outputs> for Columns {
    fn from(y: Outputs) -> Self {
        let Outputs { pose, velocity, current, sigma, velocity_sigma, covariance, .. } = y;
        Self { pose, velocity, current, sigma, velocity_sigma, covariance }
    }
}

fn write(path: &[Smoothed], to: impl Write) -> Result<()> {
    let mut writer = csv::Writer::from_writer(to);
    let mut columns = Declarations::new();
    Columns::default().declare(&Field::default(), &mut columns);
    let names = columns.iter().map(|column| column.field.name.as_str());
    writer.write_record(std::iter::once("time").chain(names))?;
    let mut reals = vec![0.0; columns.len()];
    for Smoothed { time, estimate } in path {
        let values = Columns::from(Outputs::of(estimate));
        values.store(&mut Writer { reals: &mut reals, ..Writer::default() });
        let numbers = std::iter::once(time).chain(&reals);
        writer.write_record(numbers.map(f64::to_string))?;
    }
    Ok(writer.flush()?)
}
