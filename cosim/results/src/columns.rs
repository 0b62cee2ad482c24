//! Tables of columns as Apache Parquet: results of runs, and rows of campaigns.
//!
//! Rows are stored in groups, each with a block for every column, compressed with Snappy. The index
//! of the groups is at the end of the file, so a file that was not closed cannot be read.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::Result;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{
    SerializedColumnWriter, SerializedFileWriter, SerializedRowGroupWriter,
};
use parquet::schema::types::{ColumnPath, Type};

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// `DOUBLE`.
    Real,
    /// `DOUBLE` that may be missing, and is hardly ever the same twice.
    OptionalReal,
    /// `INT64`.
    Whole,
    /// `BYTE_ARRAY` of UTF-8.
    Text,
    /// The same, where no text occurs twice.
    UniqueText,
}

impl Holds {
    /// Whether a dictionary of the values pays.
    fn repeats(self) -> bool {
        !matches!(self, Holds::OptionalReal | Holds::UniqueText)
    }

    /// Whether the least and the greatest value of a block say something about its values.
    fn is_ordered(self) -> bool {
        !matches!(self, Holds::Text | Holds::UniqueText)
    }
}

/// The values of a column in a group of rows.
pub enum Values {
    /// `DOUBLE`.
    Real(Vec<f64>),
    /// Missing values are `None`.
    OptionalReal(Vec<Option<f64>>),
    /// `INT64`.
    Whole(Vec<i64>),
    /// `BYTE_ARRAY` of UTF-8.
    Text(Vec<ByteArray>),
}

/// Writes a table, group by group.
pub struct Table<W: Write + Send>(SerializedFileWriter<W>);

impl<W: Write + Send> Table<W> {
    /// Begins a table with these columns; `about` is stored with it as key-value metadata.
    pub fn new(
        output: W,
        columns: impl IntoIterator<Item = (String, Holds)>,
        about: impl IntoIterator<Item = (String, String)>,
    ) -> Result<Self> {
        let mut properties = WriterProperties::builder();
        let fields = columns.into_iter().map(|(name, holds)| {
            let path = ColumnPath::from(vec![name.clone()]);
            let ordered = match holds.is_ordered() {
                true => EnabledStatistics::Chunk,
                false => EnabledStatistics::None,
            };
            properties = std::mem::take(&mut properties)
                .set_column_dictionary_enabled(path.clone(), holds.repeats())
                .set_column_statistics_enabled(path, ordered);
            let (physical, logical, repetition) = match holds {
                Holds::Real => (Physical::DOUBLE, None, Repetition::REQUIRED),
                Holds::OptionalReal => (Physical::DOUBLE, None, Repetition::OPTIONAL),
                Holds::Whole => (Physical::INT64, None, Repetition::REQUIRED),
                Holds::Text | Holds::UniqueText => {
                    (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED)
                }
            };
            Type::primitive_type_builder(&name, physical)
                .with_logical_type(logical)
                .with_repetition(repetition)
                .build()
                .map(Arc::new)
        });
        let fields = fields.collect::<Result<Vec<_>>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        let about = about.into_iter().map(|(key, value)| KeyValue::new(key, value)).collect();
        let properties = properties
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("cosim {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(about));
        SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties.build())).map(Self)
    }

    /// Writes a group of rows: all columns in order, with the same length.
    pub fn group(&mut self, columns: impl IntoIterator<Item = Values>) -> Result<()> {
        let mut group = self.begin()?;
        columns.into_iter().try_for_each(|values| group.add(values))?;
        group.end()
    }

    /// Begins a group of rows, to which columns are added one after another.
    pub fn begin(&mut self) -> Result<Group<'_, W>> {
        self.0.next_row_group().map(Group)
    }

    /// The output.
    pub fn output(&mut self) -> &mut W {
        self.0.inner_mut()
    }

    /// Writes the end.
    pub fn finish(&mut self) -> Result<()> {
        self.0.finish().map(drop)
    }
}

/// A group of rows.
pub struct Group<'a, W: Write + Send>(SerializedRowGroupWriter<'a, W>);

impl<W: Write + Send> Group<'_, W> {
    /// Adds the next column.
    pub fn add(&mut self, values: Values) -> Result<()> {
        match self.0.next_column()? {
            Some(mut column) => write(&mut column, values).and_then(|()| column.close()),
            None => Ok(()),
        }
    }

    /// Writes its end, after all columns.
    pub fn end(self) -> Result<()> {
        self.0.close().map(drop)
    }
}

fn write(column: &mut SerializedColumnWriter<'_>, values: Values) -> Result<()> {
    match (values, column.untyped()) {
        (Values::Real(values), ColumnWriter::DoubleColumnWriter(column)) => {
            column.write_batch(&values, None, None)
        }
        (Values::OptionalReal(values), ColumnWriter::DoubleColumnWriter(column)) => {
            let there: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
            let values: Vec<f64> = values.into_iter().flatten().collect();
            column.write_batch(&values, Some(&there), None)
        }
        (Values::Whole(values), ColumnWriter::Int64ColumnWriter(column)) => {
            column.write_batch(&values, None, None)
        }
        (Values::Text(values), ColumnWriter::ByteArrayColumnWriter(column)) => {
            column.write_batch(&values, None, None)
        }
        _ => return Err(parquet::errors::ParquetError::General("another type of column".into())),
    }
    .map(drop)
}
