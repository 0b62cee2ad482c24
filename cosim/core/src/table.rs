//! Reads TOML tables manually: every mistake is reported with its line, a typo with the nearest
//! key.

use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::time::{self, Time};

/// A TOML file and its problems.
pub struct Document<'a> {
    file: &'a Path,
    text: &'a str,
    code: Code,
    problems: RefCell<Vec<Error>>,
}

/// A table of a document.
#[derive(Clone)]
pub struct Table<'d> {
    document: &'d Document<'d>,
    table: &'d DeTable<'d>,
    /// Its name in messages.
    name: String,
    line: usize,
}

/// A value with its key.
#[derive(Clone)]
pub struct Entry<'d> {
    document: &'d Document<'d>,
    /// Its name in messages.
    pub name: String,
    value: &'d DeValue<'d>,
    /// Its line, from 1.
    pub line: usize,
}

impl<'a> Document<'a> {
    /// The text of a file; `code` is the kind of its errors.
    pub fn new(text: &'a str, file: &'a Path, code: Code) -> Self {
        Self { file, text, code, problems: RefCell::default() }
    }

    /// The document as a tree, for [`Document::root`].
    pub fn parse(&self) -> Result<Spanned<DeTable<'a>>> {
        DeTable::parse(self.text).map_err(|e| {
            let line = e.span().map_or(1, |span| self.line(&span));
            Error::new(self.code, "the file is not TOML").at_line(self.file, line).why(e.message())
        })
    }

    /// The table of the whole document.
    pub fn root<'d>(&'d self, parsed: &'d Spanned<DeTable<'a>>) -> Table<'d> {
        Table { document: self, table: parsed.get_ref(), name: "the file".to_owned(), line: 1 }
    }

    fn line(&self, span: &Range<usize>) -> usize {
        self.text[..span.start.min(self.text.len())].matches('\n').count() + 1
    }

    /// Notes a problem.
    pub fn wrong(&self, line: usize, what: impl Into<String>) {
        self.note(Error::new(self.code, what).at_line(self.file, line));
    }

    /// Notes a problem that already has its text.
    pub fn note(&self, problem: Error) {
        self.problems.borrow_mut().push(problem);
    }

    /// All recorded problems.
    pub fn finish(&self) -> Result<()> {
        Error::all(self.problems.take())
    }
}

impl<'d> Table<'d> {
    /// Notes a problem of this table.
    pub fn wrong(&self, what: impl std::fmt::Display) {
        self.document.wrong(self.line, format!("{}: {what}", self.name));
    }

    /// Sets its name in messages.
    pub(crate) fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Notes every key that is not one of these.
    pub fn allow(&self, known: &[&str]) {
        for key in self.table.keys() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let help = names::did_you_mean(name, known.iter().copied())
                    .unwrap_or_else(|| format!("known are {}", known.join(", ")));
                let line = self.document.line(&key.span());
                self.document.wrong(line, format!("{}: '{name}' is unknown; {help}", self.name));
            }
        }
    }

    /// All values with their keys, in alphabetical order.
    pub fn entries(&self) -> impl Iterator<Item = (&'d str, Entry<'d>)> + use<'d> {
        let document = self.document;
        self.table.iter().map(move |(key, value)| {
            let name: &str = key.get_ref();
            let line = document.line(&key.span());
            let value = value.get_ref();
            (name, Entry { document, name: format!("'{name}'"), value, line })
        })
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<Entry<'d>> {
        let (_, mut entry) = self.entries().find(|(name, _)| *name == key)?;
        entry.name = format!("{}: '{key}'", self.name);
        Some(entry)
    }

    fn needed<T>(&self, key: &str, found: Option<T>) -> Option<T> {
        if found.is_none() && self.get(key).is_none() {
            self.wrong(format!("'{key}' is missing"));
        }
        found
    }

    /// An optional number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.get(key)?.number()
    }

    /// A required number.
    pub fn needed_number(&self, key: &str) -> Option<f64> {
        self.needed(key, self.number(key))
    }

    /// An optional number greater than zero.
    pub fn positive(&self, key: &str) -> Option<f64> {
        let entry = self.get(key)?;
        let number = entry.number()?;
        if number > 0.0 && number.is_finite() {
            return Some(number);
        }
        entry.wrong(format!("{number} is not greater than 0"));
        None
    }

    /// A required number greater than zero.
    pub fn needed_positive(&self, key: &str) -> Option<f64> {
        self.needed(key, self.positive(key))
    }

    /// An optional non-negative integer.
    pub fn count(&self, key: &str) -> Option<u64> {
        self.get(key)?.count()
    }

    /// An optional instant or duration in seconds.
    pub(crate) fn time(&self, key: &str) -> Option<Time> {
        let entry = self.get(key)?;
        entry.seconds(entry.number()?)
    }

    /// An optional text.
    pub fn text(&self, key: &str) -> Option<&'d str> {
        self.get(key)?.text()
    }

    /// A required text.
    pub fn needed_text(&self, key: &str) -> Option<&'d str> {
        self.needed(key, self.text(key))
    }

    /// A text or a list of texts; empty if absent.
    pub fn texts(&self, key: &str) -> Vec<&'d str> {
        self.get(key).map(|entry| entry.texts()).unwrap_or_default()
    }

    /// An optional subtable.
    pub fn table(&self, key: &str) -> Option<Table<'d>> {
        self.get(key)?.table()
    }

    /// The tables `[[key]]`.
    pub fn tables(&self, key: &str) -> Vec<Table<'d>> {
        let Some(entry) = self.get(key) else { return Vec::new() };
        let parts = entry.list();
        let several = parts.len() > 1;
        let tables = parts.into_iter().enumerate().filter_map(|(place, part)| {
            let number = if several { format!(" {}", place + 1) } else { String::new() };
            Some(part.table()?.named(format!("{key}{number}")))
        });
        tables.collect()
    }
}

impl<'d> Entry<'d> {
    /// Notes a problem of this value.
    pub fn wrong(&self, what: impl std::fmt::Display) {
        self.document.wrong(self.line, format!("{}: {what}", self.name));
    }

    fn is_not<T>(&self, what: &str) -> Option<T> {
        self.wrong(format!("this is not a {what} but a {}", self.value.type_str()));
        None
    }

    /// As a number; Booleans are 0 and 1.
    pub fn number(&self) -> Option<f64> {
        let number = match self.value {
            DeValue::Integer(number) if number.radix() == 10 => number.as_str().parse().ok(),
            DeValue::Float(number) => number.as_str().parse().ok(),
            DeValue::Boolean(value) => Some(f64::from(u8::from(*value))),
            _ => None,
        };
        number.or_else(|| self.is_not("number"))
    }

    /// As a non-negative integer.
    pub(crate) fn count(&self) -> Option<u64> {
        match self.value {
            DeValue::Integer(number) if number.radix() == 10 => number.as_str().parse().ok(),
            _ => None,
        }
        .or_else(|| self.is_not("non-negative integer"))
    }

    /// As seconds.
    pub(crate) fn seconds(&self, number: f64) -> Option<Time> {
        time::from_seconds(number, &self.name).map_err(|e| self.wrong(e.what())).ok()
    }

    /// As text.
    pub fn text(&self) -> Option<&'d str> {
        match self.value {
            DeValue::String(text) => Some(text),
            _ => self.is_not("text"),
        }
    }

    /// As one text or a list of texts.
    pub fn texts(&self) -> Vec<&'d str> {
        self.list().iter().filter_map(Entry::text).collect()
    }

    /// As a list; anything else becomes a list of one.
    pub fn list(&self) -> Vec<Entry<'d>> {
        let DeValue::Array(parts) = self.value else { return vec![self.clone()] };
        let part = |part: &'d Spanned<DeValue<'d>>| Entry {
            document: self.document,
            name: self.name.clone(),
            line: self.document.line(&part.span()),
            value: part.get_ref(),
        };
        parts.iter().map(part).collect()
    }

    /// Whether it is a list.
    pub fn is_list(&self) -> bool {
        matches!(self.value, DeValue::Array(_))
    }

    /// Whether it is a table.
    pub fn is_table(&self) -> bool {
        matches!(self.value, DeValue::Table(_))
    }

    /// As a table.
    pub fn table(&self) -> Option<Table<'d>> {
        match self.value {
            DeValue::Table(table) => Some(Table {
                document: self.document,
                table,
                name: self.name.trim_start_matches("the file: ").to_owned(),
                line: self.line,
            }),
            _ => self.is_not("table"),
        }
    }

    /// As the start value of a parameter: a number, a Boolean or a text.
    pub fn start_value(&self) -> Option<String> {
        match self.value {
            DeValue::String(text) => Some(text.to_string()),
            DeValue::Boolean(value) => Some(value.to_string()),
            DeValue::Integer(number) => Some(number.as_str().to_owned()),
            DeValue::Float(number) => Some(number.as_str().to_owned()),
            _ => self.is_not("number, Boolean or text"),
        }
    }
}
