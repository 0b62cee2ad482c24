//! The contents of an FMU: in addition to the kit's files, text and plot of the documentation, the
//! icon, licences and the reference run.

use super::{archive::Entry, icon, page, reference};
use crate::{paths, process};
use anyhow::{Context, Error, Result};
use fmu_kit::kernel;
use std::fs;

/// The folder of results in the Reference FMUs of the Modelica Association.
const REFERENCE: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// The files of one component, with the library for each platform.
pub(crate) fn of(component: &kernel::Entry, libraries: &[Entry]) -> Result<Vec<Entry>> {
    let name = component.info().name;
    let run = reference::run(component)?;
    let text = source(&format!("{name}.md"))?;
    let chapters = page::chapters(component, &text, &run).with_context(|| format!("{name}.md"))?;
    let icon =
        icon::png(&source(&format!("{name}.svg"))?).with_context(|| format!("{name}.svg"))?;
    let mut files = fmu_kit::package::fmu(component, libraries, &chapters).map_err(Error::msg)?;
    files.push(("model.png".to_owned(), icon));
    files.push((format!("{REFERENCE}/fmi-ls-manifest.xml"), run.manifest(name).into_bytes()));
    if let Some(inputs) = run.inputs.csv() {
        files.push((format!("{REFERENCE}/{name}_in.csv"), inputs.into_bytes()));
    }
    if let Some(outputs) = run.outputs.csv() {
        files.push((format!("{REFERENCE}/{name}_out.csv"), outputs.into_bytes()));
    }
    Ok(files)
}

/// The author's files for a component: its text with equations, its drawing. A line `{{file}}`
/// stands for that file, which several components share.
pub(crate) fn source(file: &str) -> Result<String> {
    let path = paths::root().join("fmu/components/documentation").join(file);
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut whole = String::new();
    for line in text.lines() {
        match line.strip_prefix("{{").and_then(|rest| rest.strip_suffix("}}")) {
            Some(shared) => whole.push_str(&source(shared)?),
            None => whole.push_str(line),
        }
        whole.push('\n');
    }
    Ok(whole)
}

/// The licences: an entry page, ours, and the linked crates with their terms.
pub(crate) fn licenses() -> Result<Vec<Entry>> {
    let folder = "documentation/licenses";
    let mut files =
        vec![(format!("{folder}/license.txt"), summary("This FMU", "rexrov-fmu")?.into_bytes())];
    for license in ["LICENSE-APACHE", "LICENSE-MIT"] {
        files.push((format!("{folder}/{license}"), fs::read(paths::root().join(license))?));
    }
    Ok(files)
}

/// Our terms, and the crates linked into a package's library.
pub(crate) fn summary(what: &str, package: &str) -> Result<String> {
    Ok(format!(
        "{what} is licensed under MIT or Apache-2.0, at your option:\n\
         see LICENSE-MIT and LICENSE-APACHE in this folder.\n\n\
         Its library contains {}",
        linked(package)?
    ))
}

/// The crates linked into a package's library or program, with their terms, from cargo.
pub(crate) fn linked(package: &str) -> Result<String> {
    let tree = ["tree", "-p", package, "--edges", "normal,no-proc-macro", "--prefix", "none"];
    let tree = process::output(process::cargo(&tree).args(["--format", "{p}\t{l}"]))?;
    let mut crates: Vec<String> = tree
        .lines()
        // Crates of this workspace are shown with their folder.
        .filter(|line| !line.contains('(') && !line.trim().is_empty())
        .map(|line| line.replace('\t', "  "))
        .collect();
    crates.sort();
    crates.dedup();
    Ok(format!(
        "the Rust standard library (MIT OR Apache-2.0) and these crates:\n\n{}\n",
        crates.join("\n")
    ))
}
