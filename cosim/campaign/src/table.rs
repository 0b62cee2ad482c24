//! The rows of a campaign as tables: Parquet and CSV, one row per run, in the order of the runs.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::mpsc;
use std::thread;

use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as Written};
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::log::Log;
use super::row::{Number, RowDigest};
use super::rows::Rows;
use super::{Campaign, Row, Status};
use cosim_base::error::Error;
use cosim_results::check_footer;
use cosim_results::columns::{Holds, Table, Values};

/// Rows of a row group: few, because groups are in memory while they are written.
const GROUP: usize = 1 << 11;

/// Which inputs are numbers in all rows of a campaign.
#[derive(Clone)]
pub(super) struct Numeric {
    runs: u64,
    inputs: Vec<bool>,
}

impl Numeric {
    /// Of no rows yet.
    pub(super) fn new(campaign: &Campaign) -> Self {
        Self { runs: campaign.runs(), inputs: vec![true; campaign.inputs().count()] }
    }

    /// Which inputs of a row are not numbers; none if its run does not belong to the campaign.
    pub(super) fn texts(&self, row: &Row) -> Box<[usize]> {
        let all = (0..self.inputs.len()).filter(|_| row.run < self.runs);
        all.filter(|place| at(&row.inputs, *place).parse::<f64>().is_err()).collect()
    }

    /// Adds a row in which these inputs are not numbers.
    pub(super) fn note(&mut self, texts: &[usize]) {
        texts.iter().for_each(|place| self.inputs[*place] = false);
    }
}

/// How many runs a table has, or why it cannot be read.
pub(super) fn runs(file: &Path) -> Result<u64, String> {
    let content = std::fs::read(file).map_err(|e| e.to_string())?;
    check_footer(&content).map_err(|e| e.to_string())?;
    let file = File::open(file).map_err(|e| e.to_string())?;
    let reader = SerializedFileReader::new(file).map_err(|e| e.to_string())?;
    Ok(reader.metadata().file_metadata().num_rows() as u64)
}

/// As Parquet; `identity` is stored with it.
pub(super) fn parquet(
    campaign: &Campaign,
    log: &Log,
    rows: &Rows,
    numeric: &Numeric,
    identity: &[String],
    output: impl Write + Send,
) -> Written<()> {
    let inputs = || campaign.inputs().zip(&numeric.inputs);
    let named = |name: &str| (name.to_owned(), Holds::Text);
    let mut columns = vec![("run".to_owned(), Holds::Whole)];
    columns.extend(["cell", "system", "replacement", "scenario"].map(named));
    columns.push(("replicate".to_owned(), Holds::Whole));
    columns.extend(inputs().map(|(name, numeric)| {
        (name.to_owned(), if *numeric { Holds::Real } else { Holds::Text })
    }));
    columns.extend(["status", "reason"].map(named));
    columns.push(("simulated".to_owned(), Holds::OptionalReal));
    columns.extend(campaign.figures().map(|name| (name.to_owned(), Holds::OptionalReal)));
    columns.push(("digest".to_owned(), Holds::UniqueText));
    columns.push(("cpu_ms".to_owned(), Holds::OptionalReal));
    let about = [
        ("cosim.version", env!("CARGO_PKG_VERSION").to_owned()),
        ("cosim.campaign", campaign.file.display().to_string()),
        ("cosim.seed", campaign.seed.to_string()),
        ("cosim.identity", identity.join("\n")),
    ];
    let about = about.into_iter().map(|(key, value)| (key.to_owned(), value));
    // These are shared by all rows that have them.
    let named = campaign.cells.iter().map(|cell| {
        let (system, scenario) =
            (&campaign.systems[cell.system], &campaign.scenarios[cell.scenario]);
        let replacement = &campaign.replacements[cell.replacement];
        [&*cell.name, &*system.0, &*replacement.name, &*scenario.0].map(ByteArray::from)
    });
    let named: Vec<[ByteArray; 4]> = named.collect();
    let words = Status::ALL.map(|status| ByteArray::from(status.word()));
    let mut table = Table::new(output, columns, about)?;
    groups(campaign, log, rows, |order, lines: &[Rest]| {
        let input = |place| lines.iter().map(move |row| at(&row.inputs, place));
        let name = |place: usize| {
            let names = lines.iter().map(|row| named[campaign.cell_of(row.run)][place].clone());
            Values::Text(names.collect())
        };
        let mut table = table.begin()?;
        table.add(whole(lines.iter().map(|row| row.run)))?;
        (0..4).try_for_each(|place| table.add(name(place)))?;
        let replicate = |row: &Rest| campaign.replicate_of(row.run) as u64;
        table.add(whole(lines.iter().map(replicate)))?;
        for (place, (_, numeric)) in inputs().enumerate() {
            table.add(match numeric {
                true => Values::Real(input(place).filter_map(|text| text.parse().ok()).collect()),
                false => text(input(place)),
            })?;
        }
        let statuses = lines.iter().map(|row| words[row.status as usize].clone());
        table.add(Values::Text(statuses.collect()))?;
        table.add(text(lines.iter().map(|row| &*row.reason)))?;
        table.add(real(lines.iter().map(|row| row.simulated.0)))?;
        for place in 0..campaign.figures.len() {
            table.add(real(rows.figure_of(place, order).map_err(unread)?.into_iter()))?;
        }
        let digests = lines.iter().map(|row| row.digest.to_string().into_bytes().into());
        table.add(Values::Text(digests.collect()))?;
        table.add(real(lines.iter().map(|row| row.cpu_ms.0)))?;
        table.end()
    })?;
    table.finish()?;
    table.output().flush().map_err(ParquetError::from)
}

/// A row without its figures, which are columns.
#[derive(Deserialize)]
struct Rest {
    run: u64,
    status: Status,
    reason: Box<str>,
    inputs: Box<[Box<str>]>,
    simulated: Number,
    digest: RowDigest,
    cpu_ms: Number,
}

/// Passes the lines of rows that belong to the campaign to `each`, with their positions, in order,
/// group by group. While one is written, the next one is read.
fn groups<T: DeserializeOwned + Send>(
    campaign: &Campaign,
    log: &Log,
    rows: &Rows,
    mut each: impl FnMut(&[usize], &[T]) -> Written<()>,
) -> Written<()> {
    let order = rows.in_order(campaign.runs());
    thread::scope(|scope| {
        let (send, read) = mpsc::sync_channel(0);
        let groups = order.chunks(GROUP);
        let mut lines = groups.clone().map(|group| log.rows(&rows.places(group)));
        scope.spawn(move || lines.try_for_each(|lines| send.send(lines)));
        read.into_iter()
            .zip(groups)
            .try_for_each(|(lines, group)| each(group, &lines.map_err(unread)?))
    })
}

fn unread(why: Error) -> ParquetError {
    ParquetError::External(Box::new(why))
}

fn at(values: &[Box<str>], place: usize) -> &str {
    values.get(place).map_or("", |value| value)
}

fn whole(values: impl Iterator<Item = u64>) -> Values {
    Values::Whole(values.map(|value| value as i64).collect())
}

fn text<'a>(values: impl Iterator<Item = &'a str>) -> Values {
    Values::Text(values.map(ByteArray::from).collect())
}

/// NaN is missing.
fn real(values: impl Iterator<Item = f64>) -> Values {
    Values::OptionalReal(values.map(|value| (!value.is_nan()).then_some(value)).collect())
}

/// As CSV.
pub(super) fn csv(
    campaign: &Campaign,
    log: &Log,
    rows: &Rows,
    mut output: impl Write,
) -> Written<()> {
    let inputs: Vec<&str> = campaign.inputs().collect();
    let names = ["run", "cell", "replicate"].into_iter().chain(inputs.iter().copied());
    let names = names.chain(["status", "reason", "simulated"]).chain(campaign.figures());
    let names: Vec<String> = names.chain(["digest", "cpu_ms"]).map(quoted).collect();
    writeln!(output, "{}", names.join(","))?;
    let line = |row: &Row| {
        let cell = campaign.cell_name(campaign.cell_of(row.run));
        let mut cells =
            vec![row.run.to_string(), quoted(cell), campaign.replicate_of(row.run).to_string()];
        cells.extend((0..inputs.len()).map(|place| quoted(at(&row.inputs, place))));
        cells.extend([row.status.word().to_owned(), quoted(&row.reason), known(row.simulated)]);
        cells.extend(
            (0..campaign.figures.len())
                .map(|place| row.figures.get(place).map(Number::to_string).unwrap_or_default()),
        );
        cells.extend([row.digest.to_string(), known(row.cpu_ms)]);
        cells.join(",")
    };
    groups(campaign, log, rows, |_, rows: &[Row]| {
        rows.iter().try_for_each(|row| Ok(writeln!(output, "{}", line(row))?))
    })?;
    Ok(output.flush()?)
}

/// Empty if it is missing.
fn known(number: Number) -> String {
    if number.0.is_nan() { String::new() } else { number.to_string() }
}

/// As a cell of a table.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\"").replace('\n', " "))
    } else {
        text.to_owned()
    }
}
