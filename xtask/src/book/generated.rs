//! Generated parts of pages: `<!-- generated: cli -->` stands for the help of every command,
//! `<!-- generated: errors -->` for all error codes, `<!-- generated: python -->` for the Python
//! package; the page of a component's equations gets its title, its plot and its variables.

use super::pages::Page;
use crate::{
    package::{contents, page::plot, reference},
    paths, process, python,
};
use anyhow::{Result, anyhow, bail};
use cosim::Code;
use fmu_kit::kernel::Entry;
use std::{fmt::Write, path::Path, process::Command};

/// The folder of the components' equations.
const COMPONENTS: &str = "fmu/components/documentation";

/// The whole text of a page.
pub(super) fn complete(page: &Page) -> Result<String> {
    if let Some(component) = component(&page.path) {
        return component_page(component);
    }
    let Some((before, rest)) = page.text.split_once("<!-- generated: ") else {
        return Ok(page.text.clone());
    };
    let (name, after) = rest
        .split_once(" -->")
        .ok_or_else(|| anyhow!("{}: `<!--` without end", page.path.display()))?;
    let text = match name {
        "cli" => command_line()?,
        "errors" => errors(),
        "python" => python_package()?,
        _ => bail!("{}: nothing generates `{name}`", page.path.display()),
    };
    Ok(format!("{before}{text}{after}"))
}

/// The component that a page is about.
fn component(page: &Path) -> Option<&'static Entry> {
    let name = page.file_stem()?.to_str()?;
    let entry = rexrov_fmu::REGISTRY.entries().find(|entry| entry.info().name == name);
    entry.filter(|_| page.parent() == Some(Path::new(COMPONENTS)))
}

fn component_page(component: &Entry) -> Result<String> {
    let name = component.info().name;
    let equations = contents::source(&format!("{name}.md"))?;
    let listing = component.listing();
    let (head, variables) = listing.split_once("\n\n### ").unwrap_or((&listing, ""));
    let head = head.trim_start_matches("## ");
    let svg = plot(component, &reference::run(component)?)?;
    Ok(format!(
        "# {head}\n\n{equations}\n## Reference run\n\n\
         <figure class=\"plot\">{}</figure>\n\n## {variables}",
        svg.replace('\n', " "),
        variables = variables.replace("\n### ", "\n## "),
    ))
}

/// The docstrings of the Python package, with its signatures.
fn python_package() -> Result<String> {
    let root = paths::root();
    let mut command = Command::new(python::BOOK.interpreter()?);
    command.arg(root.join("xtask/src/book/python.py")).arg(root.join("cosim/python/rexrov"));
    process::output(&mut command)
}

/// The output of `cosim help` for each command and subcommand.
pub(super) fn command_line() -> Result<String> {
    let overview = help(&["--help"])?;
    let mut text = format!("```text\n{}\n```\n", overview.trim_end());
    for verb in commands(&overview) {
        let page = help(&["help", verb])?;
        section(&mut text, &format!("## cosim {verb}"), &page);
        for below in commands(&page) {
            let page = help(&["help", verb, below])?;
            section(&mut text, &format!("### cosim {verb} {below}"), &page);
        }
    }
    Ok(text)
}

fn help(arguments: &[&str]) -> Result<String> {
    let program = paths::target().join("release/cosim");
    process::output(Command::new(program).args(arguments).env("COLUMNS", "100"))
}

/// The commands that a help text lists.
fn commands(help: &str) -> impl Iterator<Item = &str> {
    let listed = help.split_once("Commands:\n").map_or("", |(_, listed)| listed);
    // Continued descriptions are indented further.
    let own = |line: &&str| !line.starts_with("   ");
    let lines = listed.lines().take_while(|line| line.starts_with("  ")).filter(own);
    lines.filter_map(|line| line.split_whitespace().next()).filter(|verb| *verb != "help")
}

fn section(text: &mut String, title: &str, help: &str) {
    // Writing to a String cannot fail.
    let _ = write!(text, "\n{title}\n\n```text\n{}\n```\n", help.trim_end());
}

/// Every code with its meaning and remedy.
fn errors() -> String {
    let mut text = String::new();
    for &code in Code::ALL {
        let (meaning, remedy) = (code.explanation().trim(), code.remedy());
        let _ =
            write!(text, "## {code}\n\n{meaning} Exit code {}.\n\n{remedy}\n\n", code.exit_code());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_component_has_a_page_with_its_variables() {
        for entry in rexrov_fmu::REGISTRY.entries() {
            let path = Path::new(COMPONENTS).join(format!("{}.md", entry.info().name));
            let text = complete(&Page { path, text: String::new() }).unwrap();
            assert!(text.starts_with(&format!("# {}", entry.info().name)));
            for heading in ["## Equations", "## Reference run"] {
                assert!(text.contains(heading), "{heading}");
            }
            assert!(text.contains("| name | description |"));
        }
    }

    #[test]
    fn every_error_code_is_explained() {
        assert_eq!(errors().matches("\n## E").count() + 1, Code::ALL.len());
    }
}
