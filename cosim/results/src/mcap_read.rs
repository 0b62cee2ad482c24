//! Reads back files written by `mcap`.

use std::collections::HashMap;
use std::path::Path;

use crate::mcap_records::{MAGIC, Record, each};
use crate::ros::{CDR_HEADER, COLUMNS, DERIVED, Field};
use cosim_base::error::{Code, Error, Result};
use cosim_base::texts;
use cosim_base::units::recorded::{self, UNITS};
use cosim_core::observe::{Form, Recording};

/// A column being read.
struct Read {
    position: usize,
    name: String,
    unit: String,
    form: Form,
    values: Vec<f64>,
}

/// The columns of one channel.
struct Topic {
    fields: Vec<Field>,
    columns: Vec<Read>,
}

/// Reads `file`; an unfinished one up to where it is complete.
pub(super) fn read(file: &Path) -> Result<Recording> {
    let wrong =
        |why: String| Error::new(Code::Results, "the results cannot be read").at(file).why(why);
    let bytes = cosim_base::files::read_input(file)
        .map_err(|e| Error::new(Code::File, "the results cannot be read").at(file).why(e))?;
    let records = bytes.strip_prefix(MAGIC).ok_or_else(|| {
        wrong(format!(
            "the file is not MCAP: {}",
            match bytes.is_empty() {
                true => "it is empty",
                false => "its first bytes are wrong",
            }
        ))
    })?;
    let mut topics: Vec<Topic> = Vec::new();
    let mut by_channel: HashMap<u16, Option<usize>> = HashMap::new();
    let mut time: Vec<u64> = Vec::new();
    let finished = each(records, &mut |record| match record {
        Record::Channel { id, .. } if by_channel.contains_key(&id) => Ok(()),
        Record::Channel { id, topic, metadata } => {
            if metadata.iter().any(|(key, _)| *key == DERIVED) {
                by_channel.insert(id, None);
                return Ok(());
            }
            let listed = metadata.iter().find(|(key, _)| *key == COLUMNS).ok_or_else(|| {
                format!(
                    "the channel {topic} was not written by cosim: its metadata has no {COLUMNS}"
                )
            })?;
            let (fields, mut columns) = columns_of(listed.1)
                .ok_or_else(|| format!("the channel {topic} lists no columns"))?;
            if let Some((_, text)) = metadata.iter().find(|(key, _)| *key == UNITS) {
                let units = recorded::read(text, columns.iter().map(|column| &column.name));
                columns.iter_mut().zip(units).for_each(|(column, unit)| column.unit = unit);
            }
            by_channel.insert(id, Some(topics.len()));
            topics.push(Topic { fields, columns });
            Ok(())
        }
        Record::Message { channel, log_time, data } => {
            let at = by_channel.get(&channel).copied();
            let at =
                at.ok_or_else(|| format!("a message belongs to the unknown channel {channel}"))?;
            let Some(at) = at else { return Ok(()) };
            if at == 0 {
                time.push(log_time);
            }
            decode(data, &mut topics[at])
                .ok_or_else(|| format!("a message on the channel {channel} is too short"))
        }
    })
    .map_err(wrong)?;
    let mut columns: Vec<Read> = topics.into_iter().flat_map(|topic| topic.columns).collect();
    columns.sort_by_key(|column| column.position);
    // The last sample of an unfinished file may lack topics.
    let whole = columns.iter().map(|c| c.values.len()).fold(time.len(), usize::min);
    time.truncate(whole);
    columns.iter_mut().for_each(|column| column.values.truncate(whole));
    let time = time.into_iter().map(|ns| ns as f64 / 1e9).collect();
    let forms = columns.iter().map(|column| column.form).collect();
    let units = columns.iter_mut().map(|column| std::mem::take(&mut column.unit)).collect();
    let (names, values) = columns.into_iter().map(|c| (c.name, c.values)).unzip();
    let read = Recording::from_columns(names, time, values).with_forms(forms).with_units(units);
    Ok(if finished { read } else { read.unfinished("it has no footer") })
}

fn columns_of(listed: &str) -> Option<(Vec<Field>, Vec<Read>)> {
    let mut fields = Vec::new();
    let mut columns = Vec::new();
    for line in listed.lines() {
        let mut parts = line.splitn(3, ' ');
        let position = parts.next()?.parse().ok()?;
        let kind = parts.next()?;
        let field = Field::ALL.into_iter().find(|field| field.name() == kind)?;
        let name = parts.next()?.to_owned();
        fields.push(field);
        let form = match field {
            Field::Float64 => Form::Real,
            Field::Int32 | Field::Bool => Form::Whole,
            Field::Text => Form::Text,
        };
        columns.push(Read { position, name, unit: String::new(), form, values: Vec::new() });
    }
    Some((fields, columns))
}

fn decode(data: &[u8], topic: &mut Topic) -> Option<()> {
    let data = data.strip_prefix(&CDR_HEADER)?;
    let mut place = 0_usize;
    for (field, column) in topic.fields.iter().zip(&mut topic.columns) {
        place = place.next_multiple_of(field.size());
        let bytes = data.get(place..place + field.size())?;
        column.values.push(match field {
            Field::Float64 => f64::from_le_bytes(bytes.try_into().ok()?),
            Field::Int32 => f64::from(i32::from_le_bytes(bytes.try_into().ok()?)),
            Field::Bool => f64::from(bytes[0]),
            Field::Text => {
                let length = u32::from_le_bytes(bytes.try_into().ok()?) as usize;
                let text = data.get(place + 4..)?.get(..length)?;
                place += length;
                let text = text.strip_suffix(&[0]).unwrap_or(text);
                texts::number(std::str::from_utf8(text).ok()?)
            }
        });
        place += field.size();
    }
    Some(())
}
