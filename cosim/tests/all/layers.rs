//! The structure that ARCHITECTURE.md describes: which module may use which, and what the libraries
//! inside written FMUs are built from.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The re-exports at the root of the crate, by the module that defines them.
const ROOT: [(&str, &[&str]); 5] = [
    ("error", &["Code", "Error", "Result"]),
    ("master", &["Controls", "Manipulator", "Run", "Snapshot", "Summary"]),
    ("observe", &["Observer", "Recording"]),
    ("system", &["Algorithm", "Input", "Overrides", "System"]),
    ("time", &["Step", "Time"]),
];

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The layer of each module, from ARCHITECTURE.md.
fn layers() -> BTreeMap<String, usize> {
    let text = std::fs::read_to_string(folder().join("../ARCHITECTURE.md")).unwrap();
    let section = text.split("## Modules of `cosim`").nth(1).unwrap();
    let block = section.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
    let lines = block.lines().enumerate();
    lines
        .flat_map(|(layer, line)| line.split(' ').map(move |name| (name.to_owned(), layer)))
        .collect()
}

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // Unit tests may use what they like.
        if path.is_dir() && !path.ends_with("tests") {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            into.push(path);
        }
    }
}

/// The modules that a source names after `crate::`.
fn used(text: &str) -> Vec<String> {
    let production = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code = production.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code = code.collect::<Vec<_>>().join("\n");
    let name = |text: &str| {
        let name: String =
            text.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let module = ROOT.iter().find(|(_, names)| names.contains(&&*name));
        module.map_or(name, |(module, _)| (*module).to_owned())
    };
    let after = code.split("crate::").skip(1);
    after
        .flat_map(|rest| match rest.strip_prefix('{') {
            Some(list) => list.split('}').next().unwrap().split(',').map(name).collect(),
            None => vec![name(rest)],
        })
        .filter(|name| !name.is_empty())
        .collect()
}

#[test]
fn each_module_uses_only_modules_above_its_own() {
    let layers = layers();
    let mut files = Vec::new();
    sources(&folder().join("src"), &mut files);
    let mut wrong = Vec::new();
    for file in files {
        let place = file.strip_prefix(folder().join("src")).unwrap();
        let top = place.components().next().unwrap().as_os_str().to_str().unwrap();
        let module = top.trim_end_matches(".rs");
        if ["lib", "main"].contains(&module) {
            continue;
        }
        let own = *layers.get(module).unwrap_or_else(|| panic!("{module} is in no layer"));
        for other in used(&std::fs::read_to_string(&file).unwrap()) {
            if layers.get(&other).is_some_and(|layer| *layer >= own && other != module) {
                wrong.push(format!("{}: {other}", place.display()));
            }
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
}

#[test]
fn libraries_of_written_fmus_do_without_what_only_the_program_needs() {
    for library in ["cosim-system", "cosim-proxy", "cosim-scripted"] {
        let tree =
            ["tree", "--locked", "--package", library, "--edges", "normal", "--prefix", "none"];
        let done = Command::new(env!("CARGO")).args(tree).current_dir(folder()).output().unwrap();
        let text = String::from_utf8(done.stdout).unwrap();
        let mut crates: Vec<&str> =
            text.lines().filter_map(|line| line.split(' ').next()).collect();
        crates.sort_unstable();
        crates.dedup();
        for name in ["clap", "indicatif", "mcap", "minijinja", "parquet", "plotters", "zenoh"] {
            assert!(!crates.contains(&name), "{library} has {name}");
        }
        assert!((20..=60).contains(&crates.len()), "{library}: {} crates", crates.len());
    }
}
