//! Messages on stderr; colours only on a terminal, and not with NO_COLOR.

use std::io::{IsTerminal, Write};

use cosim::Error;

/// Prints an error, and those reported with it.
pub(crate) fn error(error: &Error) {
    tagged("error", "31", &error.to_string());
}

/// Prints what is odd but not wrong.
pub(crate) fn warning(text: &str) {
    tagged("warning", "33", text);
}

/// Prints what is good to know.
pub(crate) fn note(text: &str) {
    line(text);
}

fn tagged(tag: &str, colour: &str, text: &str) {
    let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if std::io::stderr().is_terminal() && !no_color {
        line(&format!("\x1b[1;{colour}m{tag}\x1b[0m: {text}"));
    } else {
        line(&format!("{tag}: {text}"));
    }
}

fn line(text: &str) {
    // Nobody is left to be told that stderr is closed.
    drop(writeln!(std::io::stderr(), "{text}"));
}
