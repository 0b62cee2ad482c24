//! Variable groups: `<modelName>_OspModelDescription.xml` beside the FMU or the structure.
//!
//! A group is a list of variables; a group of groups is the concatenation of their lists.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Reader;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::xml::{self, Element};

/// Groups by simulator; `None`: the simulator has no such file.
#[derive(Default)]
pub(super) struct Groups {
    of: HashMap<String, Option<Arc<File>>>,
    /// By path; `None`: not readable.
    read: HashMap<PathBuf, Option<Arc<File>>>,
}

/// The groups of a file. In the order of the file, the variables of each stand side by side.
#[derive(Default)]
pub(super) struct File {
    variables: Vec<String>,
    groups: BTreeMap<String, Range<usize>>,
}

/// A group.
pub(super) struct Group(Arc<File>, Range<usize>);

impl Group {
    pub(super) fn variables(&self) -> &[String] {
        &self.0.variables[self.1.clone()]
    }

    pub(super) fn len(&self) -> usize {
        self.1.len()
    }
}

/// Elements that are groups; OSP-IS 1.0 has one for each physical quantity.
fn is_group(element: &Element) -> bool {
    element.name != "Variable"
}

impl Reader {
    /// Reads the groups of a simulator; the check reports an FMU that cannot be opened.
    pub(super) fn read_groups(&mut self, simulator: &str, fmu: &Path, element: &Element) {
        let Ok(opened) = self.gathered.fmus.open(fmu) else {
            return;
        };
        let name = format!("{}_OspModelDescription.xml", opened.description().model_name);
        let folders = [fmu.parent().map(Path::to_owned), self.base.folder.clone()];
        let file = folders.iter().flatten().map(|f| f.join(&name)).find(|f| f.is_file());
        let groups = file.and_then(|file| {
            if let Some(read) = self.groups.read.get(&file) {
                return read.clone();
            }
            let read = self.spend_on(&file, element).and_then(|()| {
                let root = xml::read(&file, &file)?;
                groups(&root, &file).map(Arc::new)
            });
            let read = self.gathered.take(read);
            self.groups.read.insert(file, read.clone());
            read
        });
        self.groups.of.insert(simulator.to_owned(), groups);
    }

    /// The variables of a group; `None` if its simulator's FMU could not be opened.
    pub(super) fn group(
        &self,
        (simulator, name): &(String, String),
        element: &Element,
    ) -> Result<Option<Group>> {
        let unknown =
            |what: String| Error::new(Code::UnknownName, what).at_line(&self.file, element.line);
        let groups = match self.groups.of.get(simulator) {
            Some(Some(groups)) => groups,
            Some(None) => {
                return Err(unknown(format!("'{simulator}' has no variable groups")).help(
                    "put its <modelName>_OspModelDescription.xml beside the FMU or this file",
                ));
            }
            None if self.component(simulator).is_some() => return Ok(None),
            None => {
                let all = self.components.iter().map(|c| c.name.as_str());
                return Err(unknown(format!("there is no simulator '{simulator}'"))
                    .maybe_help(names::did_you_mean(simulator, all)));
            }
        };
        let found = groups.groups.get(name).map(|range| Group(groups.clone(), range.clone()));
        found.map(Some).ok_or_else(|| {
            unknown(format!("'{simulator}' has no variable group '{name}'"))
                .maybe_help(names::did_you_mean(name, groups.groups.keys().map(String::as_str)))
        })
    }
}

/// All groups of an OspModelDescription, including nested ones.
fn groups(root: &Element, file: &Path) -> Result<File> {
    if root.name != "OspModelDescription" {
        return Err(Error::new(Code::Ssd, format!("the root element is <{}>", root.name))
            .at_line(file, root.line)
            .why("variable groups are in an OspModelDescription"));
    }
    let mut all = File::default();
    for group in root.grandchildren("VariableGroups") {
        collect(group, file, &mut all)?;
    }
    Ok(all)
}

fn collect(group: &Element, file: &Path, all: &mut File) -> Result<()> {
    let first = all.variables.len();
    for child in &group.children {
        if is_group(child) {
            collect(child, file, all)?;
        } else {
            all.variables.push(child.require("ref", file, Code::Ssd)?.to_owned());
        }
    }
    let name = group.require("name", file, Code::Ssd)?;
    all.groups.insert(name.to_owned(), first..all.variables.len());
    Ok(())
}
