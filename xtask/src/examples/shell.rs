//! Blocks of shell and Python, run in a folder in which `examples/` and `target/` are as in the
//! root.

use crate::{paths, process};
use anyhow::{Context, Result, bail};
use std::{
    fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    process::Command,
};

/// Programs that are not run: they rebuild existing output, or change the machine.
const ELSEWHERE: &str = "cargo() { :; }; rustup() { :; }; pip() { :; }; ";

/// `--help` after a command makes `cosim` read its options and do nothing.
const SYNTAX: &str = "cosim() { command cosim \"$@\" --help > /dev/null; }; ";

/// The folder in which the blocks of one page run.
pub(super) struct Shell {
    folder: PathBuf,
    path: String,
}

impl Shell {
    /// An empty folder.
    pub(super) fn new(folder: &Path, python: &Path) -> Result<Self> {
        let _ = fs::remove_dir_all(folder);
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        for name in ["examples", "target"] {
            symlink(paths::root().join(name), folder.join(name))?;
        }
        let programs = python.parent().unwrap_or(Path::new("."));
        let (built, path) = (paths::target().join("release"), std::env::var("PATH"));
        let path = path.unwrap_or_default();
        let path = format!("{}:{}:{path}", built.display(), programs.display());
        Ok(Self { folder: folder.to_owned(), path })
    }

    /// Writes a file for the commands.
    pub(super) fn write(&self, name: &str, text: &str) -> Result<()> {
        fs::write(self.folder.join(name), text).with_context(|| name.to_owned())
    }

    /// Fails if a line of `text` is not a line of a file that the commands wrote.
    pub(super) fn must_show(&self, name: &str, text: &str) -> Result<()> {
        let file = self.folder.join(name);
        let written = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        match text.lines().find(|line| !written.lines().any(|other| other == *line)) {
            Some(line) => bail!("{name} has no line `{line}`; it is\n{written}"),
            None => Ok(()),
        }
    }

    /// Runs a script; it fails with its first failing command.
    pub(super) fn run(&self, script: &str, syntax_only: bool) -> Result<()> {
        let syntax = if syntax_only { SYNTAX } else { "" };
        let script = format!("{ELSEWHERE}{syntax}\n{script}");
        self.start(Command::new("sh").args(["-ec", &script]))
    }

    /// Runs a Python program.
    pub(super) fn python(&self, python: &Path, program: &str) -> Result<()> {
        self.start(Command::new(python).args(["-c", program]))
    }

    fn start(&self, command: &mut Command) -> Result<()> {
        command.current_dir(&self.folder).env("PATH", &self.path).env("MPLBACKEND", "Agg");
        process::quietly(command)
    }
}
