//! Errors as JSON: what `--format json` prints if something is wrong.

use cosim::{Error, Result};
use serde_json::{Value, json};

use super::Format;
use super::output::print;

/// Prints the error of a run with `--format json`; the caller prints it as text.
pub(crate) fn reported<T>(format: Format, outcome: Result<T>) -> Result<T> {
    if let (Format::Json, Err(error)) = (format, &outcome) {
        print(&json!({ "problems": list(error), "text": error.to_string() }).to_string())?;
    }
    outcome
}

/// An error and those reported with it.
pub(crate) fn list(error: &Error) -> Vec<Value> {
    error.problems().map(problem).collect()
}

fn problem(error: &Error) -> Value {
    let (file, line) = error.place().map_or((None, None), |(f, l)| (Some(f), l));
    json!({
        "code": error.code().as_str(),
        "what": error.what(),
        "file": file.map(|f| f.display().to_string()),
        "line": line,
        "why": error.reason(),
        "log": error.logged(),
        "help": error.remedy(),
    })
}
