//! What FMUs log, and where their messages and calls are shown.

use std::io::{BufWriter, Stderr, stderr};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use cosim::fmi::Trace;
use cosim::shown::Terminal;
use cosim::{Overrides, Result, files};

#[derive(Args)]
pub(crate) struct Logging {
    /// Request debug messages from the FMUs, and show all messages immediately
    #[arg(long)]
    debug_logging: bool,
    /// Request only debug messages of this category (repeatable; default: all)
    #[arg(long, value_name = "CATEGORY")]
    log_category: Vec<String>,
    /// Write every FMI call with its arguments, results and status to stderr or to FILE
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, default_missing_value = "-")]
    log_fmi_calls: Option<PathBuf>,
    /// Show the messages and calls of this instance only (repeatable; default: all)
    #[arg(long, value_name = "INSTANCE")]
    log_instance: Vec<String>,
}

impl Logging {
    /// The file for the log of calls.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.log_fmi_calls.as_deref().filter(|file| *file != Path::new("-"))
    }

    /// Adds the requested outputs.
    pub(crate) fn add_to(&self, overrides: Overrides) -> Result<Overrides> {
        let debug = self.debug_logging || !self.log_category.is_empty();
        let mut overrides = overrides.debug_logging(debug);
        for category in &self.log_category {
            overrides = overrides.log_category(category);
        }
        Ok(match self.trace(debug)? {
            Some(trace) => overrides.trace(Arc::new(trace.only(&self.log_instance))),
            None => overrides,
        })
    }

    /// Empties the file for the log of calls, once all inputs are known.
    pub(crate) fn begin(&self) -> Result<()> {
        let file = |path| files::create_plain(path, UNWRITTEN).map(drop);
        self.file().map_or(Ok(()), file)
    }

    fn trace(&self, debug: bool) -> Result<Option<Trace>> {
        Ok(match &self.log_fmi_calls {
            None if debug => Some(Trace::new(terminal(), false)),
            None => None,
            Some(file) if file == Path::new("-") => Some(Trace::new(terminal(), true)),
            Some(file) => {
                let output = files::create_later(file, UNWRITTEN)?;
                Some(Trace::new(BufWriter::new(output), true))
            }
        })
    }
}

const UNWRITTEN: &str = "the log of calls cannot be written";

fn terminal() -> Terminal<Stderr> {
    Terminal::new(stderr())
}
