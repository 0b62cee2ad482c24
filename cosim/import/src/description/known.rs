//! Elements and attributes in a modelDescription.xml that FMI 2.0 does not define.
//!
//! They are ignored and reported: otherwise a misspelt attribute would silently become a default.
//! `VendorAnnotations` and `Annotations` belong to other tools and are not checked.

use std::path::Path;

use cosim_base::Messages;
use cosim_base::names;
use cosim_base::xml::Element;

/// Warnings that are reported individually; further ones are counted.
const REPORTED: usize = 20;

/// Element (of a parent, `*`: of any), its attributes and its children. FMI 2.0.5, chapters 2.2,
/// 3.3 and 4.3.
const KNOWN: &[(&str, &str, &[&str], &[&str])] = &[
    (
        "",
        "fmiModelDescription",
        &[
            "fmiVersion",
            "modelName",
            "guid",
            "description",
            "author",
            "version",
            "copyright",
            "license",
            "generationTool",
            "generationDateAndTime",
            "variableNamingConvention",
            "numberOfEventIndicators",
        ],
        &[
            "ModelExchange",
            "CoSimulation",
            "UnitDefinitions",
            "TypeDefinitions",
            "LogCategories",
            "DefaultExperiment",
            "VendorAnnotations",
            "ModelVariables",
            "ModelStructure",
        ],
    ),
    (
        "*",
        "ModelExchange",
        &[
            "modelIdentifier",
            "needsExecutionTool",
            "completedIntegratorStepNotNeeded",
            "canBeInstantiatedOnlyOncePerProcess",
            "canNotUseMemoryManagementFunctions",
            "canGetAndSetFMUstate",
            "canSerializeFMUstate",
            "providesDirectionalDerivative",
        ],
        &["SourceFiles"],
    ),
    (
        "*",
        "CoSimulation",
        &[
            "modelIdentifier",
            "needsExecutionTool",
            "canHandleVariableCommunicationStepSize",
            "canInterpolateInputs",
            "maxOutputDerivativeOrder",
            "canRunAsynchronuously",
            "canBeInstantiatedOnlyOncePerProcess",
            "canNotUseMemoryManagementFunctions",
            "canGetAndSetFMUstate",
            "canSerializeFMUstate",
            "providesDirectionalDerivative",
        ],
        &["SourceFiles"],
    ),
    ("*", "DefaultExperiment", &["startTime", "stopTime", "tolerance", "stepSize"], &[]),
    ("*", "ModelVariables", &[], &["ScalarVariable"]),
    (
        "*",
        "ScalarVariable",
        &[
            "name",
            "valueReference",
            "description",
            "causality",
            "variability",
            "initial",
            "canHandleMultipleSetPerTimeInstant",
        ],
        &["Real", "Integer", "Boolean", "String", "Enumeration", "Annotations"],
    ),
    (
        "ScalarVariable",
        "Real",
        &[
            "declaredType",
            "quantity",
            "unit",
            "displayUnit",
            "relativeQuantity",
            "min",
            "max",
            "nominal",
            "unbounded",
            "start",
            "derivative",
            "reinit",
        ],
        &[],
    ),
    ("ScalarVariable", "Integer", &["declaredType", "quantity", "min", "max", "start"], &[]),
    ("ScalarVariable", "Boolean", &["declaredType", "start"], &[]),
    ("ScalarVariable", "String", &["declaredType", "start"], &[]),
    ("ScalarVariable", "Enumeration", &["declaredType", "quantity", "min", "max", "start"], &[]),
    ("*", "LogCategories", &[], &["Category"]),
    ("*", "Category", &["name", "description"], &[]),
    ("*", "ModelStructure", &[], &["Outputs", "Derivatives", "InitialUnknowns"]),
    ("*", "Outputs", &[], &["Unknown"]),
    ("*", "Derivatives", &[], &["Unknown"]),
    ("*", "InitialUnknowns", &[], &["Unknown"]),
    ("*", "Unknown", &["index", "dependencies", "dependenciesKind"], &[]),
];

/// Everything in the tree under `root` that FMI 2.0 does not define.
pub(super) fn unknown(root: &Element, file: &Path) -> Vec<String> {
    let mut found = Found { file, reported: Messages::default() };
    found.walk("", root);
    found.reported.into_vec()
}

struct Found<'a> {
    file: &'a Path,
    reported: Messages<REPORTED>,
}

impl Found<'_> {
    fn walk(&mut self, parent: &str, element: &Element) {
        let name = element.name.as_str();
        let known = KNOWN.iter().find(|(of, n, ..)| *n == name && (*of == "*" || *of == parent));
        let Some((_, _, attributes, children)) = known else { return };
        for attribute in &element.attributes {
            // A prefix: from another namespace, such as xsi:schemaLocation.
            if !attribute.name.contains(':') && !attributes.contains(&attribute.name.as_str()) {
                let what = format!("the attribute '{}' of <{name}>", attribute.name);
                self.report(what, element.line, &attribute.name, attributes);
            }
        }
        for child in &element.children {
            if !children.contains(&child.name.as_str()) {
                let what = format!("the element <{}> in <{name}>", child.name);
                self.report(what, child.line, &child.name, children);
            }
            self.walk(name, child);
        }
    }

    fn report(&mut self, what: String, line: usize, name: &str, known: &[&str]) {
        let hint = names::did_you_mean(name, known.iter().copied());
        let hint = hint.map_or(String::new(), |hint| format!(" ({hint})"));
        let place = format!("{}:{line}", self.file.display());
        self.reported.push(format!("{what} is not part of FMI 2.0 and is ignored{hint}, {place}"));
    }
}
