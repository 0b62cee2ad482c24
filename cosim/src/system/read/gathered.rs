//! Results of reading besides the system: problems, warnings, and opened files.

use std::path::Path;
use std::sync::Arc;

use crate::error::{Code, Error, Result};
use crate::fmi::archive::Unpacked;
use crate::names;
use crate::system::opened::OpenedFmus;
use crate::system::raw::Place;
use crate::xml::Element;

/// Findings of all files of one system.
#[derive(Default)]
pub(super) struct Gathered {
    pub warnings: Vec<String>,
    pub notes: Vec<String>,
    pub problems: Vec<Error>,
    pub fmus: OpenedFmus,
    pub unpacked: Vec<Unpacked>,
    /// Nesting depth of the file: descriptions may refer to descriptions.
    pub depth: usize,
    /// How many nested descriptions were read.
    pub descriptions: usize,
}

/// Attributes that every element of SSP may have.
const COMMON: &[&str] = &["id", "description"];

impl Gathered {
    /// The value, or `None` after recording the problem.
    pub(super) fn take<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|problem| self.problems.push(problem)).ok()
    }

    /// Reports children that the format does not allow there, and warns about such attributes.
    pub(super) fn known(
        &mut self,
        file: &Arc<Path>,
        element: &Element,
        children: &[&str],
        attributes: &[&str],
    ) {
        let parent = &element.name;
        for child in element.children.iter().filter(|c| !children.contains(&c.name.as_str())) {
            let what = format!("<{}> in <{parent}> is unknown", child.name);
            let hint = names::did_you_mean(&child.name, children.iter().copied());
            self.problems.push(
                Error::new(Code::Ssd, what)
                    .at_line(file, child.line)
                    .why("ignoring it could change the meaning of the system")
                    .maybe_help(hint.or(Some("remove it".to_owned()))),
            );
        }
        for attribute in &element.attributes {
            let name = attribute.name.as_str();
            if !attributes.contains(&name) && !COMMON.contains(&name) && !name.contains(':') {
                let hint = names::did_you_mean(name, attributes.iter().copied());
                let hint = hint.map_or(String::new(), |hint| format!("; {hint}"));
                self.warnings.push(format!(
                    "{}:{}: the attribute '{name}' of <{parent}> is unknown and ignored{hint}",
                    file.display(),
                    element.line,
                ));
            }
        }
    }
}

/// The location of an element.
pub(super) fn place(file: &Arc<Path>, element: &Element) -> Place {
    Place { file: file.clone(), line: element.line }
}

/// An error at an element.
pub(super) fn wrong(file: &Arc<Path>, element: &Element, what: impl Into<String>) -> Error {
    Error::new(Code::Ssd, what).at_line(file, element.line)
}
