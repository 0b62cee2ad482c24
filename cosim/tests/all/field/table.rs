//! The table of traits in the field names tests that exist, and all tests made for it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../../../docs/reference/traits.md");
/// The minimum number of traits in the table.
const TRAITS: usize = 40;
/// The folder of these tests, all of which the table must name.
const MADE_FOR_IT: [&str; 5] =
    ["field", "field::exchange", "field::files", "field::modes", "field::process"];

/// The file of a module of these tests.
fn file(module: &str) -> Option<PathBuf> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all");
    let place = tests.join(module.replace("::", "/"));
    [place.with_extension("rs"), place.join("mod.rs")].into_iter().find(|file| file.is_file())
}

/// The tests of a module, by their full names.
fn tests(module: &str) -> BTreeSet<String> {
    let text = file(module).map(|file| std::fs::read_to_string(file).unwrap()).unwrap_or_default();
    let named = text.split("#[test]\nfn ").skip(1).filter_map(|rest| rest.split_once('('));
    named.map(|(name, _)| format!("{module}::{name}")).collect()
}

/// The rows of the table: their tests.
fn rows() -> Vec<Vec<&'static str>> {
    let rows = PAGE.lines().filter(|line| line.starts_with("| ") && line.contains("::"));
    let cell = |row: &'static str| row.trim_end_matches([' ', '|']).rsplit_once("| ").unwrap().1;
    rows.map(|row| cell(row).split(", ").map(|name| name.trim_matches('`')).collect()).collect()
}

#[test]
fn each_trait_has_a_test_that_exists() {
    let rows = rows();
    assert!(rows.len() >= TRAITS, "{} traits", rows.len());
    for name in rows.into_iter().flatten() {
        let (module, _) = name.rsplit_once("::").unwrap_or((name, ""));
        assert!(tests(module).contains(name), "docs/reference/traits.md: there is no test {name}");
    }
}

#[test]
fn each_test_made_for_a_trait_is_in_the_table() {
    let named: BTreeSet<String> = rows().into_iter().flatten().map(str::to_owned).collect();
    for test in MADE_FOR_IT.iter().flat_map(|module| tests(module)) {
        assert!(named.contains(&test), "docs/reference/traits.md does not name {test}");
    }
}
