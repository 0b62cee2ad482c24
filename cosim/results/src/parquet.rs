//! Results as Apache Parquet: the column `time` (s) and one for each variable, as read by DuckDB,
//! pandas and polars.

mod fields;
mod pages;

pub use pages::check_footer;

use std::io::Write;
use std::path::{Path, PathBuf};

use ::parquet::basic::Compression;
use ::parquet::column::reader::ColumnReader;
use ::parquet::data_type::ByteArray;
use ::parquet::errors::{ParquetError, Result as Written};
use ::parquet::file::metadata::ColumnChunkMetaData;
use ::parquet::file::reader::{FileReader, SerializedFileReader};

use crate::UNWRITTEN;
use crate::columns::{Holds, Table, Values};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files::{self, Durable};
use cosim_base::texts;
use cosim_base::time::Time;
use cosim_base::units::recorded::{self, UNITS};
use cosim_core::observe::{Form, Observer, Recording, RunInfo};
use cosim_core::system::Column;

/// First and last bytes of a file.
const MAGIC: &[u8] = b"PAR1";
/// Number of values in a row group: a group is kept in memory.
const GROUP: usize = 1 << 20;

/// Writes results while they arrive, one row group at a time. The file of a run that was killed
/// cannot be read; that of a run that failed can.
pub struct ParquetRecorder {
    target: PathBuf,
    output: Option<Durable>,
    table: Option<Table<Durable>>,
    forms: Vec<Form>,
    /// The newest rows: the time and the values.
    rows: Vec<f64>,
}

impl ParquetRecorder {
    /// Creates `file`, replacing an existing one.
    pub fn create(file: impl AsRef<Path>) -> Result<Self> {
        let target = file.as_ref().to_owned();
        Ok(Self::on(files::create(&target, UNWRITTEN)?, target))
    }

    pub(super) fn on(output: Durable, target: PathBuf) -> Self {
        let output = Some(output);
        Self { target, output, table: None, forms: Vec::new(), rows: Vec::new() }
    }

    fn written(&self, outcome: Written<()>) -> Result<()> {
        outcome.map_err(|e| Error::new(Code::Output, UNWRITTEN).at(&self.target).why(e))
    }

    fn group(&mut self) -> Written<()> {
        let width = self.forms.len() + 1;
        let Some(table) = self.table.as_mut().filter(|_| !self.rows.is_empty()) else {
            return Ok(());
        };
        let rows = &self.rows;
        let column = |place: usize| rows.iter().skip(place).step_by(width).copied();
        let time = Values::Real(column(0).collect());
        let others = self.forms.iter().zip(1..).map(|(form, place)| match form {
            Form::Real => Values::Real(column(place).collect()),
            Form::Whole => Values::Whole(column(place).map(|value| value as i64).collect()),
            Form::Text => Values::Text(
                column(place).map(|value| ByteArray::from(&*texts::text(value))).collect(),
            ),
        });
        table.group([time].into_iter().chain(others))?;
        self.rows.clear();
        Ok(())
    }
}

impl Observer for ParquetRecorder {
    fn start(&mut self, info: &RunInfo<'_>) -> Result<()> {
        self.forms = info.columns.iter().map(|column| Form::of(&column.kind)).collect();
        let Some(output) = self.output.take() else { return Ok(()) };
        let others = info.columns.iter().zip(&self.forms).map(|(column, form)| {
            let holds = match form {
                Form::Real => Holds::Real,
                Form::Whole => Holds::Whole,
                Form::Text => Holds::Text,
            };
            (column.name.clone(), holds)
        });
        let columns = [("time".to_owned(), Holds::Real)].into_iter().chain(others);
        let units = recorded::text(info.columns.iter().filter_map(Column::name_and_unit));
        let about = [("system".to_owned(), info.name.to_owned()), (UNITS.to_owned(), units)];
        let table = Table::new(output, columns, about)
            .map_err(|e| Error::new(Code::Output, UNWRITTEN).at(&self.target).why(e))?;
        self.table = Some(table);
        Ok(())
    }

    fn sample(&mut self, time: Time, values: &[f64]) -> Result<()> {
        self.rows.push(time.seconds());
        self.rows.extend_from_slice(values);
        if self.rows.len() < GROUP {
            return Ok(());
        }
        let outcome = self.group();
        self.written(outcome)
    }

    fn finish(&mut self) -> Result<()> {
        let mut outcome = self.group();
        if let (Ok(()), Some(table)) = (&outcome, &mut self.table) {
            outcome =
                table.finish().and_then(|()| table.output().flush().map_err(ParquetError::from));
        }
        self.written(outcome)
    }
}

/// Bytes of numbers, and of Strings, that are read at most, for each byte of the file and in
/// addition to that: a page of a few bytes can stand for 2^31 equal values.
const PER_BYTE: u64 = 256;
const ANYWAY: u64 = 16 << 20;
/// Values that are read at once; of Strings, which may each be as long as a page, as many as fit
/// into `ANYWAY`.
const BATCH: usize = 1 << 16;

/// Reads results, also of other programs, if their first column is `time` and all columns are flat
/// and contain numbers or Strings.
pub(super) fn read(path: &Path) -> Result<Recording> {
    let unread =
        |why: String| Error::new(Code::Results, "the results cannot be read").at(path).why(why);
    let broken = |e: ParquetError| unread(e.to_string());
    let content = files::read_input(path).map_err(|e| unread(e.to_string()))?;
    if content.is_empty() {
        return Err(unread("the file is empty".into()));
    }
    if content.starts_with(MAGIC) && !content.ends_with(MAGIC) {
        return Err(unread("its end is missing, and with it the positions of all columns".into())
            .help("repeat the run; CSV and MCAP can be read as far as they were written"));
    }
    let size = content.len() as u64;
    check_footer(&content).map_err(|e| unread(e.to_string()))?;
    let file = std::fs::File::open(path).map_err(|e| unread(e.to_string()))?;
    let reader = SerializedFileReader::new(file).map_err(broken)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let all = schema.columns();
    let mut names: Vec<String> = all.iter().map(|column| column.name().to_owned()).collect();
    if names.first().is_none_or(|name| name != "time") {
        return Err(unread("its first column is not called 'time'".to_owned()));
    }
    if let Some(nested) = all.iter().find(|column| column.max_rep_level() > 0) {
        return Err(unread(format!("column '{}' holds lists", nested.name())));
    }
    let groups = reader.metadata().row_groups();
    let parts = || groups.iter().flat_map(|group| group.columns());
    let packed = parts().map(|column| column.compressed_size().max(0) as u64);
    if packed.fold(0, u64::saturating_add) > size {
        return Err(unread("its columns share bytes, or reach beyond its end".to_owned()));
    }
    let mut largest = 0;
    for column in parts().filter(|column| is_unpacked(column)) {
        let pages = part(&content, column).ok_or_else(|| unread("a column is not in it".into()))?;
        largest = pages::largest(pages).map_err(|e| unread(e.to_string()))?.max(largest);
    }
    drop(content);
    let rows = groups.iter().map(|group| group.num_rows().max(0) as u64);
    let rows = rows.fold(0, u64::saturating_add);
    let bytes = rows.saturating_mul(8 * all.len() as u64);
    let most = size.saturating_mul(PER_BYTE).saturating_add(ANYWAY);
    if bytes > most {
        let count = all.len();
        return Err(unread(format!("{size} bytes claim to hold {rows} rows of {count} columns"))
            .help("if they do, write the results as CSV or MCAP"));
    }
    let mut forms = vec![Form::Real; all.len()];
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); all.len()];
    let batch = usize::try_from(ANYWAY / largest.max(1)).map_or(BATCH, |fit| fit.clamp(1, BATCH));
    let mut limits = Limits { batch, texts: most };
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(broken)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        for (place, column) in columns.iter_mut().enumerate() {
            let own = group.get_column_reader(place).map_err(broken)?;
            forms[place] = read_column(own, rows, all[place].max_def_level(), &mut limits, column)
                .map_err(|e| unread(format!("column '{}': {e}", names[place])))?;
        }
    }
    let length = columns[0].len();
    if let Some(place) = columns.iter().position(|column| column.len() != length) {
        return Err(unread(format!("column '{}' differs in length from 'time'", names[place])));
    }
    let time = columns.remove(0);
    names.remove(0);
    forms.remove(0);
    let about = reader.metadata().file_metadata().key_value_metadata();
    let text = about.and_then(|all| all.iter().find(|entry| entry.key == UNITS)?.value.as_deref());
    let units = recorded::read(text.unwrap_or_default(), names.iter());
    Ok(Recording::from_columns(names, time, columns).with_forms(forms).with_units(units))
}

/// The pages of a column in a group.
fn part<'c>(content: &'c [u8], column: &ColumnChunkMetaData) -> Option<&'c [u8]> {
    let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
    let start = usize::try_from(start).ok()?;
    let length = usize::try_from(column.compressed_size()).ok()?;
    content.get(start..start.checked_add(length)?)
}

/// Whether the library unpacks its pages; it refuses those with other compression.
fn is_unpacked(column: &ColumnChunkMetaData) -> bool {
    matches!(column.compression(), Compression::UNCOMPRESSED | Compression::SNAPPY)
}

/// What is left for the columns of a file.
struct Limits {
    /// Values that are read at once.
    batch: usize,
    /// Bytes of Strings.
    texts: u64,
}

/// Appends the values of a column in a group; NaN if there is none.
fn read_column(
    reader: ColumnReader,
    rows: usize,
    depth: i16,
    limits: &mut Limits,
    column: &mut Vec<f64>,
) -> Written<Form> {
    /// A value as it is recorded.
    macro_rules! read {
        ($reader:ident, $form:expr, $batch:expr, $number:expr) => {{
            let (mut values, mut levels, mut left) = (Vec::new(), Vec::new(), rows);
            while left > 0 {
                let batch = left.min($batch);
                let (records, ..) =
                    $reader.read_records(batch, Some(&mut levels), None, &mut values)?;
                if records == 0 {
                    break;
                }
                left -= records;
                let mut values = values.drain(..).map($number);
                match depth {
                    0 => column.extend(values),
                    _ => column.extend(levels.drain(..).map(|level| {
                        let value = if level == depth { values.next() } else { None };
                        value.unwrap_or(f64::NAN)
                    })),
                }
                if limits.texts == 0 {
                    return Err(ParquetError::General("its Strings are too long".to_owned()));
                }
            }
            Ok($form)
        }};
    }
    match reader {
        ColumnReader::DoubleColumnReader(mut r) => read!(r, Form::Real, BATCH, |v| v),
        ColumnReader::FloatColumnReader(mut r) => read!(r, Form::Real, BATCH, f64::from),
        ColumnReader::Int64ColumnReader(mut r) => read!(r, Form::Whole, BATCH, |v| v as f64),
        ColumnReader::Int32ColumnReader(mut r) => read!(r, Form::Whole, BATCH, f64::from),
        ColumnReader::BoolColumnReader(mut r) => {
            read!(r, Form::Whole, BATCH, |v| f64::from(u8::from(v)))
        }
        ColumnReader::ByteArrayColumnReader(mut r) => {
            read!(r, Form::Text, limits.batch, |v: ByteArray| {
                limits.texts = limits.texts.saturating_sub(v.len() as u64);
                texts::number(v.as_utf8().unwrap_or_default())
            })
        }
        _ => Err(ParquetError::General("it holds neither numbers nor Strings".to_owned())),
    }
}
