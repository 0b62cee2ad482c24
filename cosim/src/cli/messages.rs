//! Messages on stderr; colours only on a terminal, and not with NO_COLOR.

use std::io::{IsTerminal, Write};

use cosim::shown::{set_in, visible};
use cosim::{Error, System};

/// Prints an error, and those reported with it.
pub(crate) fn error(error: &Error) {
    tagged("error", "31", &error.to_string());
}

/// Prints a warning.
pub(crate) fn warning(text: &str) {
    tagged("warning", "33", &set_in(text));
}

/// Prints a note.
pub(crate) fn note(text: &str) {
    tagged("note", "36", &set_in(text));
}

/// Prints what was done.
pub(crate) fn info(text: &str) {
    line(&visible(text));
}

/// Prints a message of a component.
pub(crate) fn said(text: &str) {
    line(&set_in(text));
}

/// Prints the findings of a system's check: warnings always, notes unless `quiet`.
pub(crate) fn findings(system: &System, quiet: bool) {
    report_some(system.warnings(), warning);
    if !quiet {
        report_some(system.notes(), note);
    }
}

/// How many messages of one kind are shown; a file can have a million.
const SHOWN: usize = 100;

/// Reports the first of many messages.
pub(crate) fn report_some(texts: &[String], report: fn(&str)) {
    texts.iter().take(SHOWN).for_each(|text| report(text));
    if texts.len() > SHOWN {
        report(&format!("and {} more (--format json has them all)", texts.len() - SHOWN));
    }
}

fn tagged(tag: &str, colour: &str, text: &str) {
    let text = visible(text);
    let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if std::io::stderr().is_terminal() && !no_color {
        line(&format!("\x1b[1;{colour}m{tag}\x1b[0m: {text}"));
    } else {
        line(&format!("{tag}: {text}"));
    }
}

fn line(text: &str) {
    // If stderr is closed, there is no channel left to report it.
    drop(writeln!(std::io::stderr(), "{text}"));
}
