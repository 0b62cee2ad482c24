//! The `cargo` commands of the documents: running them would build everything again, so tasks are
//! parsed by the task runner itself, and packages, benches and examples are looked up.

use crate::Arguments;
use crate::supply::{array, metadata, text};
use anyhow::{Context, Result, bail};
use clap::Parser;
use std::collections::BTreeSet;

/// Valid arguments of `cargo` here.
pub(super) struct Commands {
    packages: BTreeSet<String>,
    /// Kind and name of each target: `bench distributed`.
    targets: BTreeSet<String>,
}

impl Commands {
    /// Asks cargo for the packages of the workspace and their targets.
    pub(super) fn known() -> Result<Self> {
        let metadata = metadata(&["--no-deps"])?;
        let (mut packages, mut targets) = (BTreeSet::new(), BTreeSet::new());
        for package in array(&metadata, "packages") {
            packages.insert(text(package, "name").to_owned());
            for target in array(package, "targets") {
                for kind in array(target, "kind") {
                    let kind = kind.as_str().unwrap_or_default();
                    targets.insert(format!("{kind} {}", text(target, "name")));
                }
            }
        }
        Ok(Self { packages, targets })
    }

    /// Fails if a line of the script begins with an invalid `cargo` command.
    pub(super) fn check(&self, script: &str) -> Result<()> {
        for line in script.replace("\\\n", " ").lines().filter(|line| line.starts_with("cargo ")) {
            let end = |word: &&str| !["&&", ";", "|"].contains(word) && !word.starts_with('#');
            let words: Vec<&str> = line.split_whitespace().take_while(end).collect();
            self.command(&words).with_context(|| format!("`{}`", words.join(" ")))?;
        }
        Ok(())
    }

    fn command(&self, words: &[&str]) -> Result<()> {
        if let [_, "xtask", ..] = words {
            return Arguments::try_parse_from(&words[1..]).map(|_| ()).map_err(Into::into);
        }
        for pair in words.windows(2) {
            let known = match pair[0] {
                "-p" => self.packages.contains(pair[1]),
                "--bench" | "--example" => {
                    self.targets.contains(&format!("{} {}", &pair[0][2..], pair[1]))
                }
                _ => true,
            };
            if !known {
                bail!("`{} {}` does not exist in this workspace", pair[0], pair[1]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_are_parsed_and_targets_looked_up() {
        let known = Commands::known().unwrap();
        let check = |script: &str| known.check(script);
        check("cargo xtask reproduce --seeds 20 # quick\necho cargo no\n").unwrap();
        check("cargo build --release -p cosim && cargo\ncargo bench -p cosim --bench chain")
            .unwrap();
        assert!(check("cargo xtask reproduse").is_err());
        assert!(check("cargo xtask reproduce \\\n --sedes 20").is_err());
        assert!(check("cargo build -p cosmi").is_err());
        assert!(check("cargo bench -p cosim --bench chian").is_err());
    }
}
