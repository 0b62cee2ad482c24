//! The modelDescription.xml of a system (FMI 2.0.5, 2.2 and 4.3).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use fmu_standard::{Initial, Xml, number};

use super::choice::Chosen;
use super::definitions::Definitions;
use super::feedthrough;
use cosim_base::error::Result;
use cosim_base::xml::{self, Element};
use cosim_core::hosted::{Exposed, Role};
use cosim_core::system::{Port, System, base_step};
use cosim_import::{Basic, Category, Causality, Fmu, InterfaceType, Value, Variability};

/// Writes the description of a system and its exposed variables.
pub(super) struct Description<'a> {
    pub system: &'a System,
    pub chosen: &'a [Chosen],
    pub model_name: &'a str,
    pub identifier: &'a str,
}

impl Description<'_> {
    /// The text.
    pub(super) fn text(&self, guid: &str) -> Result<String> {
        let roots = self.roots()?;
        let names = self.chosen.iter().map(|chosen| chosen.exposed.name.as_str());
        let mut definitions = Definitions::new(names);
        let types: Vec<Vec<(String, String)>> =
            self.chosen.iter().map(|chosen| self.typed(chosen, &roots, &mut definitions)).collect();
        let mut xml = Xml::new();
        let tool = concat!("cosim ", env!("CARGO_PKG_VERSION"));
        let count = self.system.components().len();
        let what = format!("The system '{}' of {count} components, on Linux", self.system.name());
        let naming = if self.is_structured(&roots) { "structured" } else { "flat" };
        let root = [
            ("fmiVersion", "2.0"),
            ("modelName", self.model_name),
            ("guid", guid),
            ("description", &what),
            ("generationTool", tool),
            ("variableNamingConvention", naming),
            ("numberOfEventIndicators", "0"),
        ];
        xml.start("fmiModelDescription", &root);
        self.interface(&mut xml);
        definitions.write(&mut xml);
        xml.start("LogCategories", &[]);
        for category in Category::ALL {
            let (name, description) = (category.name(), category.description());
            xml.empty("Category", &[("name", name), ("description", description)]);
        }
        xml.close();
        self.experiment(&mut xml);
        self.variables(&mut xml, &types);
        self.structure(&mut xml);
        Ok(xml.finish())
    }

    /// The descriptions of the FMUs, by file.
    pub(super) fn roots(&self) -> Result<BTreeMap<&Path, Element>> {
        let mut roots = BTreeMap::new();
        for fmu in self.fmus().map(|(fmu, _)| fmu) {
            if !roots.contains_key(fmu.path()) {
                let file = fmu.folder().join("modelDescription.xml");
                let shown = fmu.path().join("modelDescription.xml");
                roots.insert(fmu.path(), xml::read(&file, &shown)?);
            }
        }
        Ok(roots)
    }

    fn fmus(&self) -> impl Iterator<Item = (&Fmu, InterfaceType)> {
        self.system.components().iter().filter_map(|c| Some((c.fmu()?, c.interface)))
    }

    /// The attributes of the type element of a variable.
    fn typed(
        &self,
        chosen: &Chosen,
        roots: &BTreeMap<&Path, Element>,
        definitions: &mut Definitions,
    ) -> Vec<(String, String)> {
        let component = &self.system.components()[chosen.port().component];
        let root = component.fmu().and_then(|fmu| roots.get(fmu.path()));
        let element =
            root.and_then(|root| root.grandchildren("ModelVariables").get(chosen.port().variable));
        let typed = element.and_then(|element| {
            element.children.iter().find(|child| child.name == self.kind(chosen))
        });
        match (root, typed) {
            (Some(_), Some(_)) if chosen.unit.is_some() => {
                definitions.of_unit(chosen.unit.as_ref())
            }
            (Some(root), Some(typed)) => definitions.attributes(root, typed),
            _ => Vec::new(),
        }
    }

    fn kind(&self, chosen: &Chosen) -> &'static str {
        let model = &self.system.components()[chosen.port().component].model;
        model.description().map_or("Real", |d| d.variables[chosen.port().variable].kind.name())
    }

    /// Whether all names follow the structured naming convention of FMI.
    fn is_structured(&self, roots: &BTreeMap<&Path, Element>) -> bool {
        let plain = |part: &str| {
            part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        let said = roots.values().all(|r| r.get("variableNamingConvention") == Some("structured"));
        let owners = self.system.components().iter().all(|c| c.name.split('.').all(plain));
        // `der(x)` of a component would have to be `der(component.x)`.
        let derivatives = self.chosen.iter().any(|chosen| chosen.exposed.name.contains("der("));
        said && owners && !derivatives
    }

    fn interface(&self, xml: &mut Xml) {
        let interfaces: Vec<_> =
            self.fmus().filter_map(|(fmu, kind)| fmu.description().interface(kind)).collect();
        let saved = interfaces.iter().all(|i| i.get_and_set_state && i.serialize_state);
        let tool = interfaces.iter().any(|i| i.needs_execution_tool);
        let once = interfaces.iter().any(|i| i.once_per_process);
        let mut attributes = vec![("modelIdentifier", self.identifier)];
        let mut flag = |name, holds: bool| attributes.extend(holds.then_some((name, "true")));
        flag("needsExecutionTool", tool);
        flag("canHandleVariableCommunicationStepSize", true);
        flag("canBeInstantiatedOnlyOncePerProcess", once);
        flag("canNotUseMemoryManagementFunctions", true);
        flag("canGetAndSetFMUstate", saved);
        flag("canSerializeFMUstate", saved);
        xml.empty("CoSimulation", &attributes);
    }

    fn experiment(&self, xml: &mut Xml) {
        let system = self.system;
        let step = number(base_step(system).seconds());
        let (start, stop) =
            (number(system.start_time().seconds()), number(system.stop_time().seconds()));
        let attributes = [("startTime", start.as_str()), ("stopTime", &stop), ("stepSize", &step)];
        xml.empty("DefaultExperiment", &attributes);
    }

    fn variables(&self, xml: &mut Xml, types: &[Vec<(String, String)>]) {
        xml.start("ModelVariables", &[]);
        let mut references = References::default();
        for (chosen, typed) in self.chosen.iter().zip(types) {
            let Exposed { name, basic, role, start, .. } = &chosen.exposed;
            let reference = references.next(*basic).to_string();
            let component = &self.system.components()[chosen.port().component];
            let described = component.model.description();
            let described = described.map(|d| &d.variables[chosen.port().variable]);
            let mut attributes = vec![("name", name.as_str()), ("valueReference", &reference)];
            if let Some(variable) = described {
                if !variable.description.is_empty() {
                    attributes.push(("description", &variable.description));
                }
                attributes.push(("causality", chosen.causality.name()));
                attributes.push(("variability", variable.variability.name()));
            }
            if *role == Role::Start {
                attributes.push(("initial", Initial::Exact.name()));
            }
            let constant = described.is_some_and(|v| v.variability == Variability::Constant);
            let start = (role.starts() || constant).then(|| text(start));
            let mut inside: Vec<(&str, &str)> =
                typed.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
            inside.extend(start.as_ref().map(|start| ("start", start.as_str())));
            xml.start("ScalarVariable", &attributes);
            xml.empty(self.kind(chosen), &inside);
            xml.close();
        }
        xml.close();
    }

    fn structure(&self, xml: &mut Xml) {
        let ends = |(place, c): (usize, &Chosen)| -> Vec<(Port, usize)> {
            c.ports.iter().map(|port| (*port, place + 1)).collect()
        };
        let inputs = self.chosen.iter().enumerate().filter(|(_, c)| c.exposed.role == Role::Input);
        let free: BTreeMap<Port, usize> = inputs.flat_map(ends).collect();
        let all = feedthrough::dependencies(self.system, &free.keys().copied().collect());
        xml.start("ModelStructure", &[]);
        self.unknowns(
            xml,
            "Outputs",
            |c| c.causality == Causality::Output,
            |chosen| {
                let inputs = all.get(&chosen.port()).into_iter().flatten();
                let inputs: BTreeSet<usize> = inputs.filter_map(|i| free.get(i).copied()).collect();
                let inputs: Vec<String> = inputs.iter().map(usize::to_string).collect();
                Some(inputs.join(" "))
            },
        );
        let initially = |c: &Chosen| {
            let computed = [Causality::Output, Causality::CalculatedParameter];
            c.exposed.role == Role::Calculated
                && computed.contains(&c.causality)
                && !self.is_constant(c)
        };
        self.unknowns(xml, "InitialUnknowns", initially, |_| None);
        xml.close();
    }

    /// A list of variables with their dependencies, if those are known.
    fn unknowns(
        &self,
        xml: &mut Xml,
        list: &'static str,
        which: impl Fn(&Chosen) -> bool,
        dependencies: impl Fn(&Chosen) -> Option<String>,
    ) {
        let unknowns = self.chosen.iter().enumerate().filter(|(_, chosen)| which(chosen));
        let mut unknowns = unknowns.peekable();
        if unknowns.peek().is_none() {
            return;
        }
        xml.start(list, &[]);
        for (place, chosen) in unknowns {
            let (index, dependencies) = ((place + 1).to_string(), dependencies(chosen));
            let mut attributes = vec![("index", index.as_str())];
            attributes.extend(dependencies.as_ref().map(|on| ("dependencies", on.as_str())));
            xml.empty("Unknown", &attributes);
        }
        xml.close();
    }

    fn is_constant(&self, chosen: &Chosen) -> bool {
        let model = &self.system.components()[chosen.port().component].model;
        let described = model.description().map(|d| &d.variables[chosen.port().variable]);
        described.is_some_and(|variable| variable.variability == Variability::Constant)
    }
}

/// Counts value references, per type.
#[derive(Default)]
struct References([u32; Basic::ALL.len()]);

impl References {
    fn next(&mut self, basic: Basic) -> u32 {
        let count = &mut self.0[basic as usize];
        *count += 1;
        *count - 1
    }
}

/// A start value that reads back exactly.
fn text(value: &Value) -> String {
    value.to_string()
}
