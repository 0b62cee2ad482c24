//! Merging: FMUs of one component built on several machines become one FMU for all of them.

use super::{archive, library::Library, platform};
use anyhow::{Context, Result, bail, ensure};
use std::{
    collections::{BTreeMap, BTreeSet},
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

/// Merges the FMUs of the same name in `folders` and writes them to `output`; returns their paths.
pub(crate) fn folders(folders: &[PathBuf], output: &Path) -> Result<Vec<PathBuf>> {
    let mut names = BTreeSet::new();
    for folder in folders {
        names.extend(fmus(folder)?);
    }
    ensure!(!names.is_empty(), "there is no FMU in the folders to merge");
    let mut merged = Vec::new();
    for name in names {
        let sources: Vec<PathBuf> = folders.iter().map(|folder| folder.join(&name)).collect();
        let shown = name.display();
        let archives = sources
            .iter()
            .map(|path| Ok((path.display().to_string(), archive::read(path)?)))
            .collect::<Result<Vec<_>>>()
            .with_context(|| format!("{shown} must be in every folder"))?;
        let files = union(archives).with_context(|| format!("cannot merge {shown}"))?;
        merged.push((output.join(&name), files));
    }
    fs::create_dir_all(output)?;
    merged.into_iter().map(|(path, files)| archive::write(&path, &files).map(|()| path)).collect()
}

fn fmus(folder: &Path) -> Result<Vec<OsString>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if let (Some("fmu"), Some(name)) =
            (path.extension().and_then(|e| e.to_str()), path.file_name())
        {
            names.push(name.to_owned());
        }
    }
    Ok(names)
}

/// All files of several archives. Only libraries of different platforms may be in one and not in
/// another; files with the same name must be equal.
fn union(archives: Vec<(String, Vec<archive::Entry>)>) -> Result<Vec<archive::Entry>> {
    let common = |name: &str| !name.starts_with("binaries/");
    let mut files: Vec<archive::Entry> = Vec::new();
    let mut origin: BTreeMap<String, String> = BTreeMap::new();
    let mut first: Option<(String, BTreeSet<String>)> = None;
    for (source, entries) in archives {
        let names = entries.iter().filter(|(name, _)| common(name)).map(|(name, _)| name.clone());
        let names: BTreeSet<String> = names.collect();
        if let Some((other, expected)) = &first {
            if let Some(name) = expected.symmetric_difference(&names).next() {
                bail!("only one of {other} and {source} holds {name}");
            }
        } else {
            first = Some((source.clone(), names));
        }
        for (name, bytes) in entries {
            if !common(&name) {
                check(&name, &bytes).with_context(|| format!("{name} in {source}"))?;
            }
            match files.iter().find(|(present, _)| *present == name) {
                None => {
                    origin.insert(name.clone(), source.clone());
                    files.push((name, bytes));
                }
                Some((_, present)) if *present == bytes => (),
                Some(_) => bail!("{}", conflict(&name, &origin[&name], &source)),
            }
        }
    }
    // Files common to all platforms keep their order, and the libraries follow the description.
    let at = files.iter().position(|(name, _)| !common(name)).unwrap_or(files.len());
    let (mut libraries, mut rest): (Vec<_>, Vec<_>) =
        files.into_iter().partition(|(name, _)| !common(name));
    libraries.sort_by(|(a, _), (b, _)| a.cmp(b));
    rest.splice(at..at, libraries);
    Ok(rest)
}

/// A library must be in the folder of its machine, under the name that importers look for.
fn check(name: &str, bytes: &[u8]) -> Result<()> {
    let folder = name.split('/').nth(1).unwrap_or_default();
    Library::read(bytes)?.check(platform::named(folder)?)?;
    let suffix = fmu_kit::package::suffix(folder);
    ensure!(name.ends_with(suffix), "libraries in binaries/{folder} end in {suffix}");
    Ok(())
}

fn conflict(name: &str, one: &str, other: &str) -> String {
    let hint = match name {
        "modelDescription.xml" => {
            "they are of different versions of the component, with other GUIDs"
        }
        name if name.starts_with("binaries/") => "both are for one platform: take one of them",
        _ => "build both from the same sources",
    };
    format!("{name} differs between {one} and {other}; {hint}")
}
