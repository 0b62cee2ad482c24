//! SSP 1.0 and 2.0 files into raw structures.
//!
//! Read: a flat system of FMU components with connectors, connections and parameter values,
//! inline or in .ssv files, and the default experiment. Refused by name: what would change the
//! meaning if it were left out (nested systems, mappings, transformations, dictionaries).
//! Left out silently: geometry, units, enumerations (the FMUs have their own) and annotations of
//! other tools. Anything else unknown gives a warning.

mod annotation;
mod component;
mod parameters;

use std::path::{Path, PathBuf};

use super::opened::OpenedFmus;
use super::raw::{RawConnection, RawMaster, RawSystem};
use crate::error::{Code, Error, Result};
use crate::fmi::archive;
use crate::xml::{self, Element};

/// Namespace of system descriptions.
const SSD: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";

/// Attributes that every element may have.
const COMMON: &[&str] = &["id", "description"];

/// Reads a .ssd or .ssp file.
pub(super) fn read(file: &Path) -> Result<RawSystem> {
    let is_package = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("ssp"));
    if !is_package {
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        return Reader::new(file, folder).system(&xml::read(file, file)?);
    }
    let unpacked = archive::unpack(file)?;
    let description = unpacked.path().join("SystemStructure.ssd");
    let shown = file.join("SystemStructure.ssd");
    if !description.is_file() {
        return Err(Error::new(Code::Archive, "the package has no SystemStructure.ssd")
            .at(file)
            .help("an .ssp has that file at its top level, in no folder"));
    }
    let reader = Reader::new(&shown, unpacked.path().to_owned());
    let mut system = reader.system(&xml::read(&description, &shown)?)?;
    system._unpacked = Some(unpacked);
    Ok(system)
}

struct Reader<'a> {
    file: &'a Path,
    folder: PathBuf,
    warnings: Vec<String>,
}

impl<'a> Reader<'a> {
    fn new(file: &'a Path, folder: PathBuf) -> Self {
        Self { file, folder, warnings: Vec::new() }
    }

    fn system(mut self, root: &Element) -> Result<RawSystem> {
        if root.name != "SystemStructureDescription" || root.namespace != SSD {
            return Err(self
                .wrong(root, format!("the root element is <{}>", root.name))
                .why(format!("a system description is a SystemStructureDescription of {SSD}")));
        }
        let version = root.require("version", self.file, Code::Ssd)?;
        if !version.starts_with("1.") && !version.starts_with("2.") {
            return Err(self.wrong(root, format!("the version of SSP is '{version}', not 1.0")));
        }
        self.known(
            root,
            &["System", "Enumerations", "Units", "DefaultExperiment", "Annotations", "MetaData"],
            &[
                "name",
                "version",
                "author",
                "fileversion",
                "copyright",
                "license",
                "generationTool",
                "generationDateAndTime",
            ],
        );
        let system =
            root.child("System").ok_or_else(|| self.wrong(root, "there is no <System>"))?;
        self.flat(system)?;
        let mut master = RawMaster::default();
        self.master(root, &mut master)?;
        self.master(system, &mut master)?;
        let (start, stop) = self.experiment(root, &mut master)?;
        Ok(RawSystem {
            file: self.file.to_owned(),
            name: system.get("name").or(root.get("name")).unwrap_or("system").to_owned(),
            components: system
                .grandchildren("Elements")
                .iter()
                .map(|e| self.component(e))
                .collect::<Result<_>>()?,
            connections: system
                .grandchildren("Connections")
                .iter()
                .map(|e| self.connection(e))
                .collect::<Result<_>>()?,
            parameters: self.parameters(system)?,
            start,
            stop,
            master,
            warnings: self.warnings,
            _unpacked: None,
            fmus: OpenedFmus::default(),
        })
    }

    fn flat(&mut self, system: &Element) -> Result<()> {
        self.known(
            system,
            &[
                "Connectors",
                "ElementGeometry",
                "ParameterBindings",
                "Elements",
                "Connections",
                "SignalDictionaries",
                "SystemGeometry",
                "GraphicalElements",
                "Annotations",
            ],
            &["name"],
        );
        if let Some(first) = system.grandchildren("Connectors").first() {
            return Err(self.unsupported(first, "connectors of the system itself"));
        }
        match system.grandchildren("SignalDictionaries").first() {
            Some(first) => Err(self.unsupported(first, "signal dictionaries")),
            None => Ok(()),
        }
    }

    fn experiment(
        &mut self,
        root: &Element,
        master: &mut RawMaster,
    ) -> Result<(Option<f64>, Option<f64>)> {
        let Some(element) = root.child("DefaultExperiment") else {
            return Ok((None, None));
        };
        self.known(element, &["Annotations"], &["startTime", "stopTime"]);
        self.master(element, master)?;
        let number = |name| element.parse(name, self.file, Code::Ssd);
        Ok((number("startTime")?, number("stopTime")?))
    }

    fn connection(&mut self, element: &Element) -> Result<RawConnection> {
        if element.name != "Connection" {
            return Err(self.wrong(element, format!("<{}> among connections", element.name)));
        }
        self.known(
            element,
            &[
                "ConnectionGeometry",
                "Annotations",
                "LinearTransformation",
                "BooleanMappingTransformation",
                "IntegerMappingTransformation",
                "EnumerationMappingTransformation",
            ],
            &[
                "startElement",
                "startConnector",
                "endElement",
                "endConnector",
                "suppressUnitConversion",
            ],
        );
        if let Some(other) = element.children.iter().find(|c| c.name.ends_with("Transformation")) {
            return Err(self.unsupported(other, "transformations of connections"));
        }
        let text = |name| element.require(name, self.file, Code::Ssd).map(str::to_owned);
        Ok(RawConnection {
            from: (text("startElement")?, text("startConnector")?),
            to: (text("endElement")?, text("endConnector")?),
            suppress_unit_conversion: element.flag(
                "suppressUnitConversion",
                self.file,
                Code::Ssd,
            )?,
            line: element.line,
        })
    }

    /// Warns of children and attributes that SSP does not have there.
    fn known(&mut self, element: &Element, children: &[&str], attributes: &[&str]) {
        let (file, parent) = (self.file.display(), &element.name);
        for child in element.children.iter().filter(|c| !children.contains(&c.name.as_str())) {
            let (line, name) = (child.line, &child.name);
            self.warnings
                .push(format!("{file}:{line}: <{name}> in <{parent}> is unknown and ignored"));
        }
        for attribute in &element.attributes {
            let name = attribute.name.as_str();
            if !attributes.contains(&name) && !COMMON.contains(&name) && !name.contains(':') {
                let line = element.line;
                self.warnings.push(format!(
                    "{file}:{line}: the attribute '{name}' of <{parent}> is unknown and ignored"
                ));
            }
        }
    }

    fn wrong(&self, element: &Element, what: impl Into<String>) -> Error {
        Error::new(Code::Ssd, what).at_line(self.file, element.line)
    }

    fn unsupported(&self, element: &Element, what: &str) -> Error {
        self.wrong(element, format!("{what} are not supported (<{}>)", element.name))
            .why("leaving them out would change what the system means")
            .help("write the system flat: components, their connectors, connections between them")
    }
}
