//! `cargo xtask sbom`: the crates in the shipped files, and those that build them, as CycloneDX in
//! JSON.
//!
//! From `cargo metadata` and the checksums of Cargo.lock. It contains neither a time nor a serial
//! number: the same sources give the same bytes. Rust's own library, which is in every binary, is
//! not listed.

use super::{array, metadata, text};
use crate::paths;
use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

/// The shipped files: the programs and libraries of the wheel and of the FMUs.
const SHIPPED: [&str; 6] =
    ["cosim", "cosim-proxy", "cosim-scripted", "cosim-system", "rexrov-fmu", "rexrov-smooth"];

/// The whole as a component.
const PROJECT: &str = "rexrov-fmi";

/// Writes target/sbom.cdx.json.
pub(crate) fn run() -> Result<()> {
    let lock = fs::read_to_string(paths::root().join("Cargo.lock")).context("Cargo.lock")?;
    let bom = bom(&metadata(&[])?, &checksums(&lock));
    let file = paths::target().join("sbom.cdx.json");
    fs::write(&file, format!("{bom:#}\n")).with_context(|| file.display().to_string())?;
    println!("{} crates in {}", array(&bom, "components").count(), file.display());
    Ok(())
}

/// SHA-256 of each crate of the registry, by name and version.
fn checksums(lock: &str) -> BTreeMap<(&str, &str), &str> {
    let package = |package| {
        let [name, version, sum] = ["name", "version", "checksum"].map(|key| value(package, key));
        Some(((name?, version?), sum?))
    };
    lock.split("[[package]]").filter_map(package).collect()
}

/// The text after `key = ` in a part of Cargo.lock.
fn value<'a>(part: &'a str, key: &str) -> Option<&'a str> {
    part.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = \"")?.strip_suffix('"'))
}

fn bom(metadata: &Value, checksums: &BTreeMap<(&str, &str), &str>) -> Value {
    let packages: BTreeMap<&str, &Value> =
        array(metadata, "packages").map(|package| (text(package, "id"), package)).collect();
    let uses: BTreeMap<&str, BTreeSet<&str>> = array(&metadata["resolve"], "nodes")
        .map(|node| (text(node, "id"), array(node, "deps").filter_map(shipped).collect()))
        .collect();
    let mut roots: Vec<&str> = packages
        .iter()
        .filter(|(_, package)| package["source"].is_null())
        .filter(|(_, package)| SHIPPED.contains(&text(package, "name")))
        .map(|(id, _)| *id)
        .collect();
    roots.sort_by_key(|id| purl(packages[id]));
    let (mut met, mut queue) = (BTreeSet::new(), roots.clone());
    while let Some(id) = queue.pop() {
        if met.insert(id) {
            queue.extend(uses[id].iter().copied());
        }
    }
    let mut met: Vec<&str> = met.into_iter().collect();
    met.sort_by_key(|id| purl(packages[id]));
    let named = |ids: &mut dyn Iterator<Item = &str>| -> Vec<String> {
        let mut names: Vec<String> = ids.map(|id| purl(packages[id])).collect();
        names.sort();
        names
    };
    let whole = json!({ "ref": PROJECT, "dependsOn": named(&mut roots.iter().copied()) });
    let others = met.iter().map(|id| {
        json!({
            "ref": purl(packages[id]),
            "dependsOn": named(&mut uses[id].iter().copied()),
        })
    });
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": { "component": {
            "type": "application",
            "bom-ref": PROJECT,
            "name": PROJECT,
            "version": env!("CARGO_PKG_VERSION"),
            "licenses": [{ "expression": "MIT OR Apache-2.0" }],
        } },
        "components": met.iter().map(|id| component(packages[id], checksums)).collect::<Vec<_>>(),
        "dependencies": std::iter::once(whole).chain(others).collect::<Vec<_>>(),
    })
}

/// The package of a dependency, if it is not only for tests.
fn shipped(dependency: &Value) -> Option<&str> {
    let mut kinds = array(dependency, "dep_kinds");
    kinds.any(|kind| kind["kind"] != "dev").then(|| text(dependency, "pkg"))
}

/// The name of a package in package URLs.
fn purl(package: &Value) -> String {
    format!("pkg:cargo/{}@{}", text(package, "name"), text(package, "version"))
}

fn component(package: &Value, checksums: &BTreeMap<(&str, &str), &str>) -> Value {
    let (name, version) = (text(package, "name"), text(package, "version"));
    // Before SPDX some wrote `MIT/Apache-2.0`.
    let license = text(package, "license").replace(" / ", "/").replace('/', " OR ");
    let mut component = json!({
        "type": "library",
        "bom-ref": purl(package),
        "name": name,
        "version": version,
        "purl": purl(package),
        "licenses": [{ "expression": license.trim() }],
    });
    if let Some(checksum) = checksums.get(&(name, version)) {
        component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
    }
    component
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_program_and_library_is_shipped_or_for_developers() {
        let metadata = metadata(&["--no-deps"]).unwrap();
        let binary = |target: &Value| array(target, "kind").any(|k| k == "bin" || k == "cdylib");
        let built = array(&metadata, "packages").filter(|p| array(p, "targets").any(binary));
        let mut built: Vec<&str> = built.map(|package| text(package, "name")).collect();
        built.retain(|name| !["clumsy", "depth-hold", "xtask"].contains(name));
        built.sort_unstable();
        assert_eq!(built, SHIPPED);
    }

    #[test]
    fn what_is_shipped_is_listed_with_checksums_and_what_tests_need_is_not() {
        let lock = fs::read_to_string(paths::root().join("Cargo.lock")).unwrap();
        let bom = bom(&metadata(&[]).unwrap(), &checksums(&lock));
        let listed: BTreeMap<&str, &Value> =
            array(&bom, "components").map(|part| (text(part, "bom-ref"), part)).collect();
        assert_eq!(listed.len(), array(&bom, "components").count(), "two of one name");
        let has = |name: &str| array(&bom, "components").any(|part| text(part, "name") == name);
        assert!(
            has("nalgebra")
                && has("zenoh")
                && has("fmu-kit-derive")
                && has("fmu-quantity")
                && has("cosim")
        );
        // Only for tests, or for the task runner.
        assert!(!has("proptest") && !has("fmi-rs") && !has("xtask"));
        for (name, part) in &listed {
            let ours =
                ["cosim", "fmu-", "rexrov"].iter().any(|own| text(part, "name").starts_with(own));
            assert_eq!(part["hashes"].is_null(), ours, "{name}");
            let license = text(&part["licenses"][0], "expression");
            assert!(!license.is_empty() && !license.contains('/'), "{name}: {license}");
        }
        for node in array(&bom, "dependencies") {
            for name in array(node, "dependsOn") {
                assert!(listed.contains_key(name.as_str().unwrap()), "{name}");
            }
        }
    }
}
