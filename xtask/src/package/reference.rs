//! The reference run of a component: its default experiment with the inputs of [`stimulus`], by
//! co-simulation. The FMU contains inputs and result as the Reference FMUs of the Modelica
//! Association do, so that users can check whether it works as it should.

use super::stimulus;
use anyhow::{Result, bail, ensure};
use fmu_kit::{
    Resources,
    kernel::{Category, Entry, Group, Instance, Interface, Sink, Status},
};
use std::sync::{Arc, Mutex};

/// Communication step of the run, s: short enough for a smooth plot, long enough for small files.
pub(crate) const STEP_S: f64 = 0.1;

/// Inputs and result.
pub(crate) struct Run {
    pub(crate) inputs: Recording,
    pub(crate) outputs: Recording,
}

/// Some variables over time.
pub(crate) struct Recording {
    pub(crate) names: Vec<String>,
    /// Time, then one value for each name.
    pub(crate) rows: Vec<Vec<f64>>,
}

/// Runs the default experiment. A row of the result has the outputs at its time, reached with the
/// inputs of the previous row, as recorded by masters that do not consider feed-through.
pub(crate) fn run(component: &Entry) -> Result<Run> {
    let log = Log::default();
    let name = component.info().name;
    let stop = component.info().stop_time_s;
    let started = component.instantiate(
        Interface::CoSimulation,
        Resources::none(),
        Box::new(log.clone()),
        false,
    );
    let mut instance = started.map_err(anyhow::Error::msg)?;
    let table = component.table();
    let driven = table.group(Group::Input).map(|(_, input)| input);
    let driven: Vec<_> = driven.filter(|v| stimulus::value(&v.name, 0.0).is_some()).collect();
    let outputs: Vec<_> = table.group(Group::Output).map(|(_, output)| output).collect();
    let references = |list: &[&fmu_kit::kernel::Variable]| -> Vec<u32> {
        list.iter().map(|variable| variable.reference).collect()
    };
    let (into, from) = (references(&driven), references(&outputs));
    let names = |list: &[&fmu_kit::kernel::Variable]| -> Vec<String> {
        list.iter().map(|variable| variable.name.clone()).collect()
    };
    let mut run = Run {
        inputs: Recording { names: names(&driven), rows: Vec::new() },
        outputs: Recording { names: names(&outputs), rows: Vec::new() },
    };

    log.ok(name, instance.setup_experiment(None, 0.0, Some(stop)))?;
    log.ok(name, instance.enter_initialization_mode())?;
    let steps = (stop / STEP_S).round() as u32;
    for step in 0..=steps {
        let t = f64::from(step) * STEP_S;
        let values: Vec<f64> =
            driven.iter().filter_map(|input| stimulus::value(&input.name, t)).collect();
        match step {
            0 => {
                log.ok(name, instance.set_real(&into, &values))?;
                log.ok(name, instance.exit_initialization_mode())?;
            }
            _ => {
                let before = f64::from(step - 1) * STEP_S;
                log.ok(name, instance.do_step(before, t - before))?;
            }
        }
        run.outputs.rows.push(row(&log, name, &mut instance, t, &from)?);
        log.ok(name, instance.set_real(&into, &values))?;
        run.inputs.rows.push([vec![t], values].concat());
    }
    Ok(run)
}

fn row(log: &Log, name: &str, from: &mut Instance, t: f64, references: &[u32]) -> Result<Vec<f64>> {
    let mut values = vec![0.0; references.len()];
    log.ok(name, from.get_real(references, &mut values))?;
    ensure!(values.iter().all(|value| value.is_finite()), "{name} is not finite at {t} s");
    values.insert(0, t);
    Ok(values)
}

impl Recording {
    /// As FMPy and fmusim read it: a header, commas, the shortest numbers that read back to the
    /// same bits. `None` if there is nothing but time.
    pub(crate) fn csv(&self) -> Option<String> {
        if self.names.is_empty() {
            return None;
        }
        let mut text = format!("time,{}\n", self.names.join(","));
        for row in &self.rows {
            let numbers: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
            text.push_str(&numbers.join(","));
            text.push('\n');
        }
        Some(text)
    }

    /// The values of one variable over time.
    pub(crate) fn course(&self, name: &str) -> Vec<(f64, f64)> {
        let Some(index) = self.names.iter().position(|known| known == name) else {
            return Vec::new();
        };
        self.rows.iter().map(|row| (row[0], row[index + 1])).collect()
    }
}

impl Run {
    /// The manifest of the files according to the layered standard FMI-LS-REF, which prescribes its
    /// texts and roles.
    pub(crate) fn manifest(&self, name: &str) -> String {
        let related = |recording: &Recording, suffix: &str, role: &str, what: &str| {
            if recording.names.is_empty() {
                return String::new();
            }
            format!(
                "    <Related type=\"text/csv\" source=\"{name}_{suffix}.csv\" role=\"{role}\" \
                 description=\"{what}\"/>\n"
            )
        };
        let result = format!(
            "Outputs of the default experiment with these inputs, co-simulation in steps of \
             {STEP_S} s"
        );
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiReferences\n    \
             xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\"\n    \
             fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\"\n    \
             fmi-ls:fmi-ls-version=\"1.0.0-alpha.1\"\n    \
             fmi-ls:fmi-ls-description=\"Layered Standard providing information on related \
             files included in an FMU.\">\n{}{}</fmiReferences>\n",
            related(&self.inputs, "in", "testcase", "Inputs, constant during each step"),
            related(&self.outputs, "out", "result", &result),
        )
    }
}

/// The component's complaint.
#[derive(Clone, Default)]
struct Log(Arc<Mutex<String>>);

impl Sink for Log {
    fn write(&self, _: Status, _: Category, text: &str) {
        if let Ok(mut last) = self.0.lock() {
            text.clone_into(&mut last);
        }
    }
}

impl Log {
    fn ok(&self, name: &str, status: Status) -> Result<()> {
        if status == Status::Ok {
            return Ok(());
        }
        let reason = self.0.lock().map(|text| text.clone()).unwrap_or_default();
        bail!("the reference run of {name} fails: {reason}")
    }
}
