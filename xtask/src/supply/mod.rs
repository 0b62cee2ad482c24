//! The dependencies of the project, and its published parts.
//!
//! | file | contents |
//! |---|---|
//! | `deny` | licences, sources and known vulnerabilities of the dependencies, by `deny.toml` |
//! | `sbom` | the list of all crates in the shipped files |
//! | `publish` | the crates that others can depend on, as packages |

pub(crate) mod deny;
pub(crate) mod publish;
pub(crate) mod sbom;

use crate::process;
use anyhow::{Context, Result};
use serde_json::Value;

/// The `cargo metadata` of this workspace.
pub(crate) fn metadata(arguments: &[&str]) -> Result<Value> {
    let arguments = [&["metadata", "--format-version", "1"], arguments].concat();
    serde_json::from_str(&process::output(&mut process::cargo(&arguments))?)
        .context("cargo metadata")
}

/// The elements of an array; none if it is missing.
pub(crate) fn array<'a>(value: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    value[key].as_array().into_iter().flatten()
}

/// A string; empty if it is missing.
pub(crate) fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}
