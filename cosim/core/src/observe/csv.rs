//! Results as CSV in the format of FMPy: a header, first column `time`, comma, LF.
//!
//! Numbers are the shortest texts that read back to the same bits; Strings are quoted.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::{Observer, RunInfo, Stop};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files::{self, Durable};
use cosim_base::texts;
use cosim_base::time::Time;
use cosim_import::Kind;

const UNWRITTEN: &str = "the results cannot be written";

/// Writes results while they arrive.
pub struct CsvRecorder<W: Write = Durable> {
    target: PathBuf,
    output: W,
    /// For each column.
    forms: Vec<Form>,
    /// The line that is being written.
    text: Vec<u8>,
    /// The output is a pipe that its reader has closed.
    closed: bool,
}

/// How a value is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// With all digits.
    Real,
    /// Integers, and Booleans as 0 and 1.
    Whole,
    /// By number.
    Text,
}

impl Form {
    /// For values of this type.
    pub fn of(kind: &Kind) -> Self {
        match kind {
            Kind::Real => Form::Real,
            Kind::String => Form::Text,
            Kind::Integer | Kind::Enumeration(_) | Kind::Boolean => Form::Whole,
        }
    }
}

impl CsvRecorder {
    /// Creates `file`, replacing an existing one.
    pub fn create(file: impl AsRef<Path>) -> Result<Self> {
        let target = file.as_ref().to_owned();
        Ok(Self::new(files::create(&target, UNWRITTEN)?, target))
    }
}

impl<W: Write> CsvRecorder<W> {
    /// Writes to `output`; `name` is its name in errors.
    pub fn new(output: W, name: impl Into<PathBuf>) -> Self {
        Self { target: name.into(), output, forms: Vec::new(), text: Vec::new(), closed: false }
    }

    /// Writes one line.
    pub(super) fn row(&mut self, time: f64, values: &[f64]) -> Result<()> {
        let written = self.line(time, values);
        self.outcome(written)
    }

    /// If the reader is gone (`| head`), that is not an error: the run is asked to end.
    fn outcome(&mut self, written: std::io::Result<()>) -> Result<()> {
        match written {
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => {
                self.closed = true;
                Ok(())
            }
            written => written.map_err(|e| not_written(&self.target, &e)),
        }
    }

    fn line(&mut self, time: f64, values: &[f64]) -> std::io::Result<()> {
        // {:?} is the shortest text that reads back to the same f64, with exponents.
        self.text.clear();
        write!(self.text, "{time:?}")?;
        for (value, form) in values.iter().zip(&self.forms) {
            match form {
                Form::Real => write!(self.text, ",{value:?}")?,
                Form::Whole => write!(self.text, ",{value}")?,
                Form::Text => write!(self.text, ",{}", in_quotes(&texts::text(*value)))?,
            }
        }
        self.text.push(b'\n');
        self.output.write_all(&self.text)
    }

    /// Writes the header.
    pub(super) fn header<'a>(
        &mut self,
        names: impl Iterator<Item = &'a str>,
        forms: Vec<Form>,
    ) -> Result<()> {
        self.forms = forms;
        let mut text = String::from("time");
        for name in names {
            text.push(',');
            text.push_str(&quoted(name));
        }
        text.push('\n');
        let written = self.output.write_all(text.as_bytes());
        self.outcome(written)
    }
}

impl<W: Write> Observer for CsvRecorder<W> {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        let forms = info.columns.iter().map(|c| Form::of(&c.kind)).collect();
        self.header(info.columns.iter().map(|c| c.name.as_str()), forms)
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        self.row(time.seconds(), values)
    }

    fn flush(&mut self) -> Result<()> {
        let written = self.output.flush();
        self.outcome(written)
    }

    fn finish(&mut self) -> Result<()> {
        self.flush()
    }

    fn stop(&self) -> Option<Stop> {
        self.closed.then_some(Stop::ReaderGone)
    }
}

/// Quoted only if necessary: FMPy's reader does not support quotes.
fn quoted(name: &str) -> String {
    match name.contains([',', '"', '\n']) {
        true => in_quotes(name),
        false => name.to_owned(),
    }
}

fn in_quotes(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

fn not_written(target: &Path, error: &std::io::Error) -> Error {
    Error::new(Code::Output, UNWRITTEN).at(target).why(error)
}
