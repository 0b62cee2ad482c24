//! Parameter bindings: values inline (`<ssd:ParameterValues>`) or in an .ssv file, with a prefix
//! and a mapping.

use std::path::Path;
use std::sync::Arc;

use super::element::of_fmi_2;
use super::{Reader, join};
use crate::error::{Code, Error, Result};
use crate::names;
use crate::system::raw::{RawParameter, RawUnit, Stage};
use crate::units::{self, Units};
use crate::xml::{self, Element};

use super::super::source::Base;

const KINDS: [&str; 5] = ["Real", "Integer", "Boolean", "String", "Enumeration"];

impl Reader<'_> {
    /// All values bound to `owner`, in the order of the file; later ones take precedence.
    pub(super) fn bindings(&mut self, element: &Element, owner: &str, component: Option<&Path>) {
        for binding in self.list(element, "ParameterBindings", "ParameterBinding") {
            let done = self.binding(binding, owner, component);
            self.gathered.take(done);
        }
    }

    fn binding(&mut self, binding: &Element, owner: &str, component: Option<&Path>) -> Result<()> {
        let children =
            ["ParameterValues", "ParameterMapping", "Annotations", "MetaData", "Signature"];
        self.known(binding, &children, &["type", "source", "sourceBase", "prefix"]);
        let kind = binding.get("type").unwrap_or("application/x-ssp-parameter-set");
        if kind != "application/x-ssp-parameter-set" {
            return Err(self.wrong(binding, format!("the type of the parameters is \"{kind}\"")));
        }
        let mapping = self.mapping(binding, component)?;
        let mut values = Vec::new();
        if let Some(source) = binding.get("source") {
            let (root, mut other) = self.follow(binding, source, component)?;
            other.set(&root, false, &mut values)?;
        }
        for set in binding.grandchildren("ParameterValues") {
            self.set(set, true, &mut values)?;
        }
        let prefix = binding.get("prefix").unwrap_or_default();
        for value in &mut values {
            value.name.insert_str(0, prefix);
        }
        if let Some(entries) = mapping {
            for entry in &entries {
                if !values.iter().any(|v| v.name == entry.source) {
                    let hint =
                        names::did_you_mean(&entry.source, values.iter().map(|v| v.name.as_str()));
                    self.gathered.warnings.push(format!(
                        "{}: the mapping names '{}', which the parameters do not have{}",
                        entry.place,
                        entry.source,
                        hint.map_or(String::new(), |hint| format!("; {hint}"))
                    ));
                }
            }
            values = mapped(&values, &entries);
        }
        for value in &mut values {
            value.name = join(owner, &value.name);
        }
        self.nested.parameters.extend(values);
        Ok(())
    }

    /// The root of the file that an element names as its source, and a reader for it.
    pub(super) fn follow(
        &mut self,
        element: &Element,
        source: &str,
        component: Option<&Path>,
    ) -> Result<(Element, Reader<'_>)> {
        let (base, at) = (self.base_of(element, component)?, self.place(element));
        let file = base.open(source, &at)?;
        let root = xml::read(&file, &file).map_err(|e| e.help(format!("named in {at}")))?;
        let reader = Reader {
            file: Arc::from(file.as_path()),
            base,
            units: Units::new(),
            gathered: self.gathered,
            nested: self.nested,
        };
        Ok((root, reader))
    }

    /// The base of a relative source.
    fn base_of(&self, element: &Element, component: Option<&Path>) -> Result<Base> {
        match (element.get("sourceBase"), component) {
            (None | Some("SSD"), _) => Ok(self.base.clone()),
            (Some("component"), Some(fmu)) if self.base.folder.is_some() => self.base_in(fmu),
            (Some("component"), _) => Err(self
                .wrong(element, "sourceBase=\"component\" without an FMU")
                .help("use a source relative to the file: sourceBase=\"SSD\"")),
            (Some(other), _) => Err(self
                .wrong(element, format!("sourceBase=\"{other}\""))
                .help("write SSD or component")),
        }
    }

    fn set(&mut self, set: &Element, required: bool, values: &mut Vec<RawParameter>) -> Result<()> {
        if set.name != "ParameterSet" {
            return Err(self.wrong(set, format!("<{}> where <ParameterSet> belongs", set.name)));
        }
        self.version(set)?;
        let children =
            ["Parameters", "Enumerations", "Units", "Annotations", "MetaData", "Signature"];
        self.known(set, &children, super::TOP);
        let units = units::read(set.grandchildren("Units"), &self.file, Code::Ssd)?;
        for parameter in self.list(set, "Parameters", "Parameter") {
            let value = self.value(parameter, required, &units);
            let value = self.gathered.take(value);
            values.extend(value);
        }
        Ok(())
    }

    fn value(&self, parameter: &Element, required: bool, units: &Units) -> Result<RawParameter> {
        let name = parameter.require("name", &self.file, Code::Ssd)?;
        let typed = parameter.children.iter().find(|c| c.name != "Annotations");
        let typed = typed.ok_or_else(|| self.wrong(parameter, format!("'{name}' has no value")))?;
        let kind = of_fmi_2(&typed.name);
        if !KINDS.contains(&kind) {
            return Err(Error::new(Code::Parameter, format!("'{name}' has the type <{kind}>"))
                .at_line(&self.file, typed.line)
                .why(format!("supported are {}", KINDS.join(", "))));
        }
        let unit = typed.get("unit").map(|name| RawUnit {
            name: name.to_owned(),
            unit: units.get(name).or_else(|| self.units.get(name)).copied(),
        });
        Ok(RawParameter {
            name: name.to_owned(),
            kind: kind.to_owned(),
            value: typed.require("value", &self.file, Code::Ssd)?.to_owned(),
            unit,
            stages: vec![Stage::default()],
            required,
            place: self.place(parameter),
        })
    }
}

/// Only mapped parameters, under their new names.
fn mapped(values: &[RawParameter], entries: &[super::mapping::Entry]) -> Vec<RawParameter> {
    let pairs = values.iter().flat_map(|value| {
        entries.iter().filter(|e| e.source == value.name).map(move |entry| (value, entry))
    });
    pairs
        .map(|(value, entry)| RawParameter {
            name: entry.target.clone(),
            kind: value.kind.clone(),
            value: value.value.clone(),
            unit: value.unit.clone(),
            stages: vec![entry.stage.clone()],
            required: value.required,
            place: value.place.clone(),
        })
        .collect()
}
