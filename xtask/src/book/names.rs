//! Names in the pages: a file path, an option, a variable or an error code that does not exist
//! fails the book, with page, line and the nearest existing name.
//!
//! Inline code is checked; error codes are also checked elsewhere. Code blocks are run
//! (`examples`).

use super::generated::command_line;
use super::pages::{Page, Pages, events, line};
use crate::{Arguments, paths};
use anyhow::{Context, Result, bail};
use clap::CommandFactory;
use cosim::{
    Code,
    names::{matches, nearest},
};
use pulldown_cmark::Event;
use std::{collections::BTreeSet, fs, path::Path};

/// Options of other programs that pages mention alone.
const OTHER_OPTIONS: [&str; 2] = ["--locked", "--inplace"];
/// Endings of files that are meant when a name has no folder.
const SOURCES: [&str; 5] = ["c", "md", "py", "rs", "toml"];
/// Endings of names with dots that are not variables.
const FILES: [&str; 20] = [
    "csv", "dll", "fmu", "html", "ipynb", "json", "jsonl", "key", "mcap", "pem", "png", "pub",
    "sh", "sig", "so", "ssd", "ssp", "svg", "txt", "xml",
];
/// A history page, which may use former names.
const HISTORY: &str = "CHANGELOG.md";

/// Fails if a page names something that does not exist.
pub(super) fn check(pages: &Pages) -> Result<()> {
    let known = Known::read()?;
    let problems: Vec<String> = pages.pages.iter().flat_map(|page| known.problems(page)).collect();
    match problems.is_empty() {
        true => Ok(()),
        false => bail!("{}", problems.join("\n")),
    }
}

/// Existing names.
struct Known {
    /// Files and folders below the root, with `/` between the parts.
    paths: BTreeSet<String>,
    options: BTreeSet<String>,
    /// Variables of the components and the groups they are in, without indices: `thruster[].force`.
    variables: BTreeSet<String>,
    /// Components of the systems in `examples/`.
    instances: BTreeSet<String>,
}

impl Known {
    fn read() -> Result<Self> {
        let mut paths = BTreeSet::new();
        walk(paths::root(), "", &mut paths)?;
        let mut instances = BTreeSet::new();
        for system in ["baseline", "paper"] {
            let file = paths::root().join(format!("examples/{system}.ssd"));
            let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
            let names = text.split("<ssd:Component name=\"").skip(1);
            instances.extend(names.filter_map(|rest| Some(rest.split_once('"')?.0.to_owned())));
        }
        Ok(Self { paths, options: options()?, variables: variables(), instances })
    }

    fn problems(&self, page: &Page) -> Vec<String> {
        let mut found: Vec<(usize, String)> = codes(&page.text)
            .filter(|(_, code)| Code::ALL.iter().all(|known| known.as_str() != *code))
            .map(|(at, code)| (at, format!("there is no error code {code}")))
            .collect();
        let code = |(event, range): (Event<'_>, std::ops::Range<usize>)| match event {
            Event::Code(code) => Some((range.start, code.into_string())),
            _ => None,
        };
        if page.path != Path::new(HISTORY) {
            for (at, span) in events(&page.text).filter_map(code) {
                found.extend(self.problem(&span).map(|problem| (at, problem)));
            }
        }
        let place = |at: usize| format!("{}:{}", page.path.display(), line(&page.text, at));
        found.into_iter().map(|(at, problem)| format!("{}: {problem}", place(at))).collect()
    }

    /// The problem with a piece of inline code.
    fn problem(&self, span: &str) -> Option<String> {
        if !span.starts_with("cargo ") || span.starts_with("cargo xtask") {
            let words = span.split(|c: char| c.is_whitespace() || "=[]|,".contains(c));
            let options = words.filter(|word| word.starts_with("--") && word.len() > 2);
            for option in options {
                if !self.options.contains(option) && !OTHER_OPTIONS.contains(&option) {
                    return Some(missing("option", option, &self.options));
                }
            }
        }
        let (first, rest) = span.split_once('/').unwrap_or((span, ""));
        let plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
        if !rest.is_empty() && span.chars().all(plain) && self.is_folder(first) {
            let (path, end) = (span.trim_end_matches('/'), format!("/{}", span));
            // Or of a crate that the page describes.
            let there = self.paths.contains(path) || self.paths.iter().any(|p| p.ends_with(&end));
            return (!there).then(|| missing("file", path, &self.paths));
        }
        let ending = span.rsplit_once('.').map_or("", |(_, ending)| ending);
        if span.chars().all(plain) && SOURCES.contains(&ending) && rest.is_empty() {
            let end = format!("/{span}");
            let there = self.paths.contains(span) || self.paths.iter().any(|p| p.ends_with(&end));
            return (!there).then(|| missing("file", span, &self.paths));
        }
        match FILES.contains(&ending) || !is_variable(span) {
            true => None,
            false => self.variable(span),
        }
    }

    fn is_folder(&self, name: &str) -> bool {
        name != "target" && self.paths.contains(name) && paths::root().join(name).is_dir()
    }

    /// A variable of a component, `instance.variable` of a system, a group of them or a pattern.
    fn variable(&self, span: &str) -> Option<String> {
        let name = without_indices(span);
        let (first, rest) = name.split_once('.')?;
        let own = self.instances.contains(first);
        let head = format!("{first}.");
        let candidates = [Some(name.as_str()), own.then_some(rest)];
        let exists = |name: &str| self.variables.iter().any(|known| matches(name, known));
        let concerns = own || self.variables.iter().any(|known| known.starts_with(&head));
        let there = candidates.into_iter().flatten().any(exists);
        (concerns && !there).then(|| missing("variable", &name, &self.variables))
    }
}

fn missing(what: &str, name: &str, known: &BTreeSet<String>) -> String {
    let near = nearest(name, known.iter().map(String::as_str));
    let near = near.map(|near| format!(", but `{near}`")).unwrap_or_default();
    format!("there is no {what} `{name}`{near}")
}

/// Names of files and folders, except hidden and built ones.
fn walk(folder: &Path, above: &str, paths: &mut BTreeSet<String>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if (name.starts_with('.') && name != ".github") || name == "target" {
            continue;
        }
        let below = if above.is_empty() { name } else { format!("{above}/{name}") };
        if path.is_dir() {
            walk(&path, &below, paths)?;
        }
        paths.insert(below);
    }
    Ok(())
}

/// The options of `cosim` and of the task runner.
fn options() -> Result<BTreeSet<String>> {
    let help = command_line()?;
    let words = help.split(|c: char| c.is_whitespace() || "=[]<>,.;:'`()|".contains(c));
    let mut options: BTreeSet<String> =
        words.filter(|word| word.starts_with("--")).map(str::to_owned).collect();
    for task in Arguments::command().get_subcommands() {
        let long = task.get_arguments().filter_map(clap::Arg::get_long);
        options.extend(long.map(|name| format!("--{name}")));
    }
    Ok(options)
}

fn variables() -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for entry in rexrov_fmu::REGISTRY.entries() {
        for variable in entry.table().variables() {
            let name = without_indices(&variable.name);
            let dots = name.match_indices('.').map(|(at, _)| name[..at].to_owned());
            all.extend(dots.collect::<Vec<_>>());
            all.insert(name);
        }
    }
    all
}

/// `thruster[3].force` and `thruster[?].force` as `thruster[].force`.
fn without_indices(name: &str) -> String {
    let mut parts = name.split('[');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| {
        format!("{all}[]{}", part.split_once(']').map_or(part, |(_, rest)| rest))
    })
}

/// Whether a text has the form of a variable with a dot.
fn is_variable(span: &str) -> bool {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_.[]*?".contains(c);
    let starts = span.starts_with(|c: char| c.is_ascii_lowercase());
    starts && span.contains('.') && !span.ends_with('.') && span.chars().all(good)
}

/// Positions and texts of apparent error codes.
fn codes(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.match_indices('E').filter_map(move |(at, _)| {
        let code = text.get(at..at + 4)?;
        let digits = code[1..].bytes().all(|byte| byte.is_ascii_digit());
        let alone = !text[..at].ends_with(word) && !text[at + 4..].starts_with(word);
        (digits && alone).then_some((at, code))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn problems(text: &str) -> Vec<String> {
        let known = Known {
            paths: set(&["cosim", "cosim/src", "cosim/src/xml.rs", "examples/a/src/main.rs"]),
            options: set(&["--step"]),
            variables: set(&["pose", "pose.x", "thruster[]", "thruster[].force"]),
            instances: set(&["vehicle"]),
        };
        known.problems(&Page { path: "a.md".into(), text: text.into() })
    }

    #[test]
    fn every_name_in_the_pages_exists() {
        // Asks `cosim` for its options, which `cargo test --workspace` has built.
        check(&Pages::reached().unwrap()).unwrap();
    }

    #[test]
    fn what_exists_passes() {
        for text in [
            "E105 and SE105, E1055, `cosim/src/xml.rs`, `cosim/src/`, `xml.rs`, `src/main.rs`",
            "`--step 0.1`, `cosim run --step=a`, `cargo bench --bench x`, `target/a.rs/x`",
            "`vehicle.pose.x`, `pose.*`, `thruster[3].force`, `*.thruster[?].force`, `pose.csv`",
            "`run.sh`, `rexrov.run`, `{a,b}`",
        ] {
            assert_eq!(problems(text), [""; 0], "{text}");
        }
    }

    #[test]
    fn what_does_not_is_named_with_its_line_and_what_was_meant() {
        for (text, wanted) in [
            ("a\n\nE999", "a.md:3: there is no error code E999"),
            (
                "`cosim/src/xm.rs`",
                "a.md:1: there is no file `cosim/src/xm.rs`, but `cosim/src/xml.rs`",
            ),
            ("`none.rs`", "there is no file `none.rs`"),
            ("`cosim run --stpe 1`", "there is no option `--stpe`, but `--step`"),
            ("`vehicle.pose.y`", "there is no variable `vehicle.pose.y`"),
            (
                "`thruster[1].farce`",
                "there is no variable `thruster[].farce`, but `thruster[].force`",
            ),
        ] {
            let found = problems(text);
            assert!(found.len() == 1 && found[0].contains(wanted), "{text}: {found:?}");
        }
    }
}
