//! `cosim validate`: all problems of an FMU or a system at once.

use std::path::{Path, PathBuf};

use clap::Args;
use cosim::fmi::{Fmu, InterfaceType};
#[cfg(feature = "distributed")]
use cosim::signature;
use cosim::{Error, Overrides, Result, System};
use serde_json::{Value, json};

use super::output::print;
use super::{Format, interrupt, messages, problems};

/// Check an FMU or a system without running it, and report all problems at once
#[derive(Args)]
pub(crate) struct Validate {
    /// A .fmu, .ssd, .ssp or OspSystemStructure.xml file, or the folder of the latter
    file: PathBuf,
    /// First verify the signature FILE.sig with this public key; without a valid one, nothing in
    /// the file is loaded
    #[cfg(feature = "distributed")]
    #[arg(long, value_name = "KEY.pub")]
    verify_signature: Option<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// The description of a valid file.
#[derive(Default)]
struct Findings {
    warnings: Vec<String>,
    notes: Vec<String>,
}

impl Validate {
    #[cfg(feature = "distributed")]
    fn signed(&self) -> Result<()> {
        let key = self.verify_signature.as_deref();
        key.map_or(Ok(()), |key| signature::verify(&self.file, key))
    }

    #[cfg(not(feature = "distributed"))]
    fn signed(&self) -> Result<()> {
        Ok(())
    }

    pub(crate) fn run(self) -> Result<()> {
        interrupt::watch();
        let result = self.signed().and_then(|()| check(&self.file));
        if self.format == Format::Json {
            print(&json(&self.file, &result).to_string())?;
        }
        let findings = result?;
        if self.format == Format::Text {
            messages::report_some(&findings.warnings, messages::warning);
            messages::report_some(&findings.notes, messages::note);
            print(&format!("{} is valid", self.file.display()))?;
        }
        Ok(())
    }
}

fn check(file: &Path) -> Result<Findings> {
    let mut found = Findings::default();
    if !System::is_system(file) {
        let fmu = Fmu::open(file)?;
        fmu.choose(None)?;
        for kind in [InterfaceType::CoSimulation, InterfaceType::ModelExchange] {
            if fmu.description().interface(kind).is_some() {
                fmu.check(kind)?;
                let name = &fmu.description().model_name;
                if found.on_this_machine(&fmu, kind, name) {
                    fmu.load(kind)?;
                }
            }
        }
        found.warnings.clone_from(&fmu.description().warnings);
        return Ok(found);
    }
    // A tool is needed to run it; without one the file is as valid.
    let system = System::load(file, &Overrides::new().execution_tools(true))?;
    found.warnings = system.warnings().to_vec();
    found.notes = [system.notes(), system.sampled_loops()].concat();
    found.notes.extend(system.unconnected_inputs().map(|port| {
        format!("the input {} is not connected: it keeps its start value", system.port_name(port))
    }));
    for component in system.components() {
        if let Some(fmu) = component.fmu() {
            found.on_this_machine(fmu, component.interface, &component.name);
        }
    }
    if let Err(missing) = system.ready() {
        missing.problems().for_each(|error| found.needs(error, ""));
    }
    Ok(found)
}

impl Findings {
    fn needs(&mut self, missing: &Error, what: &str) {
        let remedy = missing.remedy().unwrap_or_default();
        let note = format!("to run it: {what}{}: {remedy}", missing.what());
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Notes what an FMU needs to run on this machine; returns whether it has a binary for it.
    fn on_this_machine(&mut self, fmu: &Fmu, kind: InterfaceType, name: &str) -> bool {
        let (binary, tool) =
            (fmu.is_for_this_machine(kind), System::needs_no_tool(fmu, kind, name));
        let file = format!("{}: ", fmu.path().display());
        for missing in [&binary, &tool].into_iter().filter_map(|found| found.as_ref().err()) {
            self.needs(missing, &file);
        }
        binary.is_ok()
    }
}

fn json(file: &Path, result: &Result<Findings>) -> Value {
    let (error, empty) = (result.as_ref().err(), Findings::default());
    let findings = result.as_ref().unwrap_or(&empty);
    json!({
        "file": file.display().to_string(),
        "valid": error.is_none(),
        "problems": error.map(problems::list).unwrap_or_default(),
        "warnings": findings.warnings,
        "notes": findings.notes,
    })
}
