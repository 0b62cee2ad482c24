//! Running other programs: commands are shown as typed, and their failure is ours.

use anyhow::{Context, Result, bail};
use std::process::Command;

/// Runs `command` and fails if it fails.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    let shown = shown(command);
    eprintln!("$ {shown}");
    let status = command.status().with_context(|| format!("cannot start `{shown}`"))?;
    if !status.success() {
        bail!("`{shown}` ended with {status}");
    }
    Ok(())
}

/// Runs `command` and shows its output only if it fails.
pub(crate) fn quietly(command: &mut Command) -> Result<()> {
    let output = command.output().with_context(|| format!("cannot start `{}`", shown(command)))?;
    if !output.status.success() {
        let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
        bail!("ended with {}\n{out}{err}", output.status);
    }
    Ok(())
}

/// Runs `command` and returns its output.
pub(crate) fn output(command: &mut Command) -> Result<String> {
    let shown = shown(command);
    let output = command.output().with_context(|| format!("cannot start `{shown}`"))?;
    if !output.status.success() {
        let reason = String::from_utf8_lossy(&output.stderr);
        bail!("`{shown}` ended with {}: {reason}", output.status);
    }
    String::from_utf8(output.stdout).with_context(|| format!("`{shown}` prints no text"))
}

/// `cargo` as it runs us, in the workspace root, sharing its target folder, with the dependencies of
/// Cargo.lock and no others.
pub(crate) fn cargo(arguments: &[&str]) -> Command {
    let mut command = unlocked(&[LOCKED]);
    command.args(arguments);
    command
}

/// Cargo's option that fails rather than change Cargo.lock.
pub(crate) const LOCKED: &str = "--locked";

/// The same for a command that writes Cargo.lock.
///
/// Without the variables that `cargo run` sets for our own package: otherwise build scripts that
/// read them (of `ring`) would run again, and everything that needs them would be rebuilt, whenever
/// `cargo` is called by hand in between.
pub(crate) fn unlocked(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    let own = |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
    for (name, _) in std::env::vars_os() {
        if name.to_str().is_some_and(own) {
            command.env_remove(name);
        }
    }
    command
        .args(arguments)
        .current_dir(super::paths::root())
        .env("CARGO_TARGET_DIR", super::paths::target());
    command
}

/// Builds everything, including the programs. The whole workspace is named because the features of
/// its dependencies follow from that: nothing built for the tests is built again with other
/// features.
pub(crate) fn build_workspace() -> Command {
    cargo(&["build", "--release", "--quiet", "--workspace", "--lib", "--bins", "--examples"])
}

fn shown(command: &Command) -> String {
    let program = std::path::Path::new(command.get_program());
    let name = program.file_name().unwrap_or(program.as_os_str()).to_string_lossy();
    std::iter::once(name)
        .chain(command.get_args().map(|argument| argument.to_string_lossy()))
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// The dependencies of a selection of crates, each with its features.
    fn dependencies(selection: &[&str]) -> BTreeSet<String> {
        let form = ["tree", "--prefix", "none", "--format", "{p} {f}"];
        let tree = output(&mut cargo(&[&form[..], selection].concat())).unwrap();
        let foreign = tree.lines().filter(|line| !line.contains('/'));
        foreign.map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
    }

    /// Otherwise Zenoh, and much else, would be built once for each selection.
    #[test]
    fn the_program_alone_has_the_dependencies_of_the_workspace() {
        let whole = dependencies(&["--workspace", "--edges", "normal,build,dev"]);
        let alone = dependencies(&["--package", "cosim", "--edges", "normal,build"]);
        let other: Vec<_> = alone.difference(&whole).collect();
        assert!(other.is_empty(), "with other features in the workspace: {other:#?}");
        assert!(alone.iter().any(|name| name.starts_with("zenoh ")), "{alone:#?}");
    }
}
