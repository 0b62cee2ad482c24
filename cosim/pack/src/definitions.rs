//! Units and types of the inner FMUs, for the description of the exported FMU.
//!
//! They are copied as written, with display units and items. If two FMUs use one name for different
//! definitions, the later one gets a number appended.

use std::collections::BTreeSet;

use fmu_standard::Xml;

use cosim_base::units::Unit;
use cosim_base::xml::{Attribute, Element, Name};

/// What the exposed variables refer to.
#[derive(Default)]
pub(super) struct Definitions {
    units: Vec<Element>,
    types: Vec<Element>,
    /// Names of variables, which types must not use.
    taken: BTreeSet<String>,
}

/// Attributes of the type elements that are copied.
const KEPT: &[&str] = &[
    "declaredType",
    "quantity",
    "unit",
    "displayUnit",
    "relativeQuantity",
    "min",
    "max",
    "nominal",
    "unbounded",
];

impl Definitions {
    pub(super) fn new<'a>(variables: impl Iterator<Item = &'a str>) -> Self {
        let taken = variables.map(str::to_owned).collect();
        Self { taken, ..Self::default() }
    }

    /// The attributes of the type element of a variable in `root`, the description of its FMU, with
    /// the names of units and types used here.
    pub(super) fn attributes(&mut self, root: &Element, typed: &Element) -> Vec<(String, String)> {
        let kept = typed.attributes.iter().filter(|a| KEPT.contains(&a.name.as_str()));
        let mut attributes = Vec::new();
        for Attribute { name, value } in kept {
            let value = match name.as_str() {
                "unit" => Some(self.unit(root, value)),
                "declaredType" => self.declared(root, value),
                _ => Some(value.clone()),
            };
            attributes.extend(value.map(|value| (name.to_string(), value)));
        }
        // A display unit is meaningful only with its unit.
        if !attributes.iter().any(|(name, _)| name == "unit") {
            let declared = attributes.iter().any(|(name, _)| name == "declaredType");
            attributes.retain(|(name, _)| declared || name != "displayUnit");
        }
        attributes
    }

    /// The attributes of a variable that has its own unit in the system; bounds of the component's
    /// variable would be in another unit.
    pub(super) fn of_unit(
        &mut self,
        unit: Option<&(String, Option<Unit>)>,
    ) -> Vec<(String, String)> {
        let Some((name, Some(unit))) = unit else {
            return Vec::new();
        };
        let attribute = |name: &str, value: String| Attribute { name: name.into(), value };
        let base = unit.attributes().into_iter().map(|(name, value)| attribute(name, value));
        let base = element("BaseUnit", base.collect(), Vec::new());
        let unit = element("Unit", vec![attribute("name", name.clone())], vec![base]);
        vec![("unit".to_owned(), add(&mut self.units, unit, &BTreeSet::new()))]
    }

    /// The name of a unit here. A unit that its FMU only names refers to the one with that name
    /// here.
    fn unit(&mut self, root: &Element, name: &str) -> String {
        match named(root.grandchildren("UnitDefinitions"), name) {
            Some(unit) => add(&mut self.units, unit.clone(), &BTreeSet::new()),
            None if named(&self.units, name).is_some() => name.to_owned(),
            None => {
                let own = vec![Attribute { name: "name".into(), value: name.to_owned() }];
                add(&mut self.units, element("Unit", own, Vec::new()), &BTreeSet::new())
            }
        }
    }

    fn declared(&mut self, root: &Element, name: &str) -> Option<String> {
        let mut simple = named(root.grandchildren("TypeDefinitions"), name)?.clone();
        for typed in &mut simple.children {
            for attribute in typed.attributes.iter_mut().filter(|a| a.name == "unit") {
                attribute.value = self.unit(root, &attribute.value);
            }
        }
        Some(add(&mut self.types, simple, &self.taken))
    }

    pub(super) fn write(&self, xml: &mut Xml) {
        let lists = [("UnitDefinitions", &self.units), ("TypeDefinitions", &self.types)];
        for (list, elements) in lists.into_iter().filter(|(_, elements)| !elements.is_empty()) {
            xml.start(list, &[]);
            elements.iter().for_each(|element| copy(xml, element));
            xml.close();
        }
    }
}

fn element(name: &str, attributes: Vec<Attribute>, children: Vec<Element>) -> Element {
    let text = String::new();
    Element { namespace: "".into(), name: name.into(), line: 0, attributes, children, text }
}

fn named<'e>(elements: &'e [Element], name: &str) -> Option<&'e Element> {
    elements.iter().find(|element| element.get("name") == Some(name))
}

/// Adds an element under its name, or under another if that name is taken by a different one;
/// returns the name.
fn add(list: &mut Vec<Element>, mut element: Element, taken: &BTreeSet<String>) -> String {
    let wanted = element.get("name").unwrap_or_default().to_owned();
    let mut name = wanted.clone();
    let mut count = 1;
    loop {
        match named(list, &name) {
            Some(found) if same(found, &element) => return name,
            None if !taken.contains(&name) => break,
            _ => {
                count += 1;
                name = format!("{wanted}_{count}");
            }
        }
    }
    for attribute in element.attributes.iter_mut().filter(|a| a.name == "name") {
        attribute.value.clone_from(&name);
    }
    list.push(element);
    name
}

/// Whether two definitions are the same except for their names.
fn same(a: &Element, b: &Element) -> bool {
    let said = |element: &Element| -> BTreeSet<(Name, String)> {
        let own = element.attributes.iter().filter(|a| a.name != "name");
        own.map(|a| (a.name.clone(), a.value.clone())).collect()
    };
    let alike = |(a, b): (&Element, &Element)| {
        a.name == b.name && a.get("name") == b.get("name") && same(a, b)
    };
    said(a) == said(b)
        && a.children.len() == b.children.len()
        && a.children.iter().zip(&b.children).all(alike)
}

/// An element of FMI, unchanged; others are dropped.
fn copy(xml: &mut Xml, element: &Element) {
    const KNOWN: [&str; 10] = [
        "Unit",
        "BaseUnit",
        "DisplayUnit",
        "SimpleType",
        "Real",
        "Integer",
        "Boolean",
        "String",
        "Enumeration",
        "Item",
    ];
    let Some(name) = KNOWN.into_iter().find(|known| element.name == *known) else {
        return;
    };
    let attributes: Vec<(&str, &str)> =
        element.attributes.iter().map(|a| (a.name.as_str(), a.value.as_str())).collect();
    if element.children.is_empty() {
        return xml.empty(name, &attributes);
    }
    xml.start(name, &attributes);
    element.children.iter().for_each(|child| copy(xml, child));
    xml.close();
}
