//! Systems, components and their connectors.

use std::path::{Path, PathBuf};

use super::super::source::Base;
use super::super::unpack;
use super::{Reader, join};
use crate::system::raw::{RawComponent, RawConnector, RawModel};
use cosim_base::error::{Code, Result};
use cosim_base::names;
use cosim_base::units::Units;
use cosim_base::xml::{self, Element};
use cosim_import::InterfaceType;

const FMU: &str = "application/x-fmu-sharedlibrary";
const DEFINITION: &str = "application/x-ssp-definition";
const PACKAGE: &str = "application/x-ssp-package";

/// Maximum depth and number of nested descriptions: a description may refer to itself.
const MAX_DEPTH: usize = 16;
const MAX_DESCRIPTIONS: usize = 200;

/// Types of connectors; SSP 2.0 uses those of FMI 3.0.
const TYPES: &[&str] = &[
    "Real",
    "Integer",
    "Boolean",
    "String",
    "Enumeration",
    "Binary",
    "Float64",
    "Float32",
    "Int8",
    "UInt8",
    "Int16",
    "UInt16",
    "Int32",
    "UInt32",
    "Int64",
    "UInt64",
    "Clock",
];

impl Reader<'_> {
    /// A system with everything in it; `path` is its full name, empty for the outermost.
    pub(super) fn system(&mut self, element: &Element, path: &str) {
        self.known(
            element,
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
                "MetaData",
                "Signature",
            ],
            &["name"],
        );
        // Each name inside begins with the path, and a connection keeps three of them.
        let inside = ["Connectors", "Elements", "Connections"];
        let count: usize = inside.map(|list| element.grandchildren(list).len()).iter().sum();
        let affordable = self.spend(3 * count * path.len(), element);
        if self.gathered.take(affordable).is_none() {
            return;
        }
        self.nested.systems.insert(path.to_owned());
        for connector in self.list(element, "Connectors", "Connector") {
            if let Some(found) = self.connector(connector) {
                self.nested.ports.insert((path.to_owned(), found.name.clone()), found);
            }
        }
        self.dictionaries(element, path);
        self.nested.around.push(path.to_owned());
        for child in element.grandchildren("Elements") {
            let done = self.element(child, path);
            self.gathered.take(done);
        }
        self.nested.around.pop();
        for connection in element.grandchildren("Connections") {
            let wire = self.wire(connection, path);
            let wire = self.gathered.take(wire);
            self.nested.wires.extend(wire);
        }
        // After those of the elements: a binding of a system takes precedence over an inner one.
        self.bindings(element, path, None);
    }

    fn element(&mut self, element: &Element, path: &str) -> Result<()> {
        match element.name.as_str() {
            "Component" => self.component(element, path),
            "System" => {
                let name = element.require("name", &self.file, Code::Ssd)?;
                self.system(element, &join(path, name));
                Ok(())
            }
            "SignalDictionaryReference" => self.reference(element, path),
            other => Err(self
                .wrong(element, format!("<{other}> among the elements is unknown"))
                .maybe_help(names::did_you_mean(other, ["Component", "System"]))),
        }
    }

    fn component(&mut self, element: &Element, path: &str) -> Result<()> {
        self.known(
            element,
            &[
                "Connectors",
                "ElementGeometry",
                "ParameterBindings",
                "Annotations",
                "MetaData",
                "Signature",
            ],
            &["name", "source", "type", "implementation"],
        );
        let name = element.require("name", &self.file, Code::Ssd)?;
        let full = join(path, name);
        match element.get("type") {
            None | Some(FMU) => (),
            Some(DEFINITION | PACKAGE) => {
                let source = element.require("source", &self.file, Code::Ssd)?;
                let source = self.base.open(source, &self.place(element))?;
                let done = self.description_in(element, &source, &full);
                self.bindings(element, &full, None);
                return done;
            }
            Some(other) => {
                let problem = self.wrong(element, format!("the type of '{name}' is \"{other}\""));
                self.gathered.problems.push(
                    problem
                        .why(format!("supported are \"{FMU}\", \"{DEFINITION}\", \"{PACKAGE}\"")),
                );
            }
        }
        let connectors = self.list(element, "Connectors", "Connector").into_iter();
        let connectors = connectors.filter_map(|e| self.connector(e)).collect();
        let interface = self.implementation(element, name);
        let interface = self.gathered.take(interface).flatten();
        let source = self.source(element);
        let source = self.gathered.take(source);
        self.bindings(element, &full, source.as_deref());
        let component = RawComponent {
            name: full,
            model: source.map_or(RawModel::Unknown, RawModel::Fmu),
            interface,
            step: self.step(element),
            worker: self.worker(element),
            connectors: Some(connectors),
            place: self.place(element),
        };
        self.nested.components.push(component);
        Ok(())
    }

    fn implementation(&self, element: &Element, name: &str) -> Result<Option<InterfaceType>> {
        match element.get("implementation") {
            None | Some("any") => Ok(None),
            Some("CoSimulation") => Ok(Some(InterfaceType::CoSimulation)),
            Some("ModelExchange") => Ok(Some(InterfaceType::ModelExchange)),
            Some(other) => Err(self
                .wrong(element, format!("implementation=\"{other}\" of '{name}'"))
                .help("write any, CoSimulation or ModelExchange")),
        }
    }

    /// The file of a `source`.
    pub(super) fn source(&self, element: &Element) -> Result<PathBuf> {
        let source = element.require("source", &self.file, Code::Ssd)?;
        self.base.follow(source, &self.place(element))
    }

    /// Another description used as a component: its system becomes a nested one.
    fn description_in(&mut self, element: &Element, file: &Path, path: &str) -> Result<()> {
        self.gathered.descriptions += 1;
        if self.gathered.depth == MAX_DEPTH || self.gathered.descriptions > MAX_DESCRIPTIONS {
            return Err(self
                .wrong(element, "descriptions are nested too deeply, or there are too many")
                .why(format!(
                    "the limits are {MAX_DEPTH} levels and {MAX_DESCRIPTIONS} descriptions"
                )));
        }
        let (file, shown, base) = if element.get("type") == Some(PACKAGE) {
            unpack(file, self.gathered)?
        } else {
            (file.to_owned(), file.to_owned(), self.base.of_neighbour(file))
        };
        let place = self.place(element);
        self.gathered.spend_on(&file, &place)?;
        let root = xml::read(&file, &shown)?;
        self.gathered.depth += 1;
        let mut inner = Reader {
            file: shown.into(),
            base,
            units: Units::new(),
            gathered: self.gathered,
            nested: self.nested,
        };
        let system = inner.document(&root);
        if let Some(system) = inner.gathered.take(system) {
            inner.system(system, path);
        }
        self.gathered.depth -= 1;
        Ok(())
    }

    fn connector(&mut self, element: &Element) -> Option<RawConnector> {
        let other = ["ConnectorGeometry", "Annotations", "MetaData", "Signature", "Dimension"];
        let children: Vec<&str> = TYPES.iter().copied().chain(other).collect();
        self.known(element, &children, &["name", "kind"]);
        let array =
            element.child("Dimension").map(|dimension| self.unsupported(dimension, "arrays"));
        self.gathered.problems.extend(array);
        let typed = element.children.iter().find(|c| TYPES.contains(&c.name.as_str()));
        let name = element.require("name", &self.file, Code::Ssd).map(str::to_owned);
        let kind = element.require("kind", &self.file, Code::Ssd).map(str::to_owned);
        Some(RawConnector {
            name: self.gathered.take(name)?,
            kind: self.gathered.take(kind)?,
            kind_of_value: typed.map(|c| of_fmi_2(&c.name).to_owned()),
            unit: typed.and_then(|typed| self.unit(typed)),
            place: self.place(element),
        })
    }

    /// The base of sources in a component's own archive (`sourceBase="component"`).
    pub(super) fn base_in(&self, fmu: &Path) -> Result<Base> {
        Ok(Base::of_archive(self.gathered.fmus.open(fmu)?.folder()))
    }
}

/// FMI 2.0 has one type of floating-point number and one of integer.
pub(super) fn of_fmi_2(kind: &str) -> &str {
    match kind {
        "Float64" => "Real",
        "Int32" => "Integer",
        other => other,
    }
}
