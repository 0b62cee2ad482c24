//! A running digest of everything that is recorded: SHA-256 over names, times and values.
//!
//! It covers the numbers, not a file: a run recorded as CSV and one as MCAP have the same digest.
//! After each sample it represents all samples so far, so two runs agree up to exactly the last
//! sample at which their digests are equal.
//!
//! The octets are the names of the columns, each followed by a line feed; then for each sample the
//! time in ns (i64) and the values (f64), little-endian. All NaNs count as one, because CSV has
//! only one. A String is its length (u64) and its octets.

use std::cell::RefCell;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use sha2::{Digest, Sha256};

use super::{Observer, Recording, RunInfo, Stop};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files::{self, Durable};
use cosim_base::hexadecimal;
use cosim_base::texts;
use cosim_base::time::{self, Time};
use cosim_import::Kind;

const UNWRITTEN: &str = "the list of digests cannot be written";

/// The digest of everything recorded so far.
#[derive(Debug, Clone, Default)]
pub struct RunningDigest {
    hash: Sha256,
    samples: u64,
    /// For each column, whether it holds Strings.
    texts: Vec<bool>,
}

impl RunningDigest {
    /// For columns with these names, without samples yet.
    pub fn new<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut digest = Self::default();
        for name in names {
            digest.hash.update(name);
            digest.hash.update(b"\n");
        }
        digest
    }

    /// Which of those columns hold Strings.
    pub(super) fn with_texts(mut self, texts: impl IntoIterator<Item = bool>) -> Self {
        self.texts = texts.into_iter().collect();
        self
    }

    /// Adds a sample.
    pub fn add(&mut self, time: Time, values: impl IntoIterator<Item = f64>) {
        self.hash.update(time.ns().to_le_bytes());
        for (place, value) in values.into_iter().enumerate() {
            if self.texts.get(place) == Some(&true) {
                let text = texts::text(value);
                self.hash.update((text.len() as u64).to_le_bytes());
                self.hash.update(text.as_bytes());
                continue;
            }
            let value = if value.is_nan() { f64::NAN } else { value };
            self.hash.update(value.to_le_bytes());
        }
        self.samples += 1;
    }

    /// The number of samples so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The digest.
    pub fn octets(&self) -> [u8; 32] {
        self.hash.clone().finalize().into()
    }

    /// The digest in hexadecimal digits.
    pub fn text(&self) -> String {
        hexadecimal(&self.octets())
    }
}

impl Recording {
    /// The digest of a complete recording.
    pub fn digest(&self) -> Result<RunningDigest> {
        let names = self.columns().map(|(name, _)| name);
        let texts = (0..self.names().len()).map(|place| self.is_text_at(place));
        let mut digest = RunningDigest::new(names).with_texts(texts);
        for (sample, &seconds) in self.time().iter().enumerate() {
            let time = time::from_seconds(seconds, "a time of the results")?;
            digest.add(time, self.columns().map(|(_, values)| values[sample]));
        }
        Ok(digest)
    }
}

/// A recorder around another one that also computes the digest.
pub struct Digested {
    recorder: Box<dyn Observer>,
    digest: Rc<RefCell<RunningDigest>>,
    /// Gets the digest after each sample.
    list: Option<(Durable, PathBuf)>,
}

impl Digested {
    /// Around `recorder`; the digest can be read through the second value.
    pub fn new(recorder: Box<dyn Observer>) -> (Self, Rc<RefCell<RunningDigest>>) {
        let digest = Rc::<RefCell<RunningDigest>>::default();
        (Self { recorder, digest: digest.clone(), list: None }, digest)
    }

    /// Writes the digest after each sample as a line `time,digest` of this file.
    pub fn list(mut self, file: impl AsRef<Path>) -> Result<Self> {
        let target = file.as_ref().to_owned();
        let file = files::create(&target, UNWRITTEN)?;
        self.list = Some((file, target));
        Ok(self)
    }

    fn write(&mut self, write: impl FnOnce(&mut Durable) -> std::io::Result<()>) -> Result<()> {
        match &mut self.list {
            Some((file, target)) => write(file).map_err(|why| not_written(target, &why)),
            None => Ok(()),
        }
    }
}

impl Observer for Digested {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        let names = info.columns.iter().map(|column| column.name.as_str());
        let texts = info.columns.iter().map(|column| column.kind == Kind::String);
        *self.digest.borrow_mut() = RunningDigest::new(names).with_texts(texts);
        self.write(|file| file.write_all(b"time,digest\n"))?;
        self.recorder.start(info)
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        self.digest.borrow_mut().add(time, values.iter().copied());
        if self.list.is_some() {
            let text = self.digest.borrow().text();
            self.write(|file| writeln!(file, "{:?},{text}", time.seconds()))?;
        }
        self.recorder.sample(time, values)
    }

    fn flush(&mut self) -> Result<()> {
        self.write(Write::flush)?;
        self.recorder.flush()
    }

    fn finish(&mut self) -> Result<()> {
        // The results come first: they are closed even if the list cannot be closed.
        self.recorder.finish().and(self.write(Write::flush))
    }

    fn stop(&self) -> Option<Stop> {
        self.recorder.stop()
    }
}

fn not_written(target: &Path, why: &std::io::Error) -> Error {
    Error::new(Code::Output, UNWRITTEN).at(target).why(why)
}
