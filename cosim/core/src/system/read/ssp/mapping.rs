//! `<ssm:ParameterMapping>`: other names for parameters, inline or in an .ssm file.

use std::collections::HashMap;
use std::sync::Arc;

use super::Reader;
use super::connection::TRANSFORMATIONS;
use crate::system::raw::{Place, Stage};
use cosim_base::error::{Code, Result};
use cosim_base::xml::Element;

/// One parameter under another name.
pub(super) struct Entry {
    pub source: String,
    pub target: String,
    pub stage: Stage,
    pub place: Place,
}

impl Entry {
    /// Its memory in bytes.
    pub(super) fn size(&self) -> usize {
        size_of::<Self>() + self.source.len() + self.target.len() + self.stage.size()
    }
}

impl Reader<'_> {
    /// The entries of a binding's mapping; `None` if it has none: names stay unchanged.
    pub(super) fn mapping(
        &mut self,
        binding: &Element,
        component: Option<&std::path::Path>,
    ) -> Result<Option<Arc<[Entry]>>> {
        let Some(element) = binding.child("ParameterMapping") else {
            return Ok(None);
        };
        self.known(element, &["ParameterMapping"], &["type", "source", "sourceBase"]);
        let kind = element.get("type").unwrap_or("application/x-ssp-parameter-mapping");
        if kind != "application/x-ssp-parameter-mapping" {
            return Err(self.wrong(element, format!("the type of the mapping is \"{kind}\"")));
        }
        match (element.get("source"), element.child("ParameterMapping")) {
            (None, Some(inline)) => Ok(Some(self.entries(inline)?.into())),
            (Some(source), None) => {
                let (base, file) = self.file(element, source, component)?;
                if let Some(read) = self.nested.mapping_files.get(&file) {
                    return Ok(Some(read.clone()));
                }
                let (root, mut other) = self.follow(element, base, &file)?;
                let entries: Arc<[Entry]> = other.entries(&root)?.into();
                self.nested.mapping_files.insert(file, entries.clone());
                Ok(Some(entries))
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
        let mut lines: HashMap<&str, usize> = HashMap::new();
        for element in mapping.children.iter().filter(|c| c.name == "MappingEntry") {
            let children = [&TRANSFORMATIONS[..], &["Annotations", "MetaData", "Signature"]];
            self.known(
                element,
                &children.concat(),
                &["source", "target", "suppressUnitConversion"],
            );
            let text = |name| element.require(name, &self.file, Code::Ssd);
            let (source, target) = (text("source")?, text("target")?);
            if let Some(first) = lines.insert(target, element.line) {
                return Err(self
                    .wrong(element, format!("two parameters are mapped to '{target}'"))
                    .why(format!("the first on line {first}")));
            }
            let (stage, place) = (self.stage(element)?, self.place(element));
            let (source, target) = (source.to_owned(), target.to_owned());
            entries.push(Entry { source, target, stage, place });
        }
        Ok(entries)
    }
}
