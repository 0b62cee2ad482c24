//! The output of two runs of the driver, line by line.

use anyhow::{Context, Result};
use std::{fs, path::Path};

/// One component on two platforms.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Findings {
    pub(super) component: String,
    /// Steps of co-simulation, including those before a saved state.
    pub(super) steps: usize,
    /// Values of outputs after them.
    pub(super) outputs: usize,
    /// Total length of the saved states.
    pub(super) state_bytes: usize,
    pub(super) log_lines: usize,
    /// Derivatives, all variables, statuses.
    pub(super) other_lines: usize,
    /// The first line that differs, in words.
    pub(super) difference: Option<String>,
}

/// Compares the results of a platform with those of the reference.
pub(super) fn folders(reference: &Path, other: &Path) -> Result<Vec<Findings>> {
    let read = |folder: &Path, name: &str| {
        let path = folder.join(format!("{name}.txt"));
        fs::read_to_string(&path).with_context(|| path.display().to_string())
    };
    let mut all = Vec::new();
    let names = rexrov_fmu::REGISTRY.entries().map(|entry| entry.info().name).chain(["Clumsy"]);
    for name in names {
        all.push(texts(name, &read(reference, name)?, &read(other, name)?));
    }
    // The locations differ, their contents do not.
    if let Ok(text) = read(other, "locations") {
        all.push(locations(&text));
    }
    Ok(all)
}

/// Compares the output for one component.
fn texts(component: &str, reference: &str, other: &str) -> Findings {
    let mut findings = Findings { component: component.to_owned(), ..Findings::default() };
    for line in other.lines() {
        let words = line.split(' ').count();
        match line.split(' ').next() {
            Some("s" | "a") => {
                findings.steps += 1;
                findings.outputs += words.saturating_sub(5);
            }
            Some("b") => findings.state_bytes += line.rsplit(' ').next().map_or(0, str::len) / 2,
            Some("l") => findings.log_lines += 1,
            _ => findings.other_lines += 1,
        }
    }
    let mut lines = reference.lines().zip(other.lines()).enumerate();
    let first = lines.find(|(_, (one, two))| one != two);
    findings.difference = match first {
        Some((at, (one, two))) => {
            Some(format!("line {}: {} instead of {}", at + 1, short(two), short(one)))
        }
        None if reference.lines().count() != other.lines().count() => {
            Some("one of them wrote more lines".to_owned())
        }
        None => repetition(other),
    };
    findings
}

/// Steps before a saved state are the same again after it is restored.
fn repetition(text: &str) -> Option<String> {
    let of = |mark: &str| -> Vec<&str> {
        text.lines().filter_map(|line| line.strip_prefix(mark)).collect()
    };
    let steps = of("s ");
    let differs = of("a ").into_iter().find(|ahead| !steps.contains(ahead))?;
    Some(format!("a step after a state was restored is not {}", short(differs)))
}

/// All spellings lead to the file.
fn locations(text: &str) -> Findings {
    let tries = text.lines().filter(|line| line.starts_with("p "));
    let failed = tries.clone().find(|line| !line.starts_with("p 0 0 "));
    Findings {
        component: "places of a file".to_owned(),
        log_lines: text.lines().filter(|line| line.starts_with("l ")).count(),
        other_lines: tries.count(),
        difference: failed.map(|line| format!("not found: {line}")),
        ..Findings::default()
    }
}

fn short(line: &str) -> String {
    const LONGEST: usize = 200;
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("\"{}…\"", &line[..end]),
        None => format!("{line:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "i 0\nb 0 2 0aff\na 1 0 0 0 3ff0\nr 0 0\ns 1 0 0 0 3ff0\nl 3 x y: no\ne 3\n";

    #[test]
    fn what_is_compared_is_counted() {
        let same = texts("X", TEXT, TEXT);
        assert_eq!((same.steps, same.outputs, same.state_bytes), (2, 2, 2));
        assert_eq!((same.log_lines, same.other_lines, same.difference), (1, 3, None));
    }

    #[test]
    fn any_bit_any_text_and_any_length_that_differ_are_told() {
        for (from, to, part) in [
            ("0aff", "0afe", "line 2: \"b 0 2 0afe\" instead of \"b 0 2 0aff\""),
            ("y: no", "y: na", "line 6"),
            ("e 3\n", "", "more lines"),
        ] {
            let difference = texts("X", TEXT, &TEXT.replace(from, to)).difference.unwrap();
            assert!(difference.contains(part), "{difference}");
        }
        let other = TEXT.replace("s 1 0 0 0 3ff0", "s 1 0 0 0 4000");
        let difference = texts("X", &other, &other).difference.unwrap();
        assert!(difference.contains("after a state was restored"), "{difference}");
    }

    #[test]
    fn a_place_that_is_not_found_is_told() {
        let found = locations("l 0 reader x: y\np 0 0 file:///a b\n");
        assert_eq!((found.difference, found.log_lines, found.other_lines), (None, 1, 1));
        assert!(locations("p 0 0 a b\np 0 3 file:///c b\n").difference.unwrap().contains("///c"));
    }
}
