//! The modelDescription.xml of a remote FMU: that of the original FMU, except for what concerns the
//! library.

use fmu_standard::Xml;

use cosim_base::xml::{Attribute, Element};
use cosim_import::Category;
use cosim_import::description::Interface;

/// The elements before the log categories (FMI 2.0.5, 2.2.1).
const BEFORE: [&str; 3] = ["CoSimulation", "UnitDefinitions", "TypeDefinitions"];
/// The elements after them that are copied.
const AFTER: [&str; 3] = ["DefaultExperiment", "ModelVariables", "ModelStructure"];

/// Added to the description of the FMU.
const WHERE: &str = "computed by a worker, for importers on Linux";

/// The text for the description `root` of an FMU; `once`: there is one endpoint, and each instance
/// needs its own.
pub(super) fn text(
    root: &Element,
    interface: &Interface,
    once: bool,
    identifier: &str,
    guid: &str,
) -> String {
    let mut xml = Xml::new();
    let tool = concat!("cosim ", env!("CARGO_PKG_VERSION"));
    let what = match root.get("description").filter(|own| !own.trim().is_empty()) {
        Some(own) => format!("{own} ({WHERE})"),
        None => WHERE.to_owned(),
    };
    let mut attributes =
        own(root, &["guid", "description", "generationTool", "generationDateAndTime"]);
    attributes.extend([("guid", guid), ("description", &what), ("generationTool", tool)]);
    // The prefix for the namespace of the schema is up to the exporter.
    attributes.retain(|(name, _)| !name.contains(':'));
    xml.start(&root.name, &attributes);
    for name in BEFORE {
        match (name, root.child(name)) {
            ("CoSimulation", _) => co_simulation(&mut xml, interface, once, identifier),
            (_, Some(element)) => copy(&mut xml, element),
            _ => {}
        }
    }
    categories(&mut xml, root);
    AFTER.iter().filter_map(|name| root.child(name)).for_each(|child| copy(&mut xml, child));
    xml.finish()
}

/// Capabilities of a library that talks to a worker: it needs one, keeps no state itself, and each
/// instance is a separate process elsewhere.
fn co_simulation(xml: &mut Xml, interface: &Interface, once: bool, identifier: &str) {
    let flag = |set: bool| if set { "true" } else { "false" };
    let state = flag(can_save(interface));
    let attributes = [
        ("modelIdentifier", identifier),
        ("needsExecutionTool", "true"),
        ("canHandleVariableCommunicationStepSize", flag(interface.variable_step)),
        ("canInterpolateInputs", "false"),
        ("maxOutputDerivativeOrder", "0"),
        ("canRunAsynchronuously", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", flag(once)),
        ("canNotUseMemoryManagementFunctions", "true"),
        ("canGetAndSetFMUstate", state),
        ("canSerializeFMUstate", state),
        ("providesDirectionalDerivative", flag(interface.directional_derivative)),
    ];
    xml.empty("CoSimulation", &attributes);
}

/// A state is serialized or not transferred at all.
pub(super) fn can_save(interface: &Interface) -> bool {
    interface.get_and_set_state && interface.serialize_state
}

fn categories(xml: &mut Xml, root: &Element) {
    let theirs = root.grandchildren("LogCategories");
    xml.start("LogCategories", &[]);
    theirs.iter().for_each(|category| copy(xml, category));
    for category in Category::ALL {
        let (name, description) = (category.name(), category.description());
        if !theirs.iter().any(|category| category.get("name") == Some(name)) {
            xml.empty("Category", &[("name", name), ("description", description)]);
        }
    }
    xml.close();
}

/// An element without changes; vendor annotations are dropped.
fn copy(xml: &mut Xml, element: &Element) {
    let attributes = own(element, &[]);
    let children = || element.children.iter().filter(|child| child.name != "Annotations");
    if children().next().is_none() {
        return xml.empty(&element.name, &attributes);
    }
    xml.start(&element.name, &attributes);
    children().for_each(|child| copy(xml, child));
    xml.close();
}

fn own<'e>(element: &'e Element, without: &[&str]) -> Vec<(&'e str, &'e str)> {
    let kept = |attribute: &&Attribute| !without.contains(&attribute.name.as_str());
    let attributes = element.attributes.iter().filter(kept);
    attributes.map(|attribute| (attribute.name.as_str(), attribute.value.as_str())).collect()
}
