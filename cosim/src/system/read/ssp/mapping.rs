//! `<ssm:ParameterMapping>`: other names for parameters, inline or in an .ssm file.

use super::Reader;
use super::connection::TRANSFORMATIONS;
use crate::error::{Code, Result};
use crate::system::raw::{Place, Stage};
use crate::xml::Element;

/// One parameter under another name.
pub(super) struct Entry {
    pub source: String,
    pub target: String,
    pub stage: Stage,
    pub place: Place,
}

impl Reader<'_> {
    /// The entries of a binding's mapping; `None` if it has none: names stay unchanged.
    pub(super) fn mapping(
        &mut self,
        binding: &Element,
        component: Option<&std::path::Path>,
    ) -> Result<Option<Vec<Entry>>> {
        let Some(element) = binding.child("ParameterMapping") else {
            return Ok(None);
        };
        self.known(element, &["ParameterMapping"], &["type", "source", "sourceBase"]);
        let kind = element.get("type").unwrap_or("application/x-ssp-parameter-mapping");
        if kind != "application/x-ssp-parameter-mapping" {
            return Err(self.wrong(element, format!("the type of the mapping is \"{kind}\"")));
        }
        match (element.get("source"), element.child("ParameterMapping")) {
            (None, Some(inline)) => self.entries(inline).map(Some),
            (Some(source), None) => {
                let (root, mut other) = self.follow(element, source, component)?;
                other.entries(&root).map(Some)
            }
            _ => Err(self
                .wrong(element, "a mapping is either inline or in a file")
                .help("add a source, or one <ssm:ParameterMapping> inside")),
        }
    }

    fn entries(&mut self, mapping: &Element) -> Result<Vec<Entry>> {
        if mapping.name != "ParameterMapping" {
            return Err(
                self.wrong(mapping, format!("<{}> where <ParameterMapping> belongs", mapping.name))
            );
        }
        self.version(mapping)?;
        let children = ["MappingEntry", "Annotations", "MetaData", "Signature"];
        self.known(mapping, &children, super::TOP);
        let mut entries: Vec<Entry> = Vec::new();
        for element in mapping.children.iter().filter(|c| c.name == "MappingEntry") {
            let children = [&TRANSFORMATIONS[..], &["Annotations", "MetaData", "Signature"]];
            self.known(
                element,
                &children.concat(),
                &["source", "target", "suppressUnitConversion"],
            );
            let text = |name| element.require(name, &self.file, Code::Ssd).map(str::to_owned);
            let (source, target) = (text("source")?, text("target")?);
            if let Some(first) = entries.iter().find(|e| e.target == target) {
                return Err(self
                    .wrong(element, format!("two parameters are mapped to '{target}'"))
                    .why(format!("the first on line {}", first.place.line)));
            }
            let (stage, place) = (self.stage(element)?, self.place(element));
            entries.push(Entry { source, target, stage, place });
        }
        Ok(entries)
    }
}
