//! `cargo xtask field FOLDER`: results of systems of other tools in `cosim`, as a table.
//!
//! The files are not part of this project: the folder contains checkouts of public repositories,
//! one in each of its folders.

use crate::{paths, process};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// For systems that have neither, as given on the command line.
const STOP: [&str; 2] = ["--stop-time", "20"];
const STEP: [&str; 2] = ["--step-size", "0.01"];

#[derive(clap::Args)]
pub(crate) struct Options {
    /// Contains the files, at any depth.
    folder: PathBuf,
    /// Output file of the table.
    #[arg(long, default_value = "docs/reference/systems-in-the-field.md")]
    output: PathBuf,
}

/// The result for one file.
struct Outcome {
    valid: bool,
    runs: bool,
    /// The options that had to be given, or why it is rejected.
    remark: String,
}

/// Validates and runs each system, and writes the table.
pub(crate) fn run(options: &Options) -> Result<()> {
    process::run(&mut process::build_workspace())?;
    let mut files = Vec::new();
    find(&options.folder, &mut files)?;
    files.sort();
    ensure!(!files.is_empty(), "no system below {}", options.folder.display());
    let mut sources: BTreeMap<String, Vec<(String, Outcome)>> = BTreeMap::new();
    for file in files {
        let name = file.strip_prefix(&options.folder)?.display().to_string();
        let (source, place) = name.split_once('/').unwrap_or((".", &name));
        let outcome = outcome(&file).with_context(|| name.clone())?;
        sources.entry(source.to_owned()).or_default().push((place.to_owned(), outcome));
    }
    let output = paths::root().join(&options.output);
    std::fs::write(&output, page(&sources)?).with_context(|| output.display().to_string())
}

fn find(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    for entry in folder.read_dir().with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let ends = |ending: &str| path.extension().is_some_and(|e| e == ending);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_osp = ends("xml") && name.starts_with("OspSystemStructure");
        let is_system = ends("ssd") || ends("ssp") || is_osp;
        if path.is_dir() {
            find(&path, files)?;
        } else if is_system {
            files.push(path);
        }
    }
    Ok(())
}

fn outcome(file: &Path) -> Result<Outcome> {
    let valid = cosim("validate", file, &[])?.is_none();
    let mut given: Vec<&str> = Vec::new();
    loop {
        let Some(problem) = cosim("run", file, &given)? else {
            let remark = match given.is_empty() {
                true => String::new(),
                false => format!("with `{}`", given.join(" ")),
            };
            return Ok(Outcome { valid, runs: true, remark });
        };
        let missing =
            |what: &str, option: [&str; 2]| problem.contains(what) && !given.contains(&option[0]);
        if missing("no stop time", STOP) {
            given.extend(STOP);
        } else if missing("no component has a step size", STEP) {
            given.extend(STEP);
        } else {
            return Ok(Outcome { valid, runs: false, remark: problem });
        }
    }
}

/// Calls the program: the first problem in words, if there is one.
fn cosim(verb: &str, file: &Path, options: &[&str]) -> Result<Option<String>> {
    let folder = paths::target().join("field");
    std::fs::create_dir_all(&folder)?;
    let mut command = Command::new(paths::released(None).join("cosim"));
    command.current_dir(&folder).arg(verb).arg(file.canonicalize()?).args(options);
    command.arg("--format=json").env("NO_COLOR", "1");
    if verb == "run" {
        command.args(["--quiet", "--output-file", "out.csv"]);
    }
    let output = command.output().context("cannot start cosim")?;
    if output.status.success() {
        return Ok(None);
    }
    let reported: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let problems = reported["problems"].as_array().map_or(&[][..], Vec::as_slice);
    let Some(first) = problems.first() else {
        return Ok(Some(format!("ended with {}", output.status)));
    };
    let text = |name: &str| first[name].as_str().unwrap_or_default().to_owned();
    let why = match text("why") {
        why if why.is_empty() => String::new(),
        // The folder of the unpacked archive differs each time.
        why => format!(": {}", why.split(" (required by ").next().unwrap_or_default()),
    };
    let words = format!("{}: {}{why}", text("code"), text("what"));
    let folder = file.parent().unwrap_or(file).canonicalize()?;
    let words = words.replace(&format!("{}/", folder.display()), "");
    let log = first["log"].as_array().and_then(|lines| lines.first()?.as_str());
    let log = log.map_or(String::new(), |line| format!("; {line}"));
    let more = match problems.len() {
        1 => String::new(),
        count => format!(" (the first of {count})"),
    };
    Ok(Some(format!("{words}{log}{more}")))
}

fn page(sources: &BTreeMap<String, Vec<(String, Outcome)>>) -> Result<String> {
    let all = || sources.values().flatten().map(|(_, outcome)| outcome);
    let (count, valid) = (all().count(), all().filter(|o| o.valid).count());
    let runs = all().filter(|o| o.runs).count();
    let mut page = String::from(include_str!("field.md"));
    writeln!(page, "\nOf {count} files {valid} are valid and {runs} run.")?;
    for (source, files) in sources {
        writeln!(page, "\n## {}\n", source.replacen('+', "/", 1))?;
        writeln!(page, "| system | valid | runs | remark |\n|---|---|---|---|")?;
        for (name, Outcome { valid, runs, remark }) in files {
            let yes = |is: bool| if is { "yes" } else { "no" };
            let remark = remark.replace('<', "&lt;").replace('|', "\\|").replace('\n', " ");
            writeln!(page, "| {name} | {} | {} | {remark} |", yes(*valid), yes(*runs))?;
        }
    }
    Ok(page)
}
