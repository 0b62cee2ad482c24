//! The channels of recorded data: columns unchanged, and ROS messages made from them.
//!
//! Columns with a common prefix (`dvl.velocity.u`, `dvl.stamp`) are the fields of one message on
//! one topic (`/dvl`). A field name is adapted to ROS (`velocity_u`); the real names are in the
//! metadata of the channel with their units.

use std::collections::{BTreeMap, HashMap};

use super::cdr::Cdr;
use super::{Topics, identifier, unique};
use crate::roles::{Declaration, Measure, Names, Roles};
use cosim_base::error::Result;
use cosim_base::texts;
use cosim_base::time::Time;
use cosim_base::units::recorded::{self, UNITS};
use cosim_core::system::Column;
use cosim_import::Kind;

/// The metadata of a channel that contains columns: a line `position type name` for each.
pub const COLUMNS: &str = "cosim.columns";
/// The metadata of a channel whose messages are made from columns stored elsewhere.
pub const DERIVED: &str = "cosim.derived";

/// The declaration of a channel.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Without a leading slash.
    pub topic: String,
    /// The name of the type of its messages.
    pub schema_name: String,
    /// The type in the ROS message definition language.
    pub schema: String,
    pub(crate) metadata: BTreeMap<String, String>,
}

/// All channels of a run.
pub struct Channels {
    /// In the order of their numbers.
    pub all: Vec<Channel>,
    /// For each channel of columns: positions and types.
    fields: Vec<Vec<(usize, Field)>>,
    derived: Topics,
    message: Vec<u8>,
}

impl Channels {
    /// For a system with this name; the roles of variables are `roles`, or given by their names.
    pub fn new(system: &str, columns: &[Column], roles: Option<&Declaration>) -> Result<Self> {
        let mut topics: Vec<(&str, Vec<(usize, &Column)>)> = Vec::new();
        let mut known: HashMap<&str, usize> = HashMap::new();
        for (position, column) in columns.iter().enumerate() {
            let name = column.name.split_once('.').map_or(system, |(first, _)| first);
            let topic = *known.entry(name).or_insert_with(|| {
                topics.push((name, Vec::new()));
                topics.len() - 1
            });
            topics[topic].1.push((position, column));
        }
        let mut all: Vec<Channel> = topics.iter().map(|(name, own)| channel(name, own)).collect();
        let field = |(position, column): &(usize, &Column)| (*position, Field::of(&column.kind));
        let fields = topics.iter().map(|(_, own)| own.iter().map(field).collect()).collect();
        let names = Names::new(columns.iter().map(|column| column.name.as_str()));
        let measures: Vec<Measure> = columns.iter().map(Measure::of).collect();
        let derived = Topics::new(Roles::find(&names, &measures, roles)?);
        let mut taken = all.iter().map(|channel| (channel.topic.clone(), 0)).collect();
        for topic in derived.iter() {
            let (name, schema) = topic.schema();
            let metadata = BTreeMap::from([(DERIVED.to_owned(), "true".to_owned())]);
            let topic = unique(topic.name.clone(), &mut taken);
            all.push(Channel { topic, schema_name: name.to_owned(), schema, metadata });
        }
        Ok(Self { all, fields, derived, message: Vec::new() })
    }

    /// Shows `see` the messages of an instant with the positions of their channels.
    pub fn each<E>(
        &mut self,
        now: Time,
        row: &[f64],
        mut see: impl FnMut(usize, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        for (at, fields) in self.fields.iter().enumerate() {
            self.message.clear();
            let mut cdr = Cdr::new(&mut self.message);
            fields.iter().for_each(|(place, field)| field.encode(&mut cdr, row[*place]));
            see(at, &self.message)?;
        }
        let before = self.fields.len();
        self.derived.each(now, row, &mut self.message, |at, message| see(before + at, message))
    }
}

fn channel(name: &str, columns: &[(usize, &Column)]) -> Channel {
    let (mut schema, mut listed, mut taken) = (String::new(), String::new(), HashMap::new());
    for &(position, column) in columns {
        let field = Field::of(&column.kind);
        let short = column.name.strip_prefix(name).unwrap_or(&column.name);
        let short = unique(named(short, "value"), &mut taken);
        let unit = column.unit().map_or(String::new(), |unit| format!(" ({unit})"));
        schema += &format!("{} {short} # {}{unit}\n", field.name(), column.name);
        listed += &format!("{position} {} {}\n", field.name(), column.name);
    }
    let topic = named(name, "system");
    let mut initial = topic.clone();
    initial[..1].make_ascii_uppercase();
    let schema_name = format!("cosim/msg/{}", initial.replace('_', ""));
    let units = recorded::text(columns.iter().filter_map(|(_, column)| column.name_and_unit()));
    let metadata = BTreeMap::from([(COLUMNS.into(), listed), (UNITS.into(), units)]);
    Channel { topic, schema_name, schema, metadata }
}

/// A name as ROS allows it, or `otherwise` if nothing is left of it.
fn named(name: &str, otherwise: &str) -> String {
    let name = identifier(name);
    if name.is_empty() { otherwise.to_owned() } else { name }
}

/// The type of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// 64-bit floating point.
    Float64,
    /// 32-bit integer.
    Int32,
    /// Boolean.
    Bool,
    /// String.
    Text,
}

impl Field {
    pub(crate) const ALL: [Field; 4] = [Field::Float64, Field::Int32, Field::Bool, Field::Text];

    fn of(kind: &Kind) -> Self {
        match kind {
            Kind::Real => Field::Float64,
            Kind::String => Field::Text,
            Kind::Integer | Kind::Enumeration(_) => Field::Int32,
            Kind::Boolean => Field::Bool,
        }
    }

    /// ROS's name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Field::Float64 => "float64",
            Field::Int32 => "int32",
            Field::Bool => "bool",
            Field::Text => "string",
        }
    }

    /// Size in bytes, and alignment; for a String those of its length, which includes a trailing
    /// zero.
    pub(crate) fn size(self) -> usize {
        match self {
            Field::Float64 => 8,
            Field::Int32 | Field::Text => 4,
            Field::Bool => 1,
        }
    }

    /// Appends a value.
    fn encode(self, message: &mut Cdr<'_>, value: f64) {
        match self {
            Field::Float64 => message.float64(value),
            Field::Int32 => message.int32(value as i32),
            Field::Bool => message.bool(value != 0.0),
            Field::Text => message.string(&texts::text(value)),
        }
    }
}
