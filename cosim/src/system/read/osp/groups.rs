//! Variable groups: `<modelName>_OspModelDescription.xml` beside the FMU or the structure.
//!
//! A group is a list of variables; a group of groups is the concatenation of their lists.

use std::collections::BTreeMap;
use std::path::Path;

use super::Reader;
use crate::error::{Code, Error, Result};
use crate::names;
use crate::xml::{self, Element};

/// Groups by simulator and name; `None`: the simulator has no such file.
#[derive(Default)]
pub(super) struct Groups(BTreeMap<String, Option<BTreeMap<String, Vec<String>>>>);

/// Elements that are groups; OSP-IS 1.0 has one for each physical quantity.
fn is_group(element: &Element) -> bool {
    element.name != "Variable"
}

impl Reader {
    /// Reads the groups of a simulator; the check reports an FMU that cannot be opened.
    pub(super) fn read_groups(&mut self, simulator: &str, fmu: &Path) {
        let Ok(opened) = self.gathered.fmus.open(fmu) else {
            return;
        };
        let name = format!("{}_OspModelDescription.xml", opened.description().model_name);
        let folders = [fmu.parent().map(Path::to_owned), self.base.folder.clone()];
        let file = folders.iter().flatten().map(|f| f.join(&name)).find(|f| f.is_file());
        let groups = file.and_then(|file| {
            let read = xml::read(&file, &file).and_then(|root| groups(&root, &file));
            self.gathered.take(read)
        });
        self.groups.0.insert(simulator.to_owned(), groups);
    }

    /// The variables of a group; `None` if its simulator's FMU could not be opened.
    pub(super) fn group(
        &self,
        (simulator, name): &(String, String),
        element: &Element,
    ) -> Result<Option<Vec<String>>> {
        let unknown =
            |what: String| Error::new(Code::UnknownName, what).at_line(&self.file, element.line);
        let groups = match self.groups.0.get(simulator) {
            Some(Some(groups)) => groups,
            Some(None) => {
                return Err(unknown(format!("'{simulator}' has no variable groups")).help(
                    "put its <modelName>_OspModelDescription.xml beside the FMU or this file",
                ));
            }
            None if self.components.iter().any(|c| c.name == *simulator) => return Ok(None),
            None => {
                let all = self.components.iter().map(|c| c.name.as_str());
                return Err(unknown(format!("there is no simulator '{simulator}'"))
                    .maybe_help(names::did_you_mean(simulator, all)));
            }
        };
        let found = groups.get(name).cloned().map(Some);
        found.ok_or_else(|| {
            unknown(format!("'{simulator}' has no variable group '{name}'"))
                .maybe_help(names::did_you_mean(name, groups.keys().map(String::as_str)))
        })
    }
}

/// All groups of an OspModelDescription, including nested ones.
pub(super) fn groups(root: &Element, file: &Path) -> Result<BTreeMap<String, Vec<String>>> {
    if root.name != "OspModelDescription" {
        return Err(Error::new(Code::Ssd, format!("the root element is <{}>", root.name))
            .at_line(file, root.line)
            .why("variable groups are in an OspModelDescription"));
    }
    let mut all = BTreeMap::new();
    for group in root.grandchildren("VariableGroups") {
        collect(group, file, &mut all)?;
    }
    Ok(all)
}

fn collect(
    group: &Element,
    file: &Path,
    all: &mut BTreeMap<String, Vec<String>>,
) -> Result<Vec<String>> {
    let mut variables = Vec::new();
    for child in &group.children {
        if is_group(child) {
            variables.extend(collect(child, file, all)?);
        } else {
            variables.push(child.require("ref", file, Code::Ssd)?.to_owned());
        }
    }
    let name = group.require("name", file, Code::Ssd)?;
    all.insert(name.to_owned(), variables.clone());
    Ok(variables)
}
