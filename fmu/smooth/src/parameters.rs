//! Parameters of a filter by their names in its FMU.

use crate::names;
use anyhow::{Context, Result, anyhow, bail};
use fmu_kit::{Count, Declaration, Declarations, Field, Reader, Start, Variables, Writer};
use rexrov_fmu::navigator::Navigator;
use serde_json::{Map, Value};
use std::ffi::CString;
use std::fs;
use std::path::Path;

/// The start values, with the overrides of a file.
pub(crate) fn read<N: Navigator>(file: Option<&Path>) -> Result<N::Parameters> {
    let chosen = match file {
        None => Map::new(),
        Some(file) => {
            let shown = || file.display().to_string();
            let text = fs::read_to_string(file).with_context(shown)?;
            let object = "expected an object: {\"dvl_sigma\": 0.02}";
            match serde_json::from_str(&text).with_context(shown)? {
                Value::Object(chosen) => chosen,
                _ => bail!("{}: {object}", shown()),
            }
        }
    };
    let parameters = choose::<N>(&chosen);
    parameters.map_err(|error| match file {
        Some(file) => error.context(file.display().to_string()),
        None => error,
    })
}

fn choose<N: Navigator>(chosen: &Map<String, Value>) -> Result<N::Parameters> {
    let mut selected = Flat::of(&N::Parameters::default());
    selected.set(chosen, N::INFO.name)?;
    // A named set gives every value that is not set explicitly.
    let mut complete = Flat::of(&N::preset(&selected.load()));
    complete.set(chosen, N::INFO.name)?;
    Ok(complete.load())
}

/// The values of a struct, one after the other, and their positions.
struct Flat {
    places: Declarations,
    reals: Vec<f64>,
    integers: Vec<i32>,
    booleans: Vec<bool>,
    strings: Vec<CString>,
}

impl Flat {
    fn of<V: Variables>(values: &V) -> Self {
        let Count { reals, integers, booleans, strings } = V::COUNT;
        let mut flat = Self {
            places: Declarations::new(),
            reals: vec![0.0; reals],
            integers: vec![0; integers],
            booleans: vec![false; booleans],
            strings: vec![CString::default(); strings],
        };
        values.declare(&Field::default(), &mut flat.places);
        values.store(&mut Writer {
            reals: &mut flat.reals,
            integers: &mut flat.integers,
            booleans: &mut flat.booleans,
            strings: &mut flat.strings,
        });
        flat
    }

    fn load<V: Variables>(&self) -> V {
        V::load(&mut Reader {
            reals: &self.reals,
            integers: &self.integers,
            booleans: &self.booleans,
            strings: &self.strings,
        })
    }

    fn set(&mut self, chosen: &Map<String, Value>, filter: &str) -> Result<()> {
        for (name, value) in chosen {
            self.set_one(name, value, filter)?;
        }
        Ok(())
    }

    fn set_one(&mut self, name: &str, value: &Value, filter: &str) -> Result<()> {
        let Some(place) = self.places.iter().position(|p| p.field.name == name) else {
            let all: Vec<&str> = self.places.iter().map(|p| p.field.name.as_str()).collect();
            bail!("'{name}' is not a parameter of {filter}; {}", names::hint(name, &all));
        };
        let start = self.places[place].start.clone();
        let same = |p: &&Declaration| list(&p.start) == list(&start);
        let index = self.places[..place].iter().filter(same).count();
        let unfit =
            |expected: &str| anyhow!("parameter '{name}': expected {expected}, not {value}");
        match &start {
            Start::Real(_) => {
                self.reals[index] = value.as_f64().ok_or_else(|| unfit("a number"))?;
            }
            Start::Integer(_) => {
                self.integers[index] = integer(value).ok_or_else(|| unfit("an integer"))?
            }
            Start::Boolean(_) => {
                self.booleans[index] = value.as_bool().ok_or_else(|| unfit("true or false"))?;
            }
            Start::String(_) => {
                let text = value.as_str().and_then(|text| CString::new(text).ok());
                self.strings[index] = text.ok_or_else(|| unfit("a text"))?;
            }
            Start::Enumeration { items, .. } => {
                let named = |text: &str| items.iter().position(|(item, _)| *item == text);
                let item = match value.as_str() {
                    Some(text) => named(text).map(|i| i as i32 + 1),
                    None => integer(value).filter(|i| (1..=items.len() as i32).contains(i)),
                };
                let all: Vec<&str> = items.iter().map(|(item, _)| *item).collect();
                self.integers[index] = item.ok_or_else(|| unfit(&all.join(", ")))?;
            }
        }
        Ok(())
    }
}

fn integer(value: &Value) -> Option<i32> {
    value.as_i64().and_then(|i| i32::try_from(i).ok())
}

/// Which of the lists contains a value.
fn list(start: &Start) -> u8 {
    match start {
        Start::Real(_) => 0,
        Start::Integer(_) | Start::Enumeration { .. } => 1,
        Start::Boolean(_) => 2,
        Start::String(_) => 3,
    }
}
