//! The committed model descriptions: generated from the components, never edited.

use crate::paths;
use anyhow::{Context, Result, anyhow, bail};
use fmu_kit::kernel::Entry;
use std::{fs, path::PathBuf};

/// Writes `modelDescription/<name>.xml` of every component.
pub(crate) fn write() -> Result<()> {
    for entry in rexrov_fmu::REGISTRY.entries() {
        let path = path(entry);
        fs::write(&path, text(entry)?).with_context(|| path.display().to_string())?;
        println!("{}", path.display());
    }
    Ok(())
}

/// Fails when a committed description is not what its component says.
pub(crate) fn check() -> Result<()> {
    let mut stale = Vec::new();
    for entry in rexrov_fmu::REGISTRY.entries() {
        let path = path(entry);
        if fs::read_to_string(&path).ok().as_deref() != Some(&text(entry)?) {
            stale.push(path.display().to_string());
        }
    }
    if !stale.is_empty() {
        bail!(
            "{} differ from the components: run `cargo xtask describe` and commit the result",
            stale.join(", ")
        );
    }
    Ok(())
}

/// The text of a component's modelDescription.xml.
pub(crate) fn text(entry: &Entry) -> Result<String> {
    entry.describe().map_err(|reason| anyhow!(reason))
}

fn path(entry: &Entry) -> PathBuf {
    paths::root().join("modelDescription").join(format!("{}.xml", entry.info().name))
}
