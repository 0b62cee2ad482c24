//! OSP: `OspSystemStructure.xml` of the Open Simulation Platform, schema 0.1.
//!
//! Simulators, initial values, functions and connections of variables, signals and groups of them.
//! A linear transformation becomes the conversion of its connections; a sum remains a component.
//! The only algorithm with a counterpart is `fixedStep`, which is Jacobi. `LogConfig.xml` beside
//! the file defines what is recorded.

mod connections;
mod functions;
mod groups;
mod log;
mod simulators;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::gathered::{Gathered, place, wrong};
use super::source::Base;
use crate::system::Algorithm;
use crate::system::raw::{Place, RawComponent, RawConnection, RawMaster, RawParameter, RawSystem};
use cosim_base::error::{Code, Error, Result};
use cosim_base::xml::Element;
use functions::Linear;
use groups::Groups;

pub(in crate::system) use log::LOG_FILE;

/// Namespace of system structures.
pub(in crate::system) const NAMESPACE: &str =
    "http://opensimulationplatform.com/MSMI/OSPSystemStructure";

/// Reads a structure whose root element is `root`.
pub(super) fn read(
    root: &Element,
    file: &Path,
    base: Base,
    gathered: Gathered,
) -> Result<RawSystem> {
    let mut reader = Reader {
        file: file.into(),
        base,
        gathered,
        components: Vec::new(),
        by_name: HashMap::new(),
        connections: Vec::new(),
        parameters: Vec::new(),
        groups: Groups::default(),
        linear: Vec::new(),
        linear_by_name: HashMap::new(),
    };
    reader.check_root(root)?;
    // 0 means none, here as in a simulator.
    let step = reader.number(root, "BaseStepSize").filter(|step| *step != 0.0);
    let mut master = RawMaster { step, ..Default::default() };
    let (start, stop) = (reader.number(root, "StartTime"), reader.number(root, "EndTime"));
    reader.algorithm(root, &mut master);
    reader.simulators(root, master.step);
    reader.functions(root);
    reader.connections(root);
    let experiment = root.child("EndTime").or(root.child("StartTime"));
    let experiment = experiment.map(|element| reader.place(element));
    let recorded = reader.log_config(&mut master);
    let name = file.parent().and_then(|p| p.file_name()).filter(|_| reader.base.folder.is_some());
    Ok(RawSystem {
        ports: Vec::new(),
        file: file.to_owned(),
        name: name.map_or("system".to_owned(), |n| n.to_string_lossy().into_owned()),
        components: reader.components,
        connections: reader.connections,
        parameters: reader.parameters,
        experiment,
        start,
        stop,
        master,
        recorded,
        warnings: reader.gathered.warnings,
        notes: reader.gathered.notes,
        problems: reader.gathered.problems,
        _unpacked: reader.gathered.packages.into_values().collect(),
        fmus: reader.gathered.fmus,
    })
}

struct Reader {
    file: Arc<Path>,
    base: Base,
    gathered: Gathered,
    components: Vec<RawComponent>,
    /// Their positions; of two with one name, the first.
    by_name: HashMap<String, usize>,
    connections: Vec<RawConnection>,
    parameters: Vec<RawParameter>,
    /// Variable groups of the simulators.
    groups: Groups,
    /// Linear transformations, until their connections are known.
    linear: Vec<Linear>,
    linear_by_name: HashMap<String, usize>,
}

impl Reader {
    fn check_root(&mut self, root: &Element) -> Result<()> {
        if root.namespace != NAMESPACE {
            return Err(self
                .wrong(root, format!("the namespace of <{}> is '{}'", root.name, root.namespace))
                .help(format!("write xmlns=\"{NAMESPACE}\"")));
        }
        let version = root.require("version", &self.file, Code::Ssd)?;
        if !version.starts_with("0.") {
            return Err(self
                .wrong(root, format!("the version of the structure is '{version}'"))
                .why("0.1 is supported"));
        }
        self.known(
            root,
            &[
                "StartTime",
                "EndTime",
                "BaseStepSize",
                "Algorithm",
                "Simulators",
                "Functions",
                "Connections",
                "EccoConfiguration",
            ],
            &["version"],
        );
        Ok(())
    }

    fn algorithm(&mut self, root: &Element, master: &mut RawMaster) {
        // According to the schema, fixedStep is the default.
        master.algorithm = Some(Algorithm::Jacobi);
        let Some(element) = root.child("Algorithm") else {
            return;
        };
        match element.text.trim() {
            text if text.eq_ignore_ascii_case("fixedStep") => (),
            text if text.eq_ignore_ascii_case("ecco") => self.gathered.warnings.push(format!(
                "{}: the algorithm 'ecco' is not supported: the system is run by jacobi with fixed \
                 steps (choose another with --algorithm)",
                self.place(element)
            )),
            other => {
                let problem = self
                    .wrong(element, format!("the algorithm '{other}' is unknown"))
                    .help("write fixedStep");
                self.gathered.problems.push(problem);
            }
        }
    }

    /// The number in the text of a child.
    fn number(&mut self, root: &Element, name: &str) -> Option<f64> {
        let element = root.child(name)?;
        match element.text.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Some(number),
            _ => {
                let text = element.text.trim();
                let problem = self.wrong(element, format!("<{name}> is '{text}', not a number"));
                self.gathered.problems.push(problem);
                None
            }
        }
    }

    fn add(&mut self, component: RawComponent) {
        self.by_name.entry(component.name.clone()).or_insert(self.components.len());
        self.components.push(component);
    }

    /// A component by name.
    fn component(&self, name: &str) -> Option<&RawComponent> {
        self.by_name.get(name).map(|&position| &self.components[position])
    }

    /// Refuses the system if so many more bytes are too many.
    fn spend(&mut self, bytes: usize, element: &Element) -> Result<()> {
        let place = self.place(element);
        self.gathered.spend(bytes, &place)
    }

    /// The same for what is made of a file that is named there, or belongs to it.
    fn spend_on(&mut self, file: &Path, element: &Element) -> Result<()> {
        let place = self.place(element);
        self.gathered.spend_on(file, &place)
    }

    fn known(&mut self, element: &Element, children: &[&str], attributes: &[&str]) {
        self.gathered.known(&self.file, element, children, attributes);
    }

    fn place(&self, element: &Element) -> Place {
        place(&self.file, element)
    }

    fn wrong(&self, element: &Element, what: impl Into<String>) -> Error {
        wrong(&self.file, element, what)
    }
}
