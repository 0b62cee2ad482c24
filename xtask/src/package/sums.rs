//! SHA256SUMS beside what is packaged, as `sha256sum --check` reads it.

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};
use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

/// Name of the file.
pub(super) const NAME: &str = "SHA256SUMS";

/// Writes the sums of these files of a folder, by name.
pub(super) fn write(folder: &Path, files: &[PathBuf]) -> Result<()> {
    let mut lines = Vec::new();
    for file in files {
        let bytes = fs::read(file).with_context(|| file.display().to_string())?;
        let name = file.file_name().unwrap_or_default().display();
        let mut line = String::new();
        for byte in Sha256::digest(&bytes) {
            // Writing to a String cannot fail.
            let _ = write!(line, "{byte:02x}");
        }
        lines.push((name.to_string(), line));
    }
    lines.sort();
    let text: String = lines.iter().map(|(name, sum)| format!("{sum}  {name}\n")).collect();
    let file = folder.join(NAME);
    fs::write(&file, text).with_context(|| file.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn the_sums_are_those_that_sha256sum_finds_until_a_byte_changes() {
        let folder = tempfile::tempdir().unwrap();
        let files = ["b.fmu", "a.fmu"].map(|name| folder.path().join(name));
        for file in &files {
            fs::write(file, file.to_str().unwrap()).unwrap();
        }
        write(folder.path(), &files).unwrap();
        let text = fs::read_to_string(folder.path().join(NAME)).unwrap();
        assert!(text.find("a.fmu") < text.find("b.fmu") && text.lines().count() == 2, "{text}");
        let check = || {
            let mut command = Command::new("sha256sum");
            command.args(["--check", "--status", NAME]).current_dir(folder.path());
            command.status().unwrap().success()
        };
        assert!(check());
        fs::write(&files[1], "other").unwrap();
        assert!(!check());
    }
}
