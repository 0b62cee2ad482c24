//! This master's own annotations.
//!
//! SSP 1.0 has no place for step sizes and the master algorithm, so they stand in annotations,
//! all of them optional, which other tools leave alone:
//!
//! ```xml
//! <ssd:Annotations xmlns:cosim="urn:cosim:1">
//!   <ssc:Annotation type="cosim">
//!     <cosim:Master algorithm="gauss-seidel" stepSize="0.01" outputInterval="0.1"/>
//!   </ssc:Annotation>
//! </ssd:Annotations>
//! ```
//! in the SystemStructureDescription, its System or its DefaultExperiment, and
//! `<cosim:Component stepSize="0.1"/>` in a Component. Without them a component steps by the
//! stepSize of its FMU's DefaultExperiment.

use super::Reader;
use crate::error::{Code, Result};
use crate::system::raw::RawMaster;
use crate::xml::Element;

const NAMESPACE: &str = "urn:cosim:1";

impl Reader<'_> {
    pub(super) fn master(&mut self, owner: &Element, master: &mut RawMaster) -> Result<()> {
        for element in self.ours(owner, "Master") {
            self.known(element, &[], &["algorithm", "stepSize", "outputInterval"]);
            if let Some(text) = element.get("algorithm") {
                let algorithm = text.parse().map_err(|e: String| self.wrong(element, e))?;
                master.algorithm = Some(algorithm);
            }
            let number = |name| element.parse(name, self.file, Code::Ssd);
            master.step = number("stepSize")?.or(master.step);
            master.output_interval = number("outputInterval")?.or(master.output_interval);
        }
        Ok(())
    }

    pub(super) fn step(&mut self, owner: &Element) -> Result<Option<f64>> {
        let mut step = None;
        for element in self.ours(owner, "Component") {
            self.known(element, &[], &["stepSize"]);
            step = element.parse("stepSize", self.file, Code::Ssd)?.or(step);
        }
        Ok(step)
    }

    /// The elements of our namespace in the annotations of `owner`; others than `name` are told.
    fn ours<'e>(&mut self, owner: &'e Element, name: &str) -> Vec<&'e Element> {
        let mut found = Vec::new();
        let annotations = owner.grandchildren("Annotations").iter();
        for element in annotations.flat_map(|a| &a.children).filter(|e| e.namespace == NAMESPACE) {
            if element.name == name {
                found.push(element);
            } else {
                self.warnings.push(format!(
                    "{}:{}: <{}> of {NAMESPACE} is unknown here and ignored; did you mean <{name}>?",
                    self.file.display(),
                    element.line,
                    element.name,
                ));
            }
        }
        found
    }
}
