//! Results of reading besides the system: problems, warnings, and opened files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::system::opened::OpenedFmus;
use crate::system::raw::Place;
use cosim_base::Warnings;
use cosim_base::error::{Code, Error, Problems, Result};
use cosim_base::names;
use cosim_base::xml::Element;
use cosim_import::archive::Unpacked;

/// Findings of all files of one system.
#[derive(Default)]
pub(super) struct Gathered {
    pub warnings: Warnings,
    pub notes: Vec<String>,
    pub problems: Problems,
    pub fmus: OpenedFmus,
    /// Nested packages by path: each is unpacked once.
    pub packages: BTreeMap<PathBuf, Unpacked>,
    /// Nesting depth of the file: descriptions may refer to descriptions.
    pub depth: usize,
    /// How many nested descriptions were read.
    pub descriptions: usize,
    /// Memory used up, of `MAX_COPIED`.
    copied: usize,
}

/// Memory in bytes for what a system makes of the files that it names, and for everything that it
/// uses repeatedly: a short file can use a long one many times.
const MAX_COPIED: usize = 512 << 20;
/// What is made of a file takes about this multiple of its text.
const PER_BYTE: usize = 4;

/// Attributes that every element of SSP may have.
const COMMON: &[&str] = &["id", "description"];

impl Gathered {
    /// The value, or `None` after recording the problem.
    pub(super) fn take<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|problem| self.problems.push(problem)).ok()
    }

    /// Refuses the system if so many more bytes are too many; `at` is what needs them.
    pub(super) fn spend(&mut self, bytes: usize, at: &Place) -> Result<()> {
        self.copied = self.copied.saturating_add(bytes);
        if self.copied <= MAX_COPIED {
            return Ok(());
        }
        let what = "the system takes too much memory";
        let why = "the files that it names, and the values, names and conversions that it uses \
                   repeatedly, take more than 512 MiB";
        Err(at
            .mark(Error::new(Code::Ssd, what))
            .why(why)
            .help("use large files and long names less often"))
    }

    /// The same for what is made of a file that is named at `at`.
    pub(super) fn spend_on(&mut self, file: &Path, at: &Place) -> Result<()> {
        let length = std::fs::metadata(file).map_or(0, |file| file.len());
        self.spend(usize::try_from(length).unwrap_or(usize::MAX).saturating_mul(PER_BYTE), at)
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
