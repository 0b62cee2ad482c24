//! SSP 1.0 and 2.0: .ssd files with the .ssv, .ssm and .ssb files and descriptions they refer to.
//!
//! Features of SSP 2.0 without a counterpart in FMI 2.0 (arrays, clocks, the sized integers) are
//! refused by name. Geometry, metadata, signatures and annotations of other tools do not affect a
//! run and are ignored.

mod annotation;
mod connection;
mod dictionary;
mod element;
mod flatten;
mod mapping;
mod parameters;

use std::path::Path;
use std::sync::Arc;

use super::gathered::{Gathered, place, wrong};
use super::source::Base;
use crate::system::raw::{Place, RawMaster, RawSystem, RawUnit};
use cosim_base::error::{Code, Error, Result};
use cosim_base::units::{self, Units};
use cosim_base::xml::Element;
use flatten::Nested;

/// The file of the system in a package.
pub(in crate::system) const SSD_FILE: &str = "SystemStructure.ssd";

/// Namespace of system descriptions.
const SSD: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";

/// Attributes of every top-level element.
const TOP: &[&str] = &[
    "name",
    "version",
    "author",
    "fileversion",
    "copyright",
    "license",
    "generationTool",
    "generationDateAndTime",
];

/// Reads a description whose root element is `root`.
pub(super) fn read(
    root: &Element,
    file: &Path,
    base: Base,
    mut gathered: Gathered,
) -> Result<RawSystem> {
    let mut nested = Nested::default();
    let mut reader = Reader {
        file: file.into(),
        base,
        units: Units::new(),
        gathered: &mut gathered,
        nested: &mut nested,
    };
    let system = reader.document(root)?;
    let mut master = RawMaster::default();
    let mut recorded = Vec::new();
    let base_step =
        reader.base_step(root, &mut master).or_else(|| reader.step_of_omsimulator(system));
    reader.master(root, &mut master, &mut recorded);
    reader.master(system, &mut master, &mut recorded);
    let (start, stop) = reader.experiment(root, &mut master, &mut recorded);
    let experiment = root.child("DefaultExperiment").map(|e| reader.place(e));
    reader.system(system, "");
    let mut flat = flatten::flatten(nested, &mut gathered);
    for component in &mut flat.components {
        component.step = component.step.or(base_step);
    }
    Ok(RawSystem {
        file: file.to_owned(),
        name: system.get("name").or(root.get("name")).unwrap_or("system").to_owned(),
        components: flat.components,
        connections: flat.connections,
        ports: flat.ports,
        parameters: flat.parameters,
        experiment,
        start,
        stop,
        master,
        recorded,
        warnings: gathered.warnings,
        notes: gathered.notes,
        problems: gathered.problems,
        _unpacked: gathered.packages.into_values().collect(),
        fmus: gathered.fmus,
    })
}

/// Reads one file.
struct Reader<'a> {
    file: Arc<Path>,
    base: Base,
    /// The units that the file defines.
    units: Units,
    gathered: &'a mut Gathered,
    nested: &'a mut Nested,
}

impl Reader<'_> {
    /// Checks the root element and returns the system in it.
    fn document<'e>(&mut self, root: &'e Element) -> Result<&'e Element> {
        if root.name != "SystemStructureDescription" || root.namespace != SSD {
            return Err(self
                .wrong(root, format!("the root element is <{}>", root.name))
                .why(format!("a system description is a SystemStructureDescription of {SSD}")));
        }
        self.version(root)?;
        let children = [
            "System",
            "Enumerations",
            "Units",
            "DefaultExperiment",
            "Annotations",
            "MetaData",
            "Signature",
        ];
        self.known(root, &children, TOP);
        let units = units::read(root.grandchildren("Units"), &self.file, Code::Ssd);
        self.units = self.gathered.take(units).unwrap_or_default();
        root.child("System").ok_or_else(|| self.wrong(root, "there is no <System>"))
    }

    /// Every file of SSP has its own version.
    fn version(&self, root: &Element) -> Result<()> {
        let version = root.require("version", &self.file, Code::Ssd)?;
        if version.starts_with("1.") || version.starts_with("2.") {
            return Ok(());
        }
        Err(self.wrong(root, format!("the version of SSP is '{version}', not 1.0 or 2.0")))
    }

    fn experiment(
        &mut self,
        root: &Element,
        master: &mut RawMaster,
        recorded: &mut Vec<String>,
    ) -> (Option<f64>, Option<f64>) {
        let Some(element) = root.child("DefaultExperiment") else {
            return (None, None);
        };
        let children = ["Annotations", "MetaData", "Signature"];
        self.known(element, &children, &["startTime", "stopTime"]);
        self.master(element, master, recorded);
        let start = element.parse("startTime", &self.file, Code::Ssd);
        let stop = element.parse("stopTime", &self.file, Code::Ssd);
        (self.gathered.take(start).flatten(), self.gathered.take(stop).flatten())
    }

    /// A unit of this file, by the attribute `unit`.
    fn unit(&self, element: &Element) -> Option<RawUnit> {
        let name = element.get("unit")?;
        Some(RawUnit { name: name.to_owned(), unit: self.units.get(name).copied() })
    }

    /// The elements of a list, which allows no others.
    fn list<'e>(
        &mut self,
        owner: &'e Element,
        list: &str,
        child: &'static str,
    ) -> Vec<&'e Element> {
        let Some(list) = owner.child(list) else {
            return Vec::new();
        };
        self.known(list, &[child], &[]);
        list.children.iter().filter(|c| c.name == child).collect()
    }

    fn known(&mut self, element: &Element, children: &[&str], attributes: &[&str]) {
        self.gathered.known(&self.file, element, children, attributes);
    }

    /// Refuses the system if so many more bytes are too many.
    fn spend(&mut self, bytes: usize, element: &Element) -> Result<()> {
        let place = self.place(element);
        self.gathered.spend(bytes, &place)
    }

    fn place(&self, element: &Element) -> Place {
        place(&self.file, element)
    }

    fn wrong(&self, element: &Element, what: impl Into<String>) -> Error {
        wrong(&self.file, element, what)
    }

    fn unsupported(&self, element: &Element, what: &str) -> Error {
        self.wrong(element, format!("{what} are not supported (<{}>)", element.name))
            .why("ignoring them would change the meaning of the system")
    }
}

/// The full name of an element of a system.
fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}
