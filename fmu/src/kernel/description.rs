//! modelDescription.xml of a component (FMI 2.0.4, section 2.2), from its info, its table and the
//! dependencies found by probing. Elements and attributes are in the order of the standard.

use std::collections::{BTreeMap, BTreeSet};

use fmu_standard::{Category, Causality, Element, Initial, Unit, Variability, Xml, number};

use crate::author::{Info, Start};

use super::dependencies::Dependencies;
use super::factors::Factor;
use super::table::{Group, Table, Variable};
use super::unit::type_name;

/// Writes the description. Without `dependencies` its text identifies the interface, which is
/// what the GUID is made of.
pub(crate) fn write(
    info: &Info,
    table: &Table,
    guid: &str,
    dependencies: Option<&Dependencies>,
) -> String {
    let mut xml = Xml::new();
    let given = |text: &'static str| (!text.is_empty()).then_some(text);
    xml.element("fmiModelDescription")
        .attribute("fmiVersion", "2.0")
        .attribute("modelName", info.name)
        .attribute("guid", guid)
        .maybe("description", given(info.description))
        .maybe("author", given(info.author))
        .maybe("version", given(info.version))
        .maybe("copyright", given(info.copyright))
        .maybe("license", given(info.license))
        .attribute("generationTool", concat!("fmu-kit ", env!("CARGO_PKG_VERSION")))
        .attribute("variableNamingConvention", "structured")
        .attribute("numberOfEventIndicators", table.indicators().len())
        .children();
    interfaces(&mut xml, info, table);
    units(&mut xml, table);
    types(&mut xml, table);
    xml.element("LogCategories").children();
    for category in Category::ALL {
        let description = match category {
            Category::Events => "Initialization and time events, on request",
            other => other.description(),
        };
        xml.empty("Category", &[("name", category.name()), ("description", description)]);
    }
    xml.close();
    xml.element("DefaultExperiment")
        .attribute("startTime", number(0.0))
        .attribute("stopTime", number(info.stop_time_s))
        .attribute("stepSize", number(info.step_s))
        .empty();
    variables(&mut xml, info, table);
    if let Some(dependencies) = dependencies {
        structure(&mut xml, dependencies);
    }
    xml.finish()
}

/// The capabilities of each interface; exactly what the functions support.
fn interfaces(xml: &mut Xml, info: &Info, table: &Table) {
    if info.model_exchange {
        xml.element("ModelExchange")
            .attribute("modelIdentifier", info.name)
            .attribute("needsExecutionTool", false)
            .attribute("completedIntegratorStepNotNeeded", true)
            .attribute("canBeInstantiatedOnlyOncePerProcess", false)
            .attribute("canNotUseMemoryManagementFunctions", true)
            .attribute("canGetAndSetFMUstate", true)
            .attribute("canSerializeFMUstate", true)
            .attribute("providesDirectionalDerivative", table.has_tangent())
            .empty();
    }
    xml.element("CoSimulation")
        .attribute("modelIdentifier", info.name)
        .attribute("needsExecutionTool", false)
        .attribute("canHandleVariableCommunicationStepSize", true)
        .attribute("canInterpolateInputs", true)
        .attribute("maxOutputDerivativeOrder", i32::from(table.has_tangent()))
        .attribute("canRunAsynchronuously", false)
        .attribute("canBeInstantiatedOnlyOncePerProcess", false)
        .attribute("canNotUseMemoryManagementFunctions", true)
        .attribute("canGetAndSetFMUstate", true)
        .attribute("canSerializeFMUstate", true)
        .attribute("providesDirectionalDerivative", table.has_tangent())
        .empty();
}

/// The units in use, each once.
fn units_of(table: &Table) -> BTreeSet<&str> {
    table.variables().iter().filter_map(|variable| variable.unit.as_deref()).collect()
}

fn units(xml: &mut Xml, table: &Table) {
    xml.element("UnitDefinitions").children();
    for name in units_of(table) {
        let element = xml.element("Unit").attribute("name", name);
        let Some(unit) = Unit::parse(name).ok().filter(Unit::is_whole) else {
            element.empty();
            continue;
        };
        element.children();
        let base = xml.element("BaseUnit");
        let attributes = unit.attributes();
        attributes.iter().fold(base, |base, (name, value)| base.attribute(name, value)).empty();
        xml.close();
    }
    xml.close();
}

fn types(xml: &mut Xml, table: &Table) {
    let mut enumerations = BTreeMap::new();
    for variable in table.variables() {
        if let Start::Enumeration { name, description, items, .. } = variable.start {
            enumerations.insert(name, (description, items));
        }
    }
    xml.element("TypeDefinitions").children();
    for unit in units_of(table) {
        let name = type_name(unit);
        xml.element("SimpleType").attribute("name", &name).children();
        xml.element("Real").attribute("quantity", &name).attribute("unit", unit).empty();
        xml.close();
    }
    for (name, (description, items)) in enumerations {
        xml.element("SimpleType")
            .attribute("name", name)
            .maybe("description", (!description.is_empty()).then_some(description))
            .children();
        xml.element("Enumeration").children();
        for (value, (item, description)) in (1..).zip(items) {
            xml.element("Item")
                .attribute("name", item)
                .attribute("value", value)
                .maybe("description", (!description.is_empty()).then_some(description))
                .empty();
        }
        xml.close();
        xml.close();
    }
    xml.close();
}

fn variables(xml: &mut Xml, info: &Info, table: &Table) {
    xml.element("ModelVariables").children();
    let first_state = table.group(Group::State).map(|(index, _)| index).next().unwrap_or_default();
    let mut derivatives = 0;
    for variable in table.variables() {
        let (causality, variability, initial) = role(variable, info.sampled);
        let description = &variable.description;
        xml.element("ScalarVariable")
            .attribute("name", &variable.name)
            .attribute("valueReference", variable.reference)
            .maybe("description", (!description.is_empty()).then_some(description))
            .attribute("causality", causality.name())
            .attribute("variability", variability.name())
            .maybe("initial", initial.map(Initial::name))
            .children();
        let derivative_of = (variable.group == Group::Derivative).then(|| {
            derivatives += 1;
            first_state + derivatives
        });
        typed(xml, variable, derivative_of);
        xml.close();
    }
    xml.close();
}

/// Causality, variability and initial of a variable.
fn role(variable: &Variable, sampled: bool) -> (Causality, Variability, Option<Initial>) {
    use {Initial::*, Variability::*};
    let real = if variable.is_real() { Continuous } else { Discrete };
    let changing = if sampled { Discrete } else { real };
    match variable.group {
        Group::Parameter if variable.tunable => (Causality::Parameter, Tunable, Some(Exact)),
        Group::Parameter => (Causality::Parameter, Fixed, Some(Exact)),
        Group::Input => (Causality::Input, real, None),
        Group::Output => (Causality::Output, changing, Some(Calculated)),
        Group::State | Group::Derivative => (Causality::Local, Continuous, Some(Calculated)),
        Group::Time => (Causality::Independent, Continuous, None),
    }
}

/// The element of the type: attributes, and a start value if one may be set.
fn typed(xml: &mut Xml, variable: &Variable, derivative_of: Option<usize>) {
    let settable = matches!(variable.group, Group::Parameter | Group::Input);
    let changing = !matches!(variable.group, Group::Parameter | Group::Time);
    let real = |element: Element<'_>, start: f64| {
        element
            .maybe("declaredType", variable.unit.as_deref().map(type_name))
            .maybe("unit", variable.unit.as_deref())
            .maybe("min", variable.min.map(number))
            .maybe("max", variable.max.map(number))
            .maybe("nominal", variable.nominal.or(changing.then_some(1.0)).map(number))
            .maybe("start", settable.then(|| number(start)))
            .maybe("derivative", derivative_of)
            .empty();
    };
    match &variable.start {
        Start::Real(start) => real(xml.element("Real"), *start),
        Start::Integer(start) => xml
            .element("Integer")
            .maybe("min", variable.min)
            .maybe("max", variable.max)
            .maybe("start", settable.then_some(start))
            .empty(),
        Start::Boolean(start) => {
            xml.element("Boolean").maybe("start", settable.then_some(start)).empty();
        }
        Start::String(start) => {
            xml.element("String").maybe("start", settable.then_some(start)).empty();
        }
        Start::Enumeration { name, value, .. } => xml
            .element("Enumeration")
            .attribute("declaredType", name)
            .maybe("start", settable.then_some(value))
            .empty(),
    }
}

fn structure(xml: &mut Xml, dependencies: &Dependencies) {
    xml.element("ModelStructure").children();
    type Factors = fn(&Dependencies, usize, usize) -> Factor;
    let lists: [(_, _, Factors); 3] = [
        ("Outputs", &dependencies.outputs, Dependencies::factor),
        ("Derivatives", &dependencies.derivatives, Dependencies::factor),
        ("InitialUnknowns", &dependencies.initial, Dependencies::initial_factor),
    ];
    for (list, unknowns, factor) in lists {
        if unknowns.is_empty() {
            continue;
        }
        xml.element(list).children();
        for (unknown, knowns) in unknowns {
            let indices: Vec<String> = knowns.iter().map(|known| (known + 1).to_string()).collect();
            let kinds: Vec<&str> =
                knowns.iter().map(|known| factor(dependencies, *unknown, *known).name()).collect();
            xml.element("Unknown")
                .attribute("index", unknown + 1)
                .attribute("dependencies", indices.join(" "))
                .maybe("dependenciesKind", (!kinds.is_empty()).then(|| kinds.join(" ")))
                .empty();
        }
        xml.close();
    }
    xml.close();
}
