//! Results as MCAP with ROS 2 messages, which Foxglove, PlotJuggler and rosbag2 open.
//!
//! Channels and messages are those of [`crate::ros`]; results are read back from the channels of
//! columns. Log time is simulated time. Chunks are not compressed: doubles of a simulation hardly
//! compress, and the reader needs no C library.

use std::io::Write;
use std::path::{Path, PathBuf};

use ::mcap::records::MessageHeader;
use ::mcap::{McapError, WriteOptions, Writer};

use crate::UNWRITTEN;
use crate::roles::Declaration;
use crate::ros::Channels;
use cosim_base::error::{Code, Error, Result};
use cosim_base::files::{self, Durable};
use cosim_base::time::Time;
use cosim_core::observe::{Observer, RunInfo};

/// Writes results while they arrive.
pub struct McapRecorder {
    target: PathBuf,
    /// `None` after the end.
    writer: Option<Writer<Durable>>,
    roles: Option<Declaration>,
    /// With the number of each in the file.
    channels: Option<(Channels, Vec<u16>)>,
    sequence: u32,
}

impl McapRecorder {
    /// Creates `file`, replacing an existing one.
    pub fn create(file: impl AsRef<Path>) -> Result<Self> {
        let target = file.as_ref().to_owned();
        Self::on(files::create(&target, UNWRITTEN)?, target)
    }

    pub(super) fn on(output: Durable, target: PathBuf) -> Result<Self> {
        let options = WriteOptions::new().compression(None).profile("ros2").library("cosim");
        let writer = options.create(output);
        let writer = Some(writer.map_err(|e| not_written(&target, &e))?);
        Ok(Self { target, writer, roles: None, channels: None, sequence: 0 })
    }

    /// Also declares the roles of the variables, if their names do not show them.
    #[must_use]
    pub fn declared(mut self, roles: Option<Declaration>) -> Self {
        self.roles = roles;
        self
    }

    fn wrote<T>(&self, written: Result<T, McapError>) -> Result<T> {
        written.map_err(|e| not_written(&self.target, &e))
    }
}

impl Observer for McapRecorder {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        if info.start < Time::ZERO {
            return Err(Error::new(Code::Output, "the results cannot be written as MCAP")
                .at(&self.target)
                .why(format!("the run starts at {}, and MCAP has no negative times", info.start))
                .help("use a file name that ends in .csv"));
        }
        let Some(writer) = &mut self.writer else { return Ok(()) };
        let channels = Channels::new(info.name, info.columns, self.roles.as_ref())?;
        let numbers = channels.all.iter().map(|channel| {
            let schema = channel.schema.as_bytes();
            let schema = writer.add_schema(&channel.schema_name, "ros2msg", schema)?;
            writer.add_channel(schema, &format!("/{}", channel.topic), "cdr", &channel.metadata)
        });
        let numbers = numbers.collect::<Result<Vec<u16>, McapError>>();
        self.channels = Some((channels, self.wrote(numbers)?));
        Ok(())
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        let log_time = time.ns().unsigned_abs();
        self.sequence = self.sequence.wrapping_add(1);
        let (Some(writer), Some((channels, numbers))) = (&mut self.writer, &mut self.channels)
        else {
            return Ok(());
        };
        let written = channels.each(time, values, |at, message| {
            let (channel_id, sequence, publish_time) = (numbers[at], self.sequence, log_time);
            let header = MessageHeader { channel_id, sequence, log_time, publish_time };
            writer.write_to_known_channel(&header, message)
        });
        written.map_err(|e| not_written(&self.target, &e))
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

fn not_written(target: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::new(Code::Output, UNWRITTEN).at(target).why(error)
}
