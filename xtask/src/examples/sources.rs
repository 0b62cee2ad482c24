//! Rust code in the documents must be part of a file that the compiler has seen.

use crate::paths;
use anyhow::{Context, Result, bail};
use std::{fs, path::Path};

/// Folders with sources.
const ROOMS: [&str; 5] = ["examples", "cosim", "fmu", "src", "tests"];

/// The texts of all source files, unchanged and without the slashes of doc comments.
pub(super) struct Sources(Vec<String>);

impl Sources {
    pub(super) fn read() -> Result<Self> {
        let mut texts = Vec::new();
        for room in ROOMS {
            collect(&paths::root().join(room), &mut texts)?;
        }
        Ok(Self(texts))
    }

    /// Fails if no file contains `code`.
    pub(super) fn must_have(&self, code: &str) -> Result<()> {
        match self.0.iter().any(|text| text.contains(code)) {
            true => Ok(()),
            false => bail!(
                "this Rust stands in no source file: write it where it is compiled (examples/, \
                 or a doc comment), and copy it from there"
            ),
        }
    }
}

/// A line with its line end, and, if it is a doc comment, its text.
fn without_slashes(line: &str) -> String {
    let said = ["///", "//!"].iter().find_map(|slashes| line.trim_start().strip_prefix(slashes));
    let line = said.map_or(line, |said| said.strip_prefix(' ').unwrap_or(said));
    format!("{line}\n")
}

fn collect(folder: &Path, texts: &mut Vec<String>) -> Result<()> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, texts)?;
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            texts.push(text.lines().map(without_slashes).collect());
            texts.push(text);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_of_files_and_of_their_documentation_is_known() {
        let sources = Sources::read().unwrap();
        sources.must_have("/// Where programs run.\n").unwrap_err();
        sources.must_have("fmu_kit::export!(Sampled<DepthSensor>);\n").unwrap();
        sources.must_have("    fn period_s(&self) -> f64 {\n        0.1\n    }\n").unwrap();
    }
}
