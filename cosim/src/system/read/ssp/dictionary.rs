//! Signal dictionaries: buses whose signals can be used at any depth below their system.
//!
//! A signal is a connector that belongs to no element: when one connection writes it, all that read
//! it get the value. A reference makes a dictionary of its own system, or of an enclosing one, an
//! element.

use std::path::Path;

use super::{Reader, TOP, join};
use crate::error::{Code, Error, Result};
use crate::names;
use crate::system::raw::RawConnector;
use crate::units;
use crate::xml::{self, Element};

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
            (None, Some(inline)) => self.signals(inline, &key),
            (Some(source), None) => {
                let place = self.place(element);
                let file = self.base.open(source, &place)?;
                let root =
                    xml::read(&file, &file).map_err(|e| e.help(format!("named in {place}")))?;
                let units = units::read(root.grandchildren("Units"), &file, Code::Ssd)?;
                let mut other = Reader {
                    file: file.as_path().into(),
                    base: self.base.of_neighbour(Path::new(&file)),
                    units,
                    gathered: self.gathered,
                    nested: self.nested,
                };
                other.signals(&root, &key)
            }
            _ => Err(self.wrong(element, "a dictionary is either inline or in a file")),
        }
    }

    fn signals(&mut self, dictionary: &Element, key: &str) -> Result<()> {
        if dictionary.name != "SignalDictionary" {
            let what = format!("<{}> where <SignalDictionary> belongs", dictionary.name);
            return Err(self.wrong(dictionary, what));
        }
        self.version(dictionary)?;
        let children =
            ["DictionaryEntry", "Enumerations", "Units", "Annotations", "MetaData", "Signature"];
        self.known(dictionary, &children, TOP);
        for entry in dictionary.children.iter().filter(|c| c.name == "DictionaryEntry") {
            let name = entry.require("name", &self.file, Code::Ssd)?;
            let typed = entry.children.iter().find(|c| c.name != "Annotations");
            let signal = RawConnector {
                name: name.to_owned(),
                kind: "signal".to_owned(),
                kind_of_value: typed.map(|typed| typed.name.to_string()),
                unit: typed.and_then(|typed| self.unit(typed)),
                place: self.place(entry),
            };
            self.nested.ports.insert((key.to_owned(), name.to_owned()), signal);
        }
        Ok(())
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
