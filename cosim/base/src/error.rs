//! The only error type of all crates of `cosim`: what happened, where, why, and what to do.
//!
//! A check that finds several problems reports them together ([`Error::all`]); the command line
//! prints all of them and exits with the code of the first.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::shown::{one_line, set_in};

mod code;
mod remedy;
pub use code::Code;

/// The result type of all crates of `cosim`.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What happened, where, why and what to do about it. One pointer wide, so that results stay small.
#[derive(Clone)]
pub struct Error(Box<Detail>);

#[derive(Clone)]
struct Detail {
    code: Code,
    what: String,
    place: Option<(PathBuf, Option<usize>)>,
    why: Option<String>,
    help: Option<String>,
    log: Vec<String>,
    /// What an FMI function returned.
    status: Option<i32>,
    others: Vec<Error>,
    /// How many more were found, which are not kept.
    more: usize,
}

/// The maximum number of problems that are reported together: a file can have a million.
const KEPT: usize = 100;

/// Problems found one after another, of which the first hundred are kept.
#[derive(Default)]
pub struct Problems {
    kept: Vec<Error>,
    more: usize,
}

impl Problems {
    /// Notes another problem.
    pub fn push(&mut self, problem: Error) {
        if self.kept.len() < KEPT {
            self.kept.push(problem);
        } else {
            self.more += problem.problems().count() + problem.0.more;
        }
    }

    /// All as one error; `Ok` if there is none.
    pub fn all(self) -> Result<()> {
        Error::all(self.kept).map_err(|mut all| {
            all.0.more += self.more;
            all
        })
    }
}

impl Extend<Error> for Problems {
    fn extend<T: IntoIterator<Item = Error>>(&mut self, problems: T) {
        problems.into_iter().for_each(|problem| self.push(problem));
    }
}

impl Error {
    /// An error of the kind `code`; `what` is one sentence without a full stop.
    pub fn new(code: Code, what: impl Into<String>) -> Self {
        Self(Box::new(Detail {
            code,
            what: what.into(),
            place: None,
            why: None,
            help: None,
            log: Vec::new(),
            status: None,
            others: Vec::new(),
            more: 0,
        }))
    }

    /// The file concerned.
    #[must_use]
    pub fn at(mut self, file: impl AsRef<Path>) -> Self {
        self.0.place = Some((file.as_ref().to_owned(), None));
        self
    }

    /// The file and the line concerned, counted from 1.
    #[must_use]
    pub fn at_line(mut self, file: impl AsRef<Path>, line: usize) -> Self {
        self.0.place = Some((file.as_ref().to_owned(), Some(line)));
        self
    }

    /// The cause.
    #[must_use]
    pub fn why(mut self, why: impl fmt::Display) -> Self {
        self.0.why = Some(why.to_string());
        self
    }

    /// The remedy.
    #[must_use]
    pub fn help(mut self, help: impl fmt::Display) -> Self {
        self.0.help = Some(help.to_string());
        self
    }

    /// The remedy, if there is one.
    #[must_use]
    pub fn maybe_help(mut self, help: Option<String>) -> Self {
        self.0.help = help.or(self.0.help.take());
        self
    }

    /// What the FMU had logged before the failure.
    #[must_use]
    pub fn log(mut self, lines: Vec<String>) -> Self {
        self.0.log = lines;
        self
    }

    /// The status (`fmi2Status`) that an FMU returned.
    #[must_use]
    pub fn returned(mut self, status: impl Into<Option<i32>>) -> Self {
        self.0.status = status.into();
        self
    }

    /// Several problems as one error; `Ok` if there is none. At most the first hundred are kept.
    pub fn all(problems: Vec<Error>) -> Result<()> {
        let mut more: usize = problems.iter().map(|problem| problem.0.more).sum();
        let mut rest = problems.into_iter().flat_map(|mut problem| {
            let others = std::mem::take(&mut problem.0.others);
            std::iter::once(problem).chain(others)
        });
        match rest.next() {
            None => Ok(()),
            Some(mut first) => {
                first.0.others.extend(rest.by_ref().take(KEPT - 1));
                more += rest.count();
                first.0.more = more;
                Err(first)
            }
        }
    }

    /// The kind, which determines the exit code.
    pub fn code(&self) -> Code {
        self.0.code
    }

    /// The first sentence.
    pub fn what(&self) -> &str {
        &self.0.what
    }

    /// The file concerned, and the line if there is one.
    pub fn place(&self) -> Option<(&Path, Option<usize>)> {
        self.0.place.as_ref().map(|(file, line)| (file.as_path(), *line))
    }

    /// The cause, if it is known.
    pub fn reason(&self) -> Option<&str> {
        self.0.why.as_deref()
    }

    /// The remedy, if there is one.
    pub fn remedy(&self) -> Option<&str> {
        self.0.help.as_deref()
    }

    /// The status (`fmi2Status`) that an FMU returned, if that is what failed.
    pub fn status(&self) -> Option<i32> {
        self.0.status
    }

    /// What the FMU had logged before the failure.
    pub fn logged(&self) -> &[String] {
        &self.0.log
    }

    /// This problem and those reported with it.
    pub fn problems(&self) -> impl Iterator<Item = &Error> {
        std::iter::once(self).chain(&self.0.others)
    }

    /// Everything on one line, for logs: what, where, why, what to do.
    pub fn line(&self) -> String {
        let one = |error: &Self| {
            let mut text = error.what().to_owned();
            if let Some((file, place)) = error.place() {
                let place = place.map_or(String::new(), |line| format!(":{line}"));
                text.push_str(&format!(" [{}{place}]", file.display()));
            }
            let parts = [(": ", error.reason()), ("; ", error.remedy())];
            for (before, part) in parts {
                text.extend(part.map(|part| format!("{before}{part}")));
            }
            text
        };
        let all: Vec<String> = self.problems().map(one).collect();
        all.join("; ")
    }

    fn write_one(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let detail = &*self.0;
        write!(f, "[{}] {}", detail.code, set_in(&detail.what))?;
        if let Some((file, line)) = &detail.place {
            write!(f, "\n  at:   {}", one_line(&file.to_string_lossy()))?;
            if let Some(line) = line {
                write!(f, ":{line}")?;
            }
        }
        if let Some(why) = &detail.why {
            write!(f, "\n  why:  {}", set_in(why))?;
        }
        for line in &detail.log {
            write!(f, "\n  log:  {}", set_in(line))?;
        }
        if let Some(help) = &detail.help {
            write!(f, "\n  help: {}", set_in(help))?;
        }
        Ok(())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_one(f)?;
        for other in &self.0.others {
            f.write_str("\n")?;
            other.write_one(f)?;
        }
        if !self.0.others.is_empty() {
            write!(f, "\n{} problems", self.0.others.len() + 1 + self.0.more)?;
        }
        if self.0.more > 0 {
            write!(f, ", of which the first {KEPT} are shown")?;
        }
        Ok(())
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {}
