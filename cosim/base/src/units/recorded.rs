//! Units in results files: a JSON object with names of variables and their units.

use std::collections::BTreeMap;

/// The key of the metadata in MCAP and Parquet.
pub const UNITS: &str = "cosim.units";

/// The text for names and units.
pub fn text<'a>(units: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    serde_json::to_string(&units.collect::<BTreeMap<_, _>>()).unwrap_or_default()
}

/// The unit of each name, empty if none is known.
pub fn read<'a>(text: &str, names: impl Iterator<Item = &'a String>) -> Vec<String> {
    let known: BTreeMap<String, String> = serde_json::from_str(text).unwrap_or_default();
    names.map(|name| known.get(name).cloned().unwrap_or_default()).collect()
}
