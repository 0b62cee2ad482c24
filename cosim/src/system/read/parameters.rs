//! Parameter bindings: inline (`<ssd:ParameterValues>`) or in an .ssv file.

use std::path::Path;

use super::Reader;
use crate::error::{Code, Error, Result};
use crate::system::raw::RawParameter;
use crate::xml::{self, Element};

impl Reader<'_> {
    /// All values bound to `owner`, in the order of the file; later ones win.
    pub(super) fn parameters(&mut self, owner: &Element) -> Result<Vec<RawParameter>> {
        let mut values = Vec::new();
        for binding in owner.grandchildren("ParameterBindings") {
            self.known(
                binding,
                &["ParameterValues", "ParameterMapping", "Annotations"],
                &["type", "source", "sourceBase", "prefix"],
            );
            if let Some(mapping) = binding.child("ParameterMapping") {
                return Err(self.unsupported(mapping, "parameter mappings"));
            }
            let prefix = binding.get("prefix").unwrap_or_default();
            if let Some(source) = binding.get("source") {
                let path = self.folder.join(source);
                let root = xml::read(&path, &path)
                    .map_err(|e| e.help(format!("named in {}", self.place(binding))))?;
                self.set(&root, &path, prefix, &mut values)?;
            }
            for set in binding.grandchildren("ParameterValues") {
                let file = self.file;
                self.set(set, file, prefix, &mut values)?;
            }
        }
        Ok(values)
    }

    fn set(
        &mut self,
        set: &Element,
        file: &Path,
        prefix: &str,
        values: &mut Vec<RawParameter>,
    ) -> Result<()> {
        let wrong = |element: &Element, what: String| {
            Error::new(Code::Ssd, what).at_line(file, element.line)
        };
        if set.name != "ParameterSet" {
            return Err(wrong(set, format!("<{}> where <ParameterSet> belongs", set.name)));
        }
        for parameter in set.grandchildren("Parameters") {
            let name = parameter.require("name", file, Code::Ssd)?;
            let typed = parameter
                .children
                .iter()
                .find(|c| c.name != "Annotations")
                .ok_or_else(|| wrong(parameter, format!("'{name}' has no value")))?;
            let kinds = ["Real", "Integer", "Boolean", "String", "Enumeration"];
            if !kinds.contains(&typed.name.as_str()) {
                return Err(wrong(typed, format!("'{name}' is of the type <{}>", typed.name))
                    .why(format!("supported are {}", kinds.join(", "))));
            }
            values.push(RawParameter {
                name: format!("{prefix}{name}"),
                kind: typed.name.clone(),
                value: typed.require("value", file, Code::Ssd)?.to_owned(),
                file: file.to_owned(),
                line: parameter.line,
            });
        }
        Ok(())
    }

    fn place(&self, element: &Element) -> String {
        format!("{}:{}", self.file.display(), element.line)
    }
}
