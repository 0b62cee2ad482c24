//! The packaged FMUs, and the paper's loop exported as one, checked by independent tools in Rust:
//! the validator and the importer of `fmi-rs`.
//!
//! Results go to `target/judges/fmi-rs-*.csv`, from where `cargo xtask judge` takes them into its
//! table.

#![cfg(test)]
#![allow(clippy::arc_with_non_send_sync, reason = "its simulators want an Arc of their recorder")]

mod runge_kutta;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::model_description::fmi2::{Causality, ModelDescription};
use fmi_rs::sim::fmi2::recorder::Recorder;
use fmi_rs::sim::fmi2::{SimulationSettings, Trajectories, VariableValue, cs, me};
use runge_kutta::RungeKutta;

/// A power of two, so that instants are the same numbers wherever a run begins; no longer than the
/// vehicle's internal steps, so that both make the same steps.
const STEP: f64 = 1.0 / 256.0;
const STOP: f64 = 4.0;

type Outcome = Result<(), String>;

fn target() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target")
}

/// The packaged components.
fn components() -> Vec<PathBuf> {
    let folder = fs::read_dir(target().join("fmus")).expect("`cargo xtask package` writes it");
    let files = folder.map(|entry| entry.unwrap().path());
    let mut fmus: Vec<_> = files.filter(|f| f.extension().is_some_and(|e| e == "fmu")).collect();
    fmus.sort();
    assert!(!fmus.is_empty(), "there are no FMUs: run `cargo xtask package`");
    fmus
}

/// The FMUs for co-simulation: the components and the loop that the task runner exports.
fn all() -> Vec<PathBuf> {
    let exported = target().join("judges/Loop.fmu");
    components().into_iter().chain([exported]).collect()
}

/// Examines every FMU, writes the results and fails with all complaints.
fn judge(check: &str, files: &[PathBuf], examine: impl Fn(&Fmu) -> Outcome) {
    let mut rows = String::new();
    let mut complaints = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap_or_default().display();
        let outcome = Fmu::open(file).and_then(|fmu| examine(&fmu));
        let verdict = if outcome.is_ok() { "passed" } else { "failed" };
        rows += &format!("fmi-rs,{check},{name},{verdict}\n");
        complaints.extend(outcome.err().map(|why| format!("{name}: {why}")));
    }
    let folder = target().join("judges");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(format!("fmi-rs-{}.csv", check.replace(' ', "-"))), rows).unwrap();
    assert!(complaints.is_empty(), "{check}: {complaints:#?}");
}

struct Fmu {
    builder: FMU2Builder,
    description: Arc<ModelDescription>,
}

impl Fmu {
    fn open(file: &Path) -> Result<Self, String> {
        assert!(file.exists(), "{} is missing: run `cargo xtask judge`", file.display());
        let builder = FMU2Builder::new(&file).map_err(|e| e.to_string())?;
        let text = builder.unzipdir.path().join("modelDescription.xml");
        let description = ModelDescription::from_path(&text).map_err(|e| e.to_string())?;
        Ok(Self { builder, description: Arc::new(description) })
    }

    fn settings(&self, start: f64, stop: f64) -> SimulationSettings {
        let moving = self.description.modelName == "RexROV";
        let thrust = ("thruster[4].force".to_owned(), "100".to_owned());
        SimulationSettings {
            unzipdir: self.builder.unzipdir.path().to_owned(),
            model_description: self.description.clone(),
            start_time: start,
            stop_time: stop,
            logging_on: true,
            set_stop_time: true,
            output_interval: STEP,
            log_time_scale: false,
            tolerance: 1e-12,
            set_tolerance: false,
            start_values: if moving { vec![thrust] } else { Vec::new() },
            log_fmi_calls: false,
            input_file: None,
            early_return_allowed: false,
            event_mode_used: false,
            log_file: Some(self.builder.unzipdir.path().join("log.txt")),
            initial_fmu_state_file: None,
            final_fmu_state_file: None,
        }
    }

    /// Records every variable of any type during a run.
    fn record(&self, run: impl FnOnce(Arc<Recorder>) -> Outcome) -> Result<Trajectories, String> {
        let all = (0..self.description.modelVariables.len()).collect();
        let recorder = Arc::new(Recorder::new(Trajectories::new(self.description.clone(), all)));
        run(recorder.clone())?;
        let recorded = Arc::try_unwrap(recorder).map_err(|_| "recorder in use")?;
        let trajectories = recorded.into_trajectories();
        trajectories.validate()?;
        self.nothing_to_complain_of()?;
        let values = trajectories.rows.iter().flatten();
        match values.filter_map(VariableValue::to_f64).find(|value| !value.is_finite()) {
            Some(value) => Err(format!("a variable is {value}")),
            None => Ok(trajectories),
        }
    }

    fn nothing_to_complain_of(&self) -> Outcome {
        let log = fs::read_to_string(self.builder.unzipdir.path().join("log.txt"));
        let log = log.map_err(|e| e.to_string())?;
        match log.lines().find(|line| !line.starts_with("[INFO]")) {
            Some(line) => Err(line.to_owned()),
            None => Ok(()),
        }
    }

    fn co_simulation(&self, settings: &SimulationSettings) -> Result<Trajectories, String> {
        self.record(|recorder| cs::simulate(settings, None, recorder).map_err(|e| e.to_string()))
    }

    fn model_exchange(&self, settings: &SimulationSettings) -> Result<Trajectories, String> {
        self.record(|recorder| {
            me::simulate(settings, &RungeKutta, None, recorder).map_err(|e| e.to_string())
        })
    }
}

#[test]
fn its_validator_finds_no_fault() {
    judge("validation", &all(), |fmu| {
        let problems = fmu.description.validate();
        if problems.is_empty() {
            return Ok(());
        }
        Err(problems.iter().map(|p| p.message.as_str()).collect::<Vec<_>>().join("; "))
    });
}

#[test]
fn its_co_simulation_reads_every_variable_at_every_step() {
    judge("co-simulation", &all(), |fmu| {
        let recorded = fmu.co_simulation(&fmu.settings(0.0, STOP))?;
        let rows = (STOP / STEP) as usize + 1;
        if recorded.step_count() == rows && recorded.time.last() == Some(&STOP) {
            return Ok(());
        }
        Err(format!("{} of {rows} steps", recorded.step_count()))
    });
}

#[test]
fn its_model_exchange_ends_where_its_co_simulation_does() {
    judge("model exchange", &components(), |fmu| {
        let settings = fmu.settings(0.0, STOP);
        let (cs, me) = (fmu.co_simulation(&settings)?, fmu.model_exchange(&settings)?);
        let (cs, me) = (cs.rows.last().unwrap(), me.rows.last().unwrap());
        for (variable, (cs, me)) in fmu.description.modelVariables.iter().zip(cs.iter().zip(me)) {
            if variable.causality != Causality::Output {
                continue;
            }
            let (Some(cs), Some(me)) = (cs.to_f64(), me.to_f64()) else {
                return Err(format!("{} is no number", variable.name));
            };
            if (cs - me).abs() > 1e-6 * cs.abs().max(1e-3) {
                return Err(format!("{}: {cs} and {me}", variable.name));
            }
        }
        Ok(())
    });
}

#[test]
fn a_run_goes_on_from_a_file_of_its_state() {
    judge("state in a file", &all(), |fmu| {
        let middle = STOP / 2.0;
        let file = fmu.builder.unzipdir.path().join("state");
        let whole = fmu.co_simulation(&fmu.settings(0.0, STOP))?;
        let mut first = fmu.settings(0.0, middle);
        // A state keeps the stop time of its experiment, and this one continues after it.
        first.set_stop_time = false;
        first.final_fmu_state_file = Some(file.clone());
        fmu.co_simulation(&first)?;
        let mut second = fmu.settings(middle, STOP);
        second.initial_fmu_state_file = Some(file);
        second.start_values.clear();
        let resumed = fmu.co_simulation(&second)?;
        let begin = whole.time.iter().position(|t| *t == middle).ok_or("no such instant")?;
        if whole.rows[begin..] == resumed.rows[..] {
            return Ok(());
        }
        Err("the resumed run is another one".to_owned())
    });
}
