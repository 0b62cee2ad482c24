//! The declarations of a committed modelDescription.xml.

use std::collections::BTreeMap;

/// The kind of each declared pair of unknown and known, as indices of variables from zero.
pub(crate) type Declared = BTreeMap<(usize, usize), String>;

fn attribute<'a>(line: &'a str, name: &str) -> &'a str {
    let start = line.find(&format!(" {name}=\"")).map(|at| at + name.len() + 3);
    start.map_or("", |start| line[start..].split('"').next().unwrap())
}

/// A list of the model structure: Outputs, Derivatives or InitialUnknowns.
pub(crate) fn list(component: &str, list: &str) -> Declared {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../modelDescription");
    let text = std::fs::read_to_string(format!("{folder}/{component}.xml")).unwrap();
    let (open, close) = (format!("<{list}>"), format!("</{list}>"));
    let lines = text.lines().skip_while(|line| line.trim() != open);
    let lines = lines.take_while(|line| line.trim() != close);
    let mut declared = Declared::new();
    for line in lines.filter(|line| line.contains("<Unknown")) {
        let unknown: usize = attribute(line, "index").parse().unwrap();
        let knowns: Vec<&str> = attribute(line, "dependencies").split_whitespace().collect();
        let kinds: Vec<&str> = attribute(line, "dependenciesKind").split_whitespace().collect();
        assert_eq!(knowns.len(), kinds.len(), "{component}, {list}: {line}");
        for (known, kind) in knowns.iter().zip(kinds) {
            let known: usize = known.parse().unwrap();
            declared.insert((unknown - 1, known - 1), kind.to_owned());
        }
    }
    declared
}
