//! The structure that ARCHITECTURE.md describes: which crate and which module may use which, and what
//! each crate must do without.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The re-exports at the root of the core, by the module that defines them.
const ROOT: [(&str, &[&str]); 4] = [
    ("master", &["Controls", "Manipulator", "Run", "Snapshot", "Summary"]),
    ("observe", &["Observer", "Recording"]),
    ("pace", &["Overruns", "Pace"]),
    ("system", &["Algorithm", "Input", "Overrides", "System"]),
];

/// Dependencies that only some crates may have, with the lowest of them.
const ONLY_FROM: [(&str, &str); 9] = [
    ("clap", "cosim"),
    ("indicatif", "cosim"),
    ("landlock", "cosim-confine"),
    ("maud", "cosim-report"),
    ("mcap", "cosim-results"),
    ("nalgebra", "cosim-campaign"),
    ("parquet", "cosim-results"),
    ("plotters", "cosim-report"),
    ("zenoh", "cosim-net"),
];

/// The most crates, its own included, that each library inside a written FMU is built from.
const MOST: [(&str, usize); 3] =
    [("cosim-system", 45), ("cosim-proxy", 40), ("cosim-scripted", 40)];

/// The most public modules and items (types, traits, functions, constants) of the core.
const MODULES: usize = 6;
const ITEMS: usize = 150;

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn section(title: &str) -> String {
    let text = std::fs::read_to_string(folder().join("../ARCHITECTURE.md")).unwrap();
    text.split(title).nth(1).unwrap().to_owned()
}

fn block(section: &str) -> &str {
    section.split("```text\n").nth(1).unwrap().split("```").next().unwrap()
}

/// The layer of each crate.
fn crates() -> BTreeMap<String, usize> {
    let section = section("## Crates of `cosim`");
    let lines = block(&section).lines().enumerate();
    lines
        .flat_map(|(layer, line)| line.split(' ').map(move |name| (name.to_owned(), layer)))
        .collect()
}

/// The layer of each module, by crate.
fn layers() -> BTreeMap<String, BTreeMap<String, usize>> {
    let section = section("### Modules within them");
    let mut all: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for (layer, line) in block(&section).lines().enumerate() {
        let (name, modules) = line.split_once(": ").unwrap();
        let of = all.entry(name.to_owned()).or_default();
        of.extend(modules.split(' ').map(|module| (module.to_owned(), layer)));
    }
    all
}

fn cargo(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO"));
    let done = command.args(arguments).arg("--locked").current_dir(folder()).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

/// The names of all crates that a crate is built from.
fn built_from(name: &str) -> BTreeSet<String> {
    let text = cargo(&["tree", "--package", name, "--edges", "normal", "--prefix", "none"]);
    text.lines().filter_map(|line| Some(line.split(' ').next()?.to_owned())).collect()
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

/// The code of a source without comments and unit tests.
fn code(file: &Path) -> String {
    let text = std::fs::read_to_string(file).unwrap();
    let production = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code = production.lines().filter(|line| !line.trim_start().starts_with("//"));
    code.collect::<Vec<_>>().join("\n")
}

/// The modules that a source names after `crate::`.
fn used(code: &str) -> Vec<String> {
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
fn each_crate_uses_those_above_it_that_the_table_lists() {
    let layers = crates();
    let section = section("## Crates of `cosim`");
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `cosim"));
    let rows = rows.map(|row| {
        let cells: Vec<&str> = row.split(" | ").collect();
        let name = format!("cosim{}", cells[0].trim_end_matches('`'));
        let uses = cells[2].trim_end_matches(" |").split(", ");
        (name, uses.map(str::to_owned).collect::<BTreeSet<_>>())
    });
    let listed: BTreeMap<String, BTreeSet<String>> = rows.take(layers.len()).collect();
    let text = cargo(&["metadata", "--format-version", "1", "--no-deps"]);
    let metadata: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut found = BTreeMap::new();
    for package in metadata["packages"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        if !name.starts_with("cosim") {
            continue;
        }
        let normal =
            package["dependencies"].as_array().unwrap().iter().filter(|d| d["kind"].is_null());
        let ours = normal.filter(|dependency| dependency["path"].is_string());
        let uses: BTreeSet<String> =
            ours.map(|dependency| dependency["name"].as_str().unwrap().to_owned()).collect();
        let own = layers[name];
        let wrong: Vec<&String> =
            uses.iter().filter(|other| layers.get(*other).is_some_and(|l| *l >= own)).collect();
        assert_eq!(wrong, Vec::<&String>::new(), "of {name}");
        found.insert(name.to_owned(), uses);
    }
    assert_eq!(found, listed);
}

#[test]
fn each_module_uses_only_modules_above_its_own() {
    let mut wrong = Vec::new();
    for (name, layers) in layers() {
        let source = folder().join(&name).join("src");
        let mut files = Vec::new();
        sources(&source, &mut files);
        for file in files {
            let place = file.strip_prefix(&source).unwrap();
            let top = place.components().next().unwrap().as_os_str().to_str().unwrap();
            let module = top.trim_end_matches(".rs");
            if module == "lib" {
                continue;
            }
            let own = *layers.get(module).unwrap_or_else(|| panic!("{module} is in no layer"));
            for other in used(&code(&file)) {
                if layers.get(&other).is_some_and(|layer| *layer >= own && other != module) {
                    wrong.push(format!("{name}: {}: {other}", place.display()));
                }
            }
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
}

#[test]
fn what_only_some_crates_need_is_in_no_crate_below() {
    for name in crates().into_keys().filter(|name| name != "cosim") {
        let all = built_from(&name);
        for (dependency, lowest) in ONLY_FROM {
            let allowed = name == lowest || all.contains(lowest);
            assert!(allowed || !all.contains(dependency), "{name} has {dependency}");
        }
    }
    let without = ["tree", "--package", "cosim", "--no-default-features", "--edges", "normal"];
    let without = cargo(&[&without[..], &["--prefix", "none"]].concat());
    for dependency in ["zenoh", "resvg"] {
        assert!(!without.contains(dependency), "cosim without its features has {dependency}");
    }
}

#[test]
fn libraries_of_written_fmus_are_built_from_few_crates() {
    for (library, most) in MOST {
        let all = built_from(library);
        assert!((20..=most).contains(&all.len()), "{library}: {} crates: {all:?}", all.len());
    }
}

#[test]
fn the_public_surface_of_the_core_is_small() {
    let source = folder().join("core/src");
    let root = std::fs::read_to_string(source.join("lib.rs")).unwrap();
    assert!(root.matches("\npub mod ").count() <= MODULES, "{root}");
    let mut files = Vec::new();
    sources(&source, &mut files);
    let kinds = ["fn ", "const ", "struct ", "enum ", "trait ", "type ", "static "];
    let is_item = |line: &str| {
        line.strip_prefix("pub ").is_some_and(|rest| kinds.iter().any(|k| rest.starts_with(k)))
    };
    let items: usize =
        files.iter().map(|file| code(file).lines().filter(|line| is_item(line)).count()).sum();
    assert!((50..=ITEMS).contains(&items), "{items} public items");
}
