//! The crates that others can depend on: those whose Cargo.toml does not forbid publishing.

use super::{array, metadata, text};
use crate::process;
use anyhow::Result;

/// Packs them as for the registry, without compiling what was packed.
pub(crate) fn check() -> Result<()> {
    let mut arguments: Vec<String> =
        ["package", "--quiet", "--no-verify", "--allow-dirty"].map(str::to_owned).into();
    for name in crates()? {
        arguments.extend(["--package".to_owned(), name]);
    }
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    process::run(&mut process::cargo(&arguments))
}

fn crates() -> Result<Vec<String>> {
    let metadata = metadata(&["--no-deps"])?;
    let published = array(&metadata, "packages").filter(|package| package["publish"].is_null());
    Ok(published.map(|package| text(package, "name").to_owned()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paths;
    use std::{fs, path::Path};

    #[test]
    fn what_can_be_published_says_what_it_is_and_names_no_file_outside() {
        let metadata = metadata(&["--no-deps"]).unwrap();
        let mut names = crates().unwrap();
        names.sort();
        let known = [
            "cosim",
            "cosim-base",
            "cosim-campaign",
            "cosim-confine",
            "cosim-core",
            "cosim-import",
            "cosim-net",
            "cosim-pack",
            "cosim-report",
            "cosim-results",
            "fmu-kit",
            "fmu-kit-derive",
            "fmu-ode",
            "fmu-quantity",
            "fmu-standard",
            "rexrov",
        ];
        assert_eq!(names, known);
        for package in array(&metadata, "packages") {
            let name = text(package, "name");
            assert_eq!(text(package, "version"), env!("CARGO_PKG_VERSION"), "{name}");
            assert!(!text(package, "rust_version").is_empty(), "{name}");
            if !names.iter().any(|known| known == name) {
                continue;
            }
            for key in ["description", "license", "readme"] {
                assert!(!text(package, key).is_empty(), "{name} has no {key}");
            }
            let folder = Path::new(text(package, "manifest_path")).parent().unwrap();
            assert!(folder.join(text(package, "readme")).is_file(), "{name}");
            no_file_outside(&folder.join("src"), folder);
        }
    }

    /// `include_str!` of a file that is not packed compiles only here.
    fn no_file_outside(source: &Path, package: &Path) {
        for entry in fs::read_dir(source).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                no_file_outside(&path, package);
                continue;
            }
            if path.extension().is_none_or(|ending| ending != "rs") {
                continue;
            }
            let text = fs::read_to_string(&path).unwrap();
            for part in text.split("include_str!(\"").skip(1) {
                let name = part.split('"').next().unwrap();
                let depth = path.parent().unwrap().strip_prefix(package).unwrap().iter().count();
                let up = Path::new(name).iter().filter(|part| *part == "..").count();
                let shown = path.strip_prefix(paths::root()).unwrap().display();
                assert!(up <= depth, "{shown} includes {name}");
            }
        }
    }
}
