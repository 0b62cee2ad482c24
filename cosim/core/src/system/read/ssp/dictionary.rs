//! Signal dictionaries: buses whose signals can be used at any depth below their system.
//!
//! A signal is a connector that belongs to no element: when one connection writes it, all that read
//! it get the value. A reference makes a dictionary of its own system, or of an enclosing one, an
//! element.

use std::path::PathBuf;
use std::sync::Arc;

use super::{Reader, TOP, join};
use crate::system::raw::RawConnector;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::units;
use cosim_base::xml::Element;

const TYPE: &str = "application/x-ssp-signal-dictionary";

impl Reader<'_> {
    /// The dictionaries of a system.
    pub(super) fn dictionaries(&mut self, system: &Element, path: &str) {
        for element in self.list(system, "SignalDictionaries", "SignalDictionary") {
            let done = self.dictionary(element, path);
            self.gathered.take(done);
        }
    }

    fn dictionary(&mut self, element: &Element, path: &str) -> Result<()> {
        self.known(element, &["SignalDictionary"], &["name", "type", "source"]);
        let name = element.require("name", &self.file, Code::Ssd)?;
        if let Some(other) = element.get("type").filter(|&kind| kind != TYPE) {
            return Err(self.wrong(element, format!("the type of '{name}' is \"{other}\"")));
        }
        // No element has this name, so its signals do not belong to any element.
        let key = format!("dictionary {}", join(path, name));
        self.nested.dictionaries.insert((path.to_owned(), name.to_owned()), key.clone());
        match (element.get("source"), element.child("SignalDictionary")) {
            (None, Some(inline)) => {
                let signals = self.signals(inline)?;
                self.add_signals(signals, &key, element)
            }
            (Some(source), None) => {
                let file = self.base.open(source, &self.place(element))?;
                let signals = match self.nested.dictionary_files.get(&file) {
                    Some(read) => read.clone(),
                    None => self.signals_in_file(element, file)?,
                };
                self.spend(signals.iter().map(RawConnector::size).sum(), element)?;
                self.add_signals(signals.iter().cloned(), &key, element)
            }
            _ => Err(self.wrong(element, "a dictionary is either inline or in a file")),
        }
    }

    fn add_signals(
        &mut self,
        signals: impl IntoIterator<Item = RawConnector>,
        key: &str,
        element: &Element,
    ) -> Result<()> {
        for signal in signals {
            self.spend(key.len() + signal.name.len(), element)?;
            self.nested.ports.insert((key.to_owned(), signal.name.clone()), signal);
        }
        Ok(())
    }

    fn signals_in_file(&mut self, element: &Element, file: PathBuf) -> Result<Arc<[RawConnector]>> {
        let base = self.base.of_neighbour(&file);
        let (root, mut other) = self.follow(element, base, &file)?;
        other.units = units::read(root.grandchildren("Units"), &file, Code::Ssd)?;
        let signals: Arc<[RawConnector]> = other.signals(&root)?.into();
        self.nested.dictionary_files.insert(file, signals.clone());
        Ok(signals)
    }

    fn signals(&mut self, dictionary: &Element) -> Result<Vec<RawConnector>> {
        if dictionary.name != "SignalDictionary" {
            let what = format!("<{}> where <SignalDictionary> belongs", dictionary.name);
            return Err(self.wrong(dictionary, what));
        }
        self.version(dictionary)?;
        let children =
            ["DictionaryEntry", "Enumerations", "Units", "Annotations", "MetaData", "Signature"];
        self.known(dictionary, &children, TOP);
        let mut signals = Vec::new();
        for entry in dictionary.children.iter().filter(|c| c.name == "DictionaryEntry") {
            let name = entry.require("name", &self.file, Code::Ssd)?;
            let typed = entry.children.iter().find(|c| c.name != "Annotations");
            signals.push(RawConnector {
                name: name.to_owned(),
                kind: "signal".to_owned(),
                kind_of_value: typed.map(|typed| typed.name.to_string()),
                unit: typed.and_then(|typed| self.unit(typed)),
                place: self.place(entry),
            });
        }
        Ok(signals)
    }

    /// An element that represents a dictionary of its system or of an enclosing one.
    pub(super) fn reference(&mut self, element: &Element, path: &str) -> Result<()> {
        let children = ["Connectors", "ElementGeometry", "ParameterBindings", "Annotations"];
        self.known(element, &children, &["name", "dictionary"]);
        let name = element.require("name", &self.file, Code::Ssd)?;
        let dictionary = element.require("dictionary", &self.file, Code::Ssd)?;
        let known = &self.nested.dictionaries;
        let around = self.nested.around.iter().rev();
        let mut found = around.filter_map(|p| known.get(&(p.clone(), dictionary.to_owned())));
        let Some(key) = found.next().cloned() else {
            let all = known.keys().map(|(_, name)| name.as_str());
            let what = format!("there is no signal dictionary '{dictionary}'");
            return Err(Error::new(Code::UnknownName, what)
                .at_line(&self.file, element.line)
                .maybe_help(names::did_you_mean(dictionary, all)));
        };
        self.nested.references.insert(join(path, name), key);
        Ok(())
    }
}
