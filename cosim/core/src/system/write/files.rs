//! Where the FMUs of a written system are: in place, beside it, or in its package.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::unwritten;
use crate::system::System;
use crate::system::read::SSD_FILE;
use crate::system::read::write_source;
use cosim_base::error::Result;
use cosim_base::files::copy;
use cosim_import::archive::{self, Content};

/// Sources of the components and the files to be copied.
pub(super) struct Files {
    /// By position of the component.
    sources: BTreeMap<usize, String>,
    /// New names, relative to the written file, and the original files.
    copies: BTreeMap<String, PathBuf>,
}

impl Files {
    /// Every FMU gets a name in `folder` of the package.
    pub(super) fn packed(system: &System, folder: &str) -> Self {
        let mut files = Self { sources: BTreeMap::new(), copies: BTreeMap::new() };
        for (component, path) in system.fmus() {
            let name = files.add(path, folder);
            files.sources.insert(component, name);
        }
        files
    }

    /// FMUs stay where they are; those in a temporary unpacked archive are copied.
    pub(super) fn beside(system: &System, folder: &Path) -> Result<Self> {
        fs::create_dir_all(folder).map_err(|e| unwritten(folder, e))?;
        let mut files = Self { sources: BTreeMap::new(), copies: BTreeMap::new() };
        for (component, path) in system.fmus() {
            let source = match system.archives().any(|archive| path.starts_with(archive)) {
                true => files.add(path, "resources/"),
                false => write_source(path, folder),
            };
            files.sources.insert(component, source);
        }
        Ok(files)
    }

    /// The source of a component.
    pub(super) fn source(&self, component: usize) -> &str {
        self.sources.get(&component).map_or("", String::as_str)
    }

    /// The files with new names.
    pub(super) fn into_copies(self) -> Vec<(String, PathBuf)> {
        self.copies.into_iter().collect()
    }

    /// The new name of a file: plain characters, and unique.
    fn add(&mut self, path: &Path, folder: &str) -> String {
        if let Some((name, _)) = self.copies.iter().find(|(_, file)| *file == path) {
            return name.clone();
        }
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let stem: String = stem.chars().map(plain).collect();
        let mut name = format!("{folder}{stem}.fmu");
        let mut count = 1;
        while self.copies.contains_key(&name) {
            count += 1;
            name = format!("{folder}{stem}_{count}.fmu");
        }
        self.copies.insert(name.clone(), path.to_owned());
        name
    }

    /// Copies files with new names into `folder`.
    pub(super) fn copy(&self, folder: &Path) -> Result<()> {
        for (name, from) in &self.copies {
            let to = folder.join(name);
            if let Some(parent) = to.parent() {
                fs::create_dir_all(parent).map_err(|e| unwritten(parent, e))?;
            }
            copy(from, &to).map_err(|e| unwritten(&to, e))?;
        }
        Ok(())
    }

    /// Writes the package: the description first, then the unchanged FMUs. The same system gives
    /// the same bytes.
    pub(super) fn pack(&self, path: &Path, description: &[u8]) -> Result<()> {
        let fmus = self.copies.iter();
        let fmus = fmus.map(|(name, from)| (name.as_str(), Content::Compressed(from)));
        let entries = std::iter::once((SSD_FILE, Content::Bytes(description))).chain(fmus);
        archive::write(path, entries).map_err(|e| unwritten(path, e))
    }
}
