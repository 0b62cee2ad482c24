//! Results as MCAP with ROS 2 messages, which Foxglove, PlotJuggler and rosbag2 open.
//!
//! Columns whose names begin alike (`dvl.velocity.u`, `dvl.stamp`) are the fields of one message
//! on one topic (`/dvl`). A field's name is what ROS allows (`velocity_u`); the real names stand
//! in the channel's metadata, from where they are read back. Log time is simulated time. Chunks
//! are not compressed: doubles of a simulation hardly shrink, and the reader needs no C library.

use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use std::path::{Path, PathBuf};

use ::mcap::records::MessageHeader;
use ::mcap::{McapError, WriteOptions, Writer};

use super::csv::UNWRITTEN;
use super::{Observer, RunInfo};
use crate::error::{Code, Error, Result};
use crate::files::{self, Durable};
use crate::fmi::Kind;
use crate::system::Column;
use crate::texts;
use crate::time::Time;

/// The metadata of a channel that holds its columns: a line `position type name` for each.
pub(super) const COLUMNS: &str = "cosim.columns";
/// CDR, little endian, no options.
pub(super) const CDR_HEADER: [u8; 4] = [0, 1, 0, 0];

/// The type of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Field {
    Float64,
    Int32,
    Bool,
    Text,
}

impl Field {
    pub(super) const ALL: [Field; 4] = [Field::Float64, Field::Int32, Field::Bool, Field::Text];

    fn of(kind: &Kind) -> Self {
        match kind {
            Kind::Real => Field::Float64,
            Kind::String => Field::Text,
            Kind::Integer | Kind::Enumeration(_) => Field::Int32,
            Kind::Boolean => Field::Bool,
        }
    }

    /// ROS's name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Field::Float64 => "float64",
            Field::Int32 => "int32",
            Field::Bool => "bool",
            Field::Text => "string",
        }
    }

    /// Bytes, and what its place is a multiple of; of a String, those of its length, which includes
    /// a zero after it.
    pub(super) fn size(self) -> usize {
        match self {
            Field::Float64 => 8,
            Field::Int32 | Field::Text => 4,
            Field::Bool => 1,
        }
    }
}

/// Writes results while they come.
pub struct McapRecorder {
    target: PathBuf,
    /// None after the end.
    writer: Option<Writer<Durable>>,
    topics: Vec<Topic>,
    message: Vec<u8>,
    sequence: u32,
}

/// One message per sample.
struct Topic {
    channel: u16,
    /// Positions of the columns, and their types.
    fields: Vec<(usize, Field)>,
}

impl McapRecorder {
    /// Creates `file`, and replaces it if it exists.
    pub fn create(file: impl AsRef<Path>) -> Result<Self> {
        let target = file.as_ref().to_owned();
        Self::on(files::create(&target, UNWRITTEN)?, target)
    }

    pub(super) fn on(output: Durable, target: PathBuf) -> Result<Self> {
        let options = WriteOptions::new().compression(None).profile("ros2").library("cosim");
        let writer = options.create(output);
        let writer = Some(writer.map_err(|e| not_written(&target, &e))?);
        Ok(Self { target, writer, topics: Vec::new(), message: Vec::new(), sequence: 0 })
    }

    fn wrote<T>(&self, written: Result<T, McapError>) -> Result<T> {
        written.map_err(|e| not_written(&self.target, &e))
    }

    fn add_topic(&mut self, name: &str, columns: &[(usize, &Column)]) -> Result<()> {
        let (mut schema, mut listed, mut taken) = (String::new(), String::new(), HashMap::new());
        let mut fields = Vec::new();
        for &(position, column) in columns {
            let field = Field::of(&column.kind);
            let short = column.name.strip_prefix(name).unwrap_or(&column.name);
            let short = unique(identifier(short, "value"), &mut taken);
            schema += &format!("{} {short} # {}\n", field.name(), column.name);
            listed += &format!("{position} {} {}\n", field.name(), column.name);
            fields.push((position, field));
        }
        let topic = identifier(name, "system");
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let metadata = BTreeMap::from([(COLUMNS.to_owned(), listed)]);
        let mut initial = topic.clone();
        initial[..1].make_ascii_uppercase();
        let schema_name = format!("cosim/msg/{}", initial.replace('_', ""));
        let channel = writer
            .add_schema(&schema_name, "ros2msg", schema.as_bytes())
            .and_then(|schema| writer.add_channel(schema, &format!("/{topic}"), "cdr", &metadata));
        let channel = self.wrote(channel)?;
        self.topics.push(Topic { channel, fields });
        Ok(())
    }
}

impl Observer for McapRecorder {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        if info.start < Time::ZERO {
            return Err(Error::new(Code::Output, "the results cannot be written as MCAP")
                .at(&self.target)
                .why(format!("the run starts at {}, and MCAP knows no negative time", info.start))
                .help("take a file whose name ends in .csv"));
        }
        let mut topics: Vec<(&str, Vec<(usize, &Column)>)> = Vec::new();
        let mut known: HashMap<&str, usize> = HashMap::new();
        for (position, column) in info.columns.iter().enumerate() {
            let name = column.name.split_once('.').map_or(info.name, |(first, _)| first);
            let topic = *known.entry(name).or_insert_with(|| {
                topics.push((name, Vec::new()));
                topics.len() - 1
            });
            topics[topic].1.push((position, column));
        }
        topics.iter().try_for_each(|(name, columns)| self.add_topic(name, columns))
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        let log_time = time.nanoseconds().unsigned_abs();
        self.sequence = self.sequence.wrapping_add(1);
        for topic in &self.topics {
            self.message.clear();
            self.message.extend(CDR_HEADER);
            for &(position, field) in &topic.fields {
                encode(&mut self.message, field, values[position]);
            }
            let header = MessageHeader {
                channel_id: topic.channel,
                sequence: self.sequence,
                log_time,
                publish_time: log_time,
            };
            if let Some(writer) = &mut self.writer {
                let written = writer.write_to_known_channel(&header, &self.message);
                written.map_err(|e| not_written(&self.target, &e))?;
            }
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<()> {
        let flushed = self.writer.as_mut().map_or(Ok(()), Writer::flush);
        self.wrote(flushed)
    }

    fn finish(&mut self) -> Result<()> {
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        let finished = writer.finish().map(drop);
        self.wrote(finished)?;
        writer.into_inner().flush().map_err(|e| not_written(&self.target, &e))
    }
}

/// Appends a value at the next place that its size divides.
fn encode(message: &mut Vec<u8>, field: Field, value: f64) {
    let place = (message.len() - CDR_HEADER.len()).next_multiple_of(field.size());
    message.resize(place + CDR_HEADER.len(), 0);
    match field {
        Field::Float64 => message.extend(value.to_le_bytes()),
        Field::Int32 => message.extend((value as i32).to_le_bytes()),
        Field::Bool => message.push(u8::from(value != 0.0)),
        Field::Text => {
            let text = texts::text(value);
            message.extend((text.len() as u32 + 1).to_le_bytes());
            message.extend(text.as_bytes());
            message.push(0);
        }
    }
}

/// A name as ROS allows it: small letters, digits, single underscores, a letter first.
fn identifier(name: &str, otherwise: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name = words.collect::<Vec<_>>().join("_").to_ascii_lowercase();
    match name.chars().next() {
        None => otherwise.to_owned(),
        Some(first) if first.is_ascii_digit() => format!("v{name}"),
        Some(_) => name,
    }
}

/// The name, or one with a number behind it: numbers that the name has met already are not tried.
fn unique(name: String, taken: &mut HashMap<String, usize>) -> String {
    let mut number = taken.get(&name).copied().unwrap_or(0);
    let mut candidate = name.clone();
    while taken.contains_key(&candidate) {
        number += 1;
        candidate = format!("{name}_{}", number + 1);
    }
    taken.insert(name, number);
    taken.entry(candidate.clone()).or_insert(0);
    candidate
}

fn not_written(target: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::new(Code::Output, UNWRITTEN).at(target).why(error)
}
