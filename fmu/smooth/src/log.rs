//! Logs: CSV files with the inputs of a filter as columns.

use crate::names;
use anyhow::{Context, Result, bail, ensure};
use csv::StringRecord;
use fmu_kit::{Declarations, Field, Reader, Variables, Writer};
use rexrov::estimation::Recording;
use rexrov_fmu::navigation_ports::Inputs;
use std::path::Path;

/// An input that a sensor may omit.
const OPTIONAL: &str = "fix.sigma";

/// Reads a log into a recording; `component` is the prefix of the relevant columns.
pub(crate) fn read(file: &Path, component: Option<&str>, recording: &mut Recording) -> Result<()> {
    let shown = file.display().to_string();
    let mut reader = csv::Reader::from_path(file).with_context(|| shown.clone())?;
    let header = reader.headers().with_context(|| shown.clone())?.clone();
    let layout = Layout::of(&header, component).with_context(|| format!("{shown}:1"))?;
    let mut last = f64::NEG_INFINITY;
    for row in reader.records() {
        let row = row.with_context(|| shown.clone())?;
        let line = row.position().map_or(0, csv::Position::line);
        let at = || format!("{shown}:{line}");
        let now = number(&row, layout.time, "time").with_context(at)?;
        if now.is_nan() || now < last {
            bail!("{}: the time {now} s comes after {last} s", at());
        }
        last = now;
        let inputs = layout.inputs(&row).with_context(at)?;
        recording.add(now, &inputs.measurements());
    }
    Ok(())
}

/// The column of each input.
struct Layout {
    time: usize,
    sensors: Vec<Sensor>,
    start: Vec<f64>,
}

/// A sensor with columns: an input has its name, its position among the inputs, and its column.
struct Sensor {
    values: Vec<(String, usize, usize)>,
    optional: Option<(String, usize, usize)>,
    stamp: Option<(String, usize, usize)>,
    valid: (usize, Option<usize>),
}

impl Layout {
    fn of(header: &StringRecord, component: Option<&str>) -> Result<Self> {
        let inputs = Inputs::default();
        let mut declared = Declarations::new();
        inputs.declare(&Field::default(), &mut declared);
        let known: Vec<&str> = declared.iter().map(|input| input.field.name.as_str()).collect();
        let prefix = component.map_or(String::new(), |name| format!("{name}."));
        let columns: Vec<Option<&str>> =
            header.iter().map(|column| column.trim().strip_prefix(&*prefix)).collect();
        for column in columns.iter().flatten().filter(|c| **c != "time" && !known.contains(c)) {
            let own = known.iter().any(|name| sensor_of(name) == sensor_of(column));
            let meant = names::nearest(column, &known, 4);
            // A recorded system also contains the component's outputs.
            if component.is_none() && (own || meant.is_some()) {
                bail!("column '{column}' is not an input; {}", names::hint(column, &known));
            }
        }
        let time = header.iter().position(|column| column.trim() == "time");
        let Some(time) = time else { bail!("there is no column 'time'") };
        let mut sensors = Vec::new();
        for name in ["imu", "ahrs", "dvl", "fix", "pressure", "propulsion"] {
            let own = |(_, input): &(usize, &&str)| sensor_of(input) == name;
            let own: Vec<(usize, &&str)> = known.iter().enumerate().filter(own).collect();
            sensors.extend(Sensor::of(&own, &columns)?);
        }
        let whose = component.map_or(String::new(), |name| format!(" of '{name}'"));
        ensure!(
            !sensors.is_empty(),
            "there is no column with an input{whose}: {}",
            known.join(", ")
        );
        let mut start = vec![0.0; Inputs::COUNT.reals];
        inputs.store(&mut Writer { reals: &mut start, ..Writer::default() });
        Ok(Self { time, sensors, start })
    }

    fn inputs(&self, row: &StringRecord) -> Result<Inputs> {
        let mut reals = self.start.clone();
        for sensor in &self.sensors {
            sensor.read(row, &mut reals)?;
        }
        Ok(Inputs::load(&mut Reader { reals: &reals, ..Reader::default() }))
    }
}

impl Sensor {
    /// None if there is no column of its values.
    fn of(inputs: &[(usize, &&str)], columns: &[Option<&str>]) -> Result<Option<Self>> {
        let column = |name: &str| columns.iter().position(|column| *column == Some(name));
        let (mut values, mut missing) = (Vec::new(), Vec::new());
        let (mut optional, mut stamp, mut valid) = (None, None, (0, None));
        for (place, name) in inputs {
            let found = column(name).map(|column| ((**name).to_owned(), *place, column));
            match (found, name.rsplit('.').next()) {
                (found, Some("stamp")) => stamp = found,
                (found, Some("valid")) => valid = (*place, found.map(|(.., column)| column)),
                (found, _) if **name == OPTIONAL => optional = found,
                (Some(found), _) => values.push(found),
                (None, _) => missing.push(**name),
            }
        }
        if let (Some((there, ..)), Some(missing)) = (values.first(), missing.first()) {
            bail!("there is a column '{there}', but none '{missing}'");
        }
        Ok((!values.is_empty()).then_some(Self { values, optional, stamp, valid }))
    }

    /// Cells that are empty or not numbers: no sample in this row.
    fn read(&self, row: &StringRecord, into: &mut [f64]) -> Result<()> {
        let is_empty = |column: usize| {
            let text = row.get(column).unwrap_or_default().trim();
            text.is_empty() || text.eq_ignore_ascii_case("nan")
        };
        if self.values.iter().all(|(.., column)| is_empty(*column)) {
            return Ok(());
        }
        for (name, place, column) in &self.values {
            into[*place] = number(row, *column, name)?;
        }
        for (name, place, column) in self.optional.iter().chain(&self.stamp) {
            if !is_empty(*column) {
                into[*place] = number(row, *column, name)?;
            }
        }
        let (place, column) = self.valid;
        into[place] = match column {
            Some(column) => number(row, column, "valid")?,
            None => 1.0,
        };
        Ok(())
    }
}

fn number(row: &StringRecord, column: usize, name: &str) -> Result<f64> {
    let text = row.get(column).unwrap_or_default().trim();
    text.parse().with_context(|| format!("column '{name}': '{text}' is not a number"))
}

/// The sensor that an input belongs to.
fn sensor_of(input: &str) -> &str {
    match input.split(['.', '[']).next() {
        Some("thruster") => "propulsion",
        sensor => sensor.unwrap_or_default(),
    }
}
