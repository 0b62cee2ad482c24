//! `cargo xtask book`: the documents as one book, target/book/index.html, for reading offline.
//!
//! | file | contents |
//! |---|---|
//! | `pages` | which documents belong to it: those reached by links |
//! | `stage` | their copies under target/, in the form that Sphinx reads |
//! | `generated` | the reference pages, from the code |
//! | `names` | files, options, variables and error codes named in pages, which must exist |
//! | `pictures` | the pictures that the pages' own commands make |
//!
//! Sphinx checks the anchors of links; all of its warnings are errors. `docs/conf.py` and
//! `docs/static/` define its appearance.

mod generated;
mod names;
pub(crate) mod pages;
mod pictures;
mod stage;

use crate::{examples, paths, process, python};
use anyhow::{Context, Result};
use pages::Pages;
use std::{fs, process::Command};

/// Leads from the book's folder to its first page.
const ENTRY: &str = "<!DOCTYPE html><meta charset=\"utf-8\"><title>RexROV and cosim</title>\
                     <meta http-equiv=\"refresh\" content=\"0; url=docs/index.html\">\
                     <a href=\"docs/index.html\">RexROV and cosim</a>\n";

/// Runs the code of the pages, compares their pictures or (without `check`) updates them, and
/// builds the book.
pub(crate) fn run(check: bool) -> Result<()> {
    examples::run()?;
    names::check(&Pages::reached()?)?;
    pictures::settle(check)?;
    build()
}

fn build() -> Result<()> {
    let (source, book) = (paths::target().join("book-source"), paths::target().join("book"));
    let _ = fs::remove_dir_all(&book);
    stage::write(&Pages::reached()?, &source)?;
    process::run(
        Command::new(python::BOOK.install()?.join("sphinx-build"))
            .args(["--quiet", "--fail-on-warning", "--keep-going", "--conf-dir"])
            .arg(source.join("docs"))
            .arg("--doctree-dir")
            .arg(source.join(".doctrees"))
            .args([&source, &book]),
    )?;
    let entry = book.join("index.html");
    fs::write(&entry, ENTRY).with_context(|| entry.display().to_string())?;
    println!("the book is {}", entry.display());
    Ok(())
}
