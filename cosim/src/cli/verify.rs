//! `cosim verify`: whether two runs gave the same results, and if not, where they diverge.

use std::path::{Path, PathBuf};

use clap::Args;
use cosim::observe::{Apart, Closeness, Comparison, Parting, Tolerance};
use cosim::{Code, Error, Recording, Result, files, names};

use super::output::print;
use super::values;

/// Compare two result files bit by bit or within tolerances, or one with a digest
#[derive(Args)]
pub(crate) struct Verify {
    /// Results: CSV or MCAP; or a list of digests (--digest-file)
    a: PathBuf,
    /// The other results (CSV or MCAP), or the digest that a run printed
    b: PathBuf,
    /// Allowed difference, for all variables or for a name or pattern (repeatable)
    #[arg(long, value_name = "[NAME=]NUMBER", value_parser = values::tolerance)]
    abs: Vec<(String, f64)>,
    /// Allowed difference relative to the greater value, for all variables or for a name or pattern
    /// (repeatable); if both are given, their sum
    #[arg(long, value_name = "[NAME=]NUMBER", value_parser = values::tolerance)]
    rel: Vec<(String, f64)>,
    /// Compare at every instant of A: B is interpolated linearly between its samples (default: at
    /// common instants)
    #[arg(long)]
    interpolate: bool,
}

/// How many variables are listed individually.
const SHOWN: usize = 20;

impl Verify {
    pub(crate) fn run(self) -> Result<()> {
        if let Some(tolerance) = self.tolerance() {
            let (a, b) = (cosim::observe::read(&self.a)?, cosim::observe::read(&self.b)?);
            self.check_names(&a)?;
            return self.within(&Closeness::of(&a, &b, &tolerance));
        }
        if let Some(digest) = digest_in(&self.b) {
            return self.against(&digest);
        }
        if let (Some(a), Some(b)) = (list(&self.a)?, list(&self.b)?) {
            return self.lists(&a, &b);
        }
        let (a, b) = (cosim::observe::read(&self.a)?, cosim::observe::read(&self.b)?);
        let found = Comparison::of(&a, &b);
        if found.is_same() {
            let order = if found.reordered { ", in another order" } else { "" };
            return print(&format!(
                "the same: {} samples of {} variables{order}; digest {}",
                found.samples,
                found.columns,
                a.digest()?.text()
            ));
        }
        let largest = Closeness::of(&a, &b, &Tolerance::new()).largest;
        self.print_comparison(&found, largest)
    }

    /// The tolerances; `None` without such an option.
    fn tolerance(&self) -> Option<Tolerance> {
        if self.abs.is_empty() && self.rel.is_empty() && !self.interpolate {
            return None;
        }
        let tolerance = Tolerance::new().interpolate(self.interpolate);
        let tolerance = self.abs.iter().fold(tolerance, |t, (name, n)| t.absolute(name, *n));
        Some(self.rel.iter().fold(tolerance, |t, (name, n)| t.relative(name, *n)))
    }

    /// Refuses tolerances that are about no variable.
    fn check_names(&self, a: &Recording) -> Result<()> {
        let known = || a.names().iter().map(String::as_str);
        let unknown = |(name, _): &&(String, f64)| {
            name != "*" && !known().any(|known| names::matches(name, known))
        };
        let Some((name, _)) = self.abs.iter().chain(&self.rel).find(unknown) else {
            return Ok(());
        };
        let what = format!("there is no variable '{name}', for which a tolerance is given");
        Err(Error::new(Code::UnknownName, what)
            .at(&self.a)
            .maybe_help(names::did_you_mean(name, known())))
    }

    fn within(&self, found: &Closeness) -> Result<()> {
        let names = [&self.a, &self.b].map(|file| file.display().to_string());
        self.only((&found.only.0, &found.only.1), &names)?;
        for beyond in found.beyond.iter().take(SHOWN) {
            print(&format!(
                "too far apart at {} of {} samples, first at t = {}: {}",
                beyond.samples, found.samples, beyond.first, beyond.worst
            ))?;
        }
        if found.beyond.len() > SHOWN {
            print(&format!("and {} more variables", found.beyond.len() - SHOWN))?;
        }
        if let Some(largest) = &found.largest {
            print(&format!("largest difference: {largest}"))?;
        }
        for (count, name) in [(found.left_out.0, &names[0]), (found.left_out.1, &names[1])] {
            if count > 0 {
                print(&format!("{count} samples of {name} have no partner of the same time"))?;
            }
        }
        let (samples, columns) = (found.samples, found.columns);
        if found.is_close() {
            return print(&format!("near enough: {samples} samples of {columns} variables"));
        }
        let what = match (samples, found.beyond.len()) {
            (0, _) => "the results have no instant in common".to_owned(),
            (_, 0) => "the results have different variables".to_owned(),
            (_, far) => format!("{far} of {columns} variables are too far apart"),
        };
        Err(Error::new(Code::Parted, what).why(format!("{samples} samples were compared")))
    }

    fn only(&self, (a, b): (&[String], &[String]), names: &[String; 2]) -> Result<()> {
        for (only, name) in [(a, &names[0]), (b, &names[1])] {
            if !only.is_empty() {
                let names = only[..only.len().min(SHOWN)].join(", ");
                let more = only.len().saturating_sub(SHOWN);
                let more = if more > 0 { format!(" and {more} more") } else { String::new() };
                print(&format!("only {name} has: {names}{more}"))?;
            }
        }
        Ok(())
    }

    fn print_comparison(&self, found: &Comparison, largest: Option<Apart>) -> Result<()> {
        let names = [&self.a, &self.b].map(|file| file.display().to_string());
        self.only((&found.only_a, &found.only_b), &names)?;
        for (a, b) in found.renamed().into_iter().take(SHOWN) {
            print(&format!("is '{a}' called '{b}' in the other?"))?;
        }
        if let Some(Parting::Values { variables, .. }) = &found.parting {
            for variable in variables.iter().take(SHOWN) {
                print(&variable.to_string())?;
            }
            if variables.len() > SHOWN {
                print(&format!("and {} more variables", variables.len() - SHOWN))?;
            }
        }
        if let Some(largest) = largest {
            print(&format!("largest difference: {largest}"))?;
        }
        let alike =
            format!("{} samples of {} variables are the same", found.samples, found.columns);
        Err(Error::new(Code::Parted, what(found, &names)).why(alike))
    }

    fn against(&self, digest: &str) -> Result<()> {
        let recording = cosim::observe::read(&self.a)?;
        let found = recording.digest()?.text();
        match found == digest {
            true => print(&format!("the same: {} samples", recording.time().len())),
            false => Err(Error::new(Code::Parted, "the results have another digest")
                .at(&self.a)
                .why(format!("it is {found}"))
                .help("compare two files to see where they diverge: cosim verify A B")),
        }
    }

    fn lists(&self, a: &[(String, String)], b: &[(String, String)]) -> Result<()> {
        let parted = a.iter().zip(b).position(|(a, b)| a != b);
        match parted {
            None if a.len() == b.len() => print(&format!("the same: {} samples", a.len())),
            None => {
                let what = format!("one list ends after {} digests", a.len().min(b.len()));
                Err(Error::new(Code::Parted, what).why(format!("{} and {}", a.len(), b.len())))
            }
            Some(sample) => {
                let times = (&a[sample].0, &b[sample].0);
                let when = match times.0 == times.1 {
                    true => format!("t = {}", times.0),
                    false => format!("t = {} and {}", times.0, times.1),
                };
                let what = format!("the runs part at sample {sample}, {when}");
                Err(Error::new(Code::Parted, what)
                    .why(format!("{sample} digests before it are the same"))
                    .help("compare the results themselves to see the variables: cosim verify A B"))
            }
        }
    }
}

fn what(found: &Comparison, names: &[String; 2]) -> String {
    match &found.parting {
        None => "the results have different variables".to_owned(),
        Some(Parting::Values { sample, time, variables }) => format!(
            "the results part at sample {sample}, t = {time:?}: {} of {} variables differ",
            variables.len(),
            found.columns
        ),
        Some(Parting::Time { sample, a, b }) => {
            format!("the results part at sample {sample}: it is of t = {a:?} and of t = {b:?}")
        }
        Some(Parting::End { a, b, time }) => {
            let (short, long) = if a < b { (0, 1) } else { (1, 0) };
            let time = time.map_or(String::new(), |t| format!(" at t = {t:?}"));
            format!(
                "{} ends{time} after {} samples, {} has {}",
                names[short],
                a.min(b),
                names[long],
                a.max(b)
            )
        }
    }
}

/// The digest that is given instead of a file.
fn digest_in(path: &Path) -> Option<String> {
    let text = path.to_str()?;
    let is_digest = text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
    (is_digest && !path.exists()).then(|| text.to_ascii_lowercase())
}

/// The lines of a list of digests, if the file is one.
fn list(file: &Path) -> Result<Option<Vec<(String, String)>>> {
    let bytes = files::read_input(file)
        .map_err(|why| Error::new(Code::File, "the results cannot be read").at(file).why(why))?;
    let Some(lines) = bytes.strip_prefix(b"time,digest\n") else {
        return Ok(None);
    };
    let text = String::from_utf8_lossy(lines);
    let pairs = text.lines().filter_map(|line| line.split_once(','));
    Ok(Some(pairs.map(|(time, digest)| (time.to_owned(), digest.to_owned())).collect()))
}
