//! Files that must be refused, through the real binary: each with exit code 3 and the entry or line
//! named, in bounded time and memory, with nothing written outside and nothing left behind.

mod archives;
mod descriptions;
mod endless;
mod floods;
mod outputs;
mod parquet;
mod shown;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::command::text;
use crate::models::Model;
use crate::rawzip::{Entry, archive};

/// Address space of the binary in KiB, and processor time in seconds: with more it is killed.
const MEMORY: u32 = 3 << 20;
const TIME: u32 = 60;

/// A folder with the file to open and its own temporary folder.
pub(crate) struct Workspace {
    folder: TempDir,
}

impl Workspace {
    pub(crate) fn new() -> Self {
        let folder = TempDir::new().unwrap();
        std::fs::create_dir_all(folder.path().join("a/b/temporary")).unwrap();
        Self { folder }
    }

    /// A file beside the one to open.
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join("a/b").join(name)
    }

    /// Writes it.
    pub(crate) fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// Runs `cosim VERB FILE` for a file of these bytes: exit code and stderr.
    pub(crate) fn run(&self, verb: &str, name: &str, bytes: &[u8]) -> (i32, String) {
        self.run_in(MEMORY, verb, name, bytes)
    }

    /// The same with a different memory limit, in KiB.
    pub(crate) fn run_in(
        &self,
        memory: u32,
        verb: &str,
        name: &str,
        bytes: &[u8],
    ) -> (i32, String) {
        let inside = self.folder.path().join("a/b");
        std::fs::write(inside.join(name), bytes).unwrap();
        let before = self.files();
        let limit = format!("ulimit -v {memory}; ulimit -t {TIME}; exec \"$@\"");
        let output = Command::new("sh")
            .args(["-c", &limit, "sh", env!("CARGO_BIN_EXE_cosim")])
            .args(verb.split(' '))
            .arg(name)
            .current_dir(&inside)
            .env("TMPDIR", inside.join("temporary"))
            .env("NO_COLOR", "1")
            .stdin(Stdio::null())
            .output()
            .unwrap();
        assert_eq!(self.files(), before, "{name}");
        let code = output.status.code();
        let shown = text(&output.stderr);
        (code.unwrap_or_else(|| panic!("{}: {shown}", output.status)), shown)
    }

    /// Every file and folder, to check that nothing was added.
    fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, found: &mut Vec<String>) {
            for entry in std::fs::read_dir(folder).unwrap().flatten() {
                found.push(entry.path().display().to_string());
                if entry.file_type().unwrap().is_dir() {
                    walk(&entry.path(), found);
                }
            }
        }
        let mut found = Vec::new();
        walk(self.folder.path(), &mut found);
        found.sort();
        found
    }

    fn refuses(&self, name: &str, bytes: &[u8], parts: &[&str]) {
        let (code, shown) = self.run("info", name, bytes);
        assert_eq!(code, 3, "{name}: {shown}");
        for part in parts {
            assert!(shown.contains(part), "{name}: {part} in {}", &shown[..shown.len().min(2000)]);
        }
        assert!(!shown.contains("panicked"), "{name}: {shown}");
    }
}

/// An archive whose description is `text`.
pub(crate) fn described(text: impl AsRef<[u8]>) -> Vec<u8> {
    archive(&[Entry::new("modelDescription.xml", text.as_ref())])
}

pub(crate) fn with_variables(variables: &str) -> String {
    let all = Model::Gain.description();
    all.replace("<ModelVariables>", &format!("<ModelVariables>{variables}"))
}
