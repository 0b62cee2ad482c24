//! Messages on stderr; colours only on a terminal, and not with NO_COLOR.

use std::io::{IsTerminal, Write};

use cosim::{Error, System};

/// Prints an error, and those reported with it.
pub(crate) fn error(error: &Error) {
    tagged("error", "31", &error.to_string());
}

/// Prints what is odd but not wrong.
pub(crate) fn warning(text: &str) {
    tagged("warning", "33", text);
}

/// Prints what is neither odd nor wrong, and good to know.
pub(crate) fn note(text: &str) {
    tagged("note", "36", text);
}

/// Prints what was done, and what components said.
pub(crate) fn tell(text: &str) {
    line(text);
}

/// Prints what a system's check found: warnings always, notes unless `quiet`.
pub(crate) fn findings(system: &System, quiet: bool) {
    system.warnings().iter().for_each(|text| warning(text));
    if !quiet {
        system.notes().iter().for_each(|text| note(text));
    }
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
