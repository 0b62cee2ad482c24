//! Parameter bindings: values inline (`<ssd:ParameterValues>`) or in an .ssv file, with a prefix
//! and a mapping.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::element::of_fmi_2;
use super::mapping::Entry;
use super::{Reader, join};
use crate::system::raw::{RawParameter, RawUnit, Stage};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::units::{self, Units};
use cosim_base::xml::{self, Element};

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
            let set = self.set_in_file(binding, source, component)?;
            self.spend(set.iter().map(RawParameter::size).sum(), binding)?;
            values.extend(set.iter().cloned());
        }
        for set in binding.grandchildren("ParameterValues") {
            self.set(set, true, &mut values)?;
        }
        let prefix = binding.get("prefix").unwrap_or_default();
        self.spend(values.len() * prefix.len(), binding)?;
        for value in &mut values {
            value.name.insert_str(0, prefix);
        }
        if let Some(entries) = mapping {
            self.spend(entries.iter().map(Entry::size).sum(), binding)?;
            let names: HashSet<&str> = values.iter().map(|v| v.name.as_str()).collect();
            for entry in entries.iter() {
                if !names.contains(entry.source.as_str()) {
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
            values = self.mapped(&values, &entries, binding)?;
        }
        self.spend(values.len() * owner.len(), binding)?;
        for value in &mut values {
            value.name = join(owner, &value.name);
        }
        self.nested.parameters.extend(values);
        Ok(())
    }

    /// The values of a parameter file.
    fn set_in_file(
        &mut self,
        binding: &Element,
        source: &str,
        component: Option<&Path>,
    ) -> Result<Arc<[RawParameter]>> {
        let (base, file) = self.file(binding, source, component)?;
        if let Some(read) = self.nested.parameter_files.get(&file) {
            return Ok(read.clone());
        }
        let (root, mut other) = self.follow(binding, base, &file)?;
        let mut values = Vec::new();
        other.set(&root, false, &mut values)?;
        let set: Arc<[RawParameter]> = values.into();
        self.nested.parameter_files.insert(file, set.clone());
        Ok(set)
    }

    /// The file that an element names as its source, and the base of sources in it.
    pub(super) fn file(
        &self,
        element: &Element,
        source: &str,
        component: Option<&Path>,
    ) -> Result<(Base, PathBuf)> {
        let base = self.base_of(element, component)?;
        let file = base.open(source, &self.place(element))?;
        Ok((base, file))
    }

    /// The root of a file that an element names, and a reader for it.
    pub(super) fn follow(
        &mut self,
        element: &Element,
        base: Base,
        file: &Path,
    ) -> Result<(Element, Reader<'_>)> {
        let at = self.place(element);
        self.gathered.spend_on(file, &at)?;
        let root = xml::read(file, file).map_err(|e| e.help(format!("named in {at}")))?;
        let reader = Reader {
            file: Arc::from(file),
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

    /// Only mapped parameters, under their new names.
    fn mapped(
        &mut self,
        values: &[RawParameter],
        entries: &[Entry],
        binding: &Element,
    ) -> Result<Vec<RawParameter>> {
        let mut by_source: HashMap<&str, Vec<&Entry>> = HashMap::new();
        for entry in entries {
            by_source.entry(&entry.source).or_default().push(entry);
        }
        let mut mapped = Vec::new();
        for value in values {
            for entry in by_source.get(value.name.as_str()).into_iter().flatten() {
                self.spend(value.size() + entry.size(), binding)?;
                mapped.push(RawParameter {
                    name: entry.target.clone(),
                    stages: vec![entry.stage.clone()],
                    ..value.clone()
                });
            }
        }
        Ok(mapped)
    }
}
