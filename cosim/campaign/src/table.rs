//! The rows of a campaign as tables: Parquet and CSV, one row per run, in the order of the runs.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::mpsc;
use std::thread;

use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result as Written};
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::row::Number;
use super::{Campaign, Row, Status};
use cosim_results::check_footer;
use cosim_results::columns::{Holds, Table, Values};

/// Rows of a row group: few, because groups are in memory while they are written.
const GROUP: usize = 1 << 13;

/// The rows that belong to the campaign, in order.
fn in_order<'r>(campaign: &Campaign, rows: &'r [Row]) -> Vec<&'r Row> {
    let mut rows: Vec<&Row> = rows.iter().filter(|row| row.run < campaign.runs()).collect();
    rows.sort_by_key(|row| row.run);
    rows
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
    rows: &[Row],
    identity: &[String],
    output: impl Write + Send,
) -> Written<()> {
    let rows = in_order(campaign, rows);
    let inputs: Vec<(&str, bool)> = campaign
        .inputs()
        .enumerate()
        .map(|(place, name)| {
            (name, rows.iter().all(|row| at(&row.inputs, place).parse::<f64>().is_ok()))
        })
        .collect();
    let named = |name: &str| (name.to_owned(), Holds::Text);
    let mut columns = vec![("run".to_owned(), Holds::Whole)];
    columns.extend(["cell", "system", "replacement", "scenario"].map(named));
    columns.push(("replicate".to_owned(), Holds::Whole));
    columns.extend(inputs.iter().map(|(name, numbers)| {
        ((*name).to_owned(), if *numbers { Holds::Real } else { Holds::Text })
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
    let group = |rows: &[&Row]| {
        let input = |place| rows.iter().map(move |row| at(&row.inputs, place));
        let mut values = vec![whole(rows.iter().map(|row| row.run))];
        values.extend((0..4).map(|place| {
            let names = rows.iter().map(|row| named[campaign.cell_of(row.run)][place].clone());
            Values::Text(names.collect())
        }));
        values.push(whole(rows.iter().map(|row| campaign.replicate_of(row.run) as u64)));
        values.extend(inputs.iter().enumerate().map(|(place, (_, numbers))| match numbers {
            true => Values::Real(input(place).filter_map(|text| text.parse().ok()).collect()),
            false => text(input(place)),
        }));
        let words = rows.iter().map(|row| words[row.status as usize].clone());
        values.push(Values::Text(words.collect()));
        values.push(text(rows.iter().map(|row| &*row.reason)));
        values.push(real(rows.iter().map(|row| row.simulated.0)));
        values.extend(
            (0..campaign.figures.len()).map(|place| real(rows.iter().map(|row| row.figure(place)))),
        );
        let digests = rows.iter().map(|row| row.digest.to_string().into_bytes().into());
        values.push(Values::Text(digests.collect()));
        values.push(real(rows.iter().map(|row| row.cpu_ms.0)));
        values
    };
    let mut table = Table::new(output, columns, about)?;
    // While a group is encoded, the next one is gathered.
    thread::scope(|scope| {
        let (send, groups) = mpsc::sync_channel(1);
        let (rows, group) = (&rows, &group);
        scope.spawn(move || rows.chunks(GROUP).try_for_each(|rows| send.send(group(rows))));
        groups.into_iter().try_for_each(|values| table.group(values))
    })?;
    table.finish()?;
    table.output().flush().map_err(ParquetError::from)
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
pub(super) fn csv(campaign: &Campaign, rows: &[Row]) -> String {
    let inputs: Vec<&str> = campaign.inputs().collect();
    let names = ["run", "cell", "replicate"].into_iter().chain(inputs.iter().copied());
    let names = names.chain(["status", "reason", "simulated"]).chain(campaign.figures());
    let names: Vec<String> = names.chain(["digest", "cpu_ms"]).map(quoted).collect();
    let mut text = names.join(",") + "\n";
    for row in in_order(campaign, rows) {
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
        text += &(cells.join(",") + "\n");
    }
    text
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
