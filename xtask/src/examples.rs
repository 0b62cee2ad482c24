//! The commands in the documents are run as a reader would type them, and the library's example.

use crate::{paths, process, python};
use anyhow::{Context, Result};
use std::{fs, os::unix::fs::symlink, path::Path, process::Command};

/// Documents whose commands must work.
const DOCUMENTS: [&str; 2] = ["README.md", "examples/README.md"];

/// The programs whose commands are run: ours, and those of the Python environment of the tests, in which
/// the wheel is.
const PROGRAMS: [&str; 4] = ["cosim", "python", "jupyter", "sh"];

/// Runs the commands of the documents, in a folder under target/, and the example.
pub(crate) fn run() -> Result<()> {
    process::run(&mut process::build_cosim())?;
    let folder = paths::target().join("examples");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder)?;
    for name in ["examples", "target"] {
        symlink(paths::root().join(name), folder.join(name))?;
    }
    let path = std::env::var("PATH").unwrap_or_default();
    let python = python::TESTS.install()?;
    let path = format!("{}:{}:{path}", paths::target().join("release").display(), python.display());
    for document in DOCUMENTS {
        let text = fs::read_to_string(paths::root().join(document))
            .with_context(|| document.to_owned())?;
        for line in commands(&text) {
            process::run(
                Command::new("sh").args(["-ec", &line]).current_dir(&folder).env("PATH", &path),
            )
            .with_context(|| Path::new(document).display().to_string())?;
        }
    }
    // The library's example; it is built with all of the workspace.
    process::run(
        Command::new(paths::target().join("release/examples/campaign"))
            .args(["examples/paper.ssd", "1"])
            .current_dir(paths::root()),
    )
}

/// The commands in the shell blocks of a document; lines that end in a backslash go on.
fn commands(markdown: &str) -> Vec<String> {
    let mut commands = Vec::new();
    let mut in_shell = false;
    let joined = markdown.replace("\\\n", " ");
    for line in joined.lines() {
        match line.strip_prefix("```") {
            Some(language) => in_shell = language == "sh",
            None if in_shell && is_run(line) => commands.push(line.to_owned()),
            None => (),
        }
    }
    commands
}

/// Whether a line begins with one of the programs.
fn is_run(line: &str) -> bool {
    line.split_whitespace().next().is_some_and(|program| PROGRAMS.contains(&program))
}

#[cfg(test)]
mod tests {
    use super::commands;

    #[test]
    fn only_commands_in_shell_blocks_are_taken_and_lines_go_on() {
        let text = "cosim no\n```sh\ncosim a \\\n  b # why\ncargo c\n  python d\n```\n```text\ncosim no\n```\n";
        assert_eq!(commands(text), ["cosim a    b # why", "  python d"]);
    }
}
