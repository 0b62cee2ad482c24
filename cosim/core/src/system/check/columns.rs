//! Which variables are recorded; Strings only if requested.

use std::collections::HashSet;

use super::Names;
use crate::system::Column;
use cosim_base::error::{Code, Error, Problems, Result};
use cosim_base::names;
use cosim_import::{Causality, Kind};

/// Maximum number of comparisons of names and patterns, longer ones counting more: both may come
/// from files.
const MAX_EFFORT: usize = 1 << 26;

/// Columns that match the patterns, in order; all outputs if there are no patterns.
pub(in crate::system) fn columns(names: &Names, patterns: &[String]) -> Result<Vec<Column>> {
    let mut columns: Vec<Column> = Vec::new();
    let mut ports = HashSet::new();
    let mut add = |name: String, port, kind: &Kind| {
        if ports.insert(port) {
            let unit = names.unit(port);
            columns.push(Column { name, port, kind: kind.clone(), unit });
        }
    };
    if patterns.is_empty() {
        for (name, port, variable) in names.all() {
            if variable.causality == Causality::Output && variable.kind != Kind::String {
                add(name, port, &variable.kind);
            }
        }
    }
    let mut problems = Problems::default();
    let mut effort = 0;
    for pattern in patterns {
        let result = match names::is_pattern(pattern) {
            true => by_pattern(names, pattern, &mut effort, &mut add),
            false => by_name(names, pattern, &mut add),
        };
        if effort > MAX_EFFORT {
            return result.map(|()| columns);
        }
        problems.extend(result.err());
    }
    problems.all()?;
    Ok(columns)
}

/// A warning for a run that would record nothing although no variables were named.
pub(in crate::system) fn without_any(columns: &[Column], patterns: &[String]) -> Option<String> {
    (columns.is_empty() && patterns.is_empty()).then(|| {
        "nothing but the time is recorded, because there are no outputs: choose variables with \
         --output-variable ('*' stands for all; cosim info lists them)"
            .to_owned()
    })
}

fn by_name(
    names: &Names,
    name: &str,
    add: &mut impl FnMut(String, crate::system::Port, &Kind),
) -> Result<()> {
    let Some((port, variable)) = names.find(name)? else {
        return Ok(());
    };
    add(name.to_owned(), port, &variable.kind);
    Ok(())
}

fn by_pattern(
    names: &Names,
    pattern: &str,
    effort: &mut usize,
    add: &mut impl FnMut(String, crate::system::Port, &Kind),
) -> Result<()> {
    let mut found = false;
    // Most of them are passed over by their first bytes.
    *effort += names.components() / 16;
    for (name, port, variable) in names.starting_with(names::literal_start(pattern)) {
        *effort += 1 + pattern.len() * name.len() / 64;
        if *effort > MAX_EFFORT {
            return Err(Error::new(
                Code::Usage,
                "there are too many patterns of recorded variables",
            )
            .why(format!("comparing them with all variables takes too long, at '{pattern}'"))
            .help("record fewer patterns, or name the variables"));
        }
        if names::matches(pattern, &name) {
            add(name, port, &variable.kind);
            found = true;
        }
    }
    if found || names.incomplete() {
        return Ok(());
    }
    Err(Error::new(Code::UnknownName, format!("the pattern '{pattern}' matches no variable"))
        .why("* stands for any text, ? for one character")
        .help("list the variables with cosim info FILE"))
}
