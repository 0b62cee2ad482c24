//! `<ssd:Component>` and its connectors.

use super::Reader;
use crate::error::{Code, Result};
use crate::fmi::InterfaceType;
use crate::system::raw::{RawComponent, RawConnector};
use crate::xml::Element;

const FMU: &str = "application/x-fmu-sharedlibrary";

impl Reader<'_> {
    pub(super) fn component(&mut self, element: &Element) -> Result<RawComponent> {
        match element.name.as_str() {
            "Component" => (),
            "System" => return Err(self.unsupported(element, "systems inside of a system")),
            "SignalDictionaryReference" => {
                return Err(self.unsupported(element, "signal dictionaries"));
            }
            other => return Err(self.wrong(element, format!("<{other}> among the elements"))),
        }
        self.known(
            element,
            &["Connectors", "ElementGeometry", "ParameterBindings", "Annotations"],
            &["name", "source", "type", "implementation"],
        );
        let name = element.require("name", self.file, Code::Ssd)?;
        if let Some(other) = element.get("type").filter(|&t| t != FMU) {
            return Err(self
                .wrong(element, format!("the type of '{name}' is \"{other}\""))
                .why(format!("only FMUs can be run: \"{FMU}\"")));
        }
        let interface = match element.get("implementation") {
            None | Some("any") => None,
            Some("CoSimulation") => Some(InterfaceType::CoSimulation),
            Some("ModelExchange") => Some(InterfaceType::ModelExchange),
            Some(other) => {
                return Err(self
                    .wrong(element, format!("implementation=\"{other}\" of '{name}'"))
                    .help("write any, CoSimulation or ModelExchange"));
            }
        };
        let source = element.require("source", self.file, Code::Ssd)?;
        Ok(RawComponent {
            name: name.to_owned(),
            source: self.folder.join(source.strip_prefix("file://").unwrap_or(source)),
            interface,
            step: self.step(element)?,
            connectors: element
                .grandchildren("Connectors")
                .iter()
                .map(|e| self.connector(e))
                .collect::<Result<_>>()?,
            parameters: self.parameters(element)?,
            line: element.line,
        })
    }

    fn connector(&mut self, element: &Element) -> Result<RawConnector> {
        const TYPES: &[&str] = &["Real", "Integer", "Boolean", "String", "Enumeration", "Binary"];
        let other = ["ConnectorGeometry", "Annotations"];
        let children: Vec<&str> = TYPES.iter().copied().chain(other).collect();
        self.known(element, &children, &["name", "kind"]);
        Ok(RawConnector {
            name: element.require("name", self.file, Code::Ssd)?.to_owned(),
            kind: element.require("kind", self.file, Code::Ssd)?.to_owned(),
            kind_of_value: element
                .children
                .iter()
                .find(|c| TYPES.contains(&c.name.as_str()))
                .map(|c| c.name.clone()),
            line: element.line,
        })
    }
}
