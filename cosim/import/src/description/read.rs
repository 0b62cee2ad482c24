//! Reads a modelDescription.xml into a [`Description`].

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use fmu_standard::Initial;

use super::known;
use super::{
    Causality, Description, Experiment, Interface, Kind, Output, Value, Variability, Variable,
};
use cosim_base::error::{Code, Error, Result};
use cosim_base::units;
use cosim_base::xml::{self, Element};

/// Enumerations by the name of their type.
type Enumerations = BTreeMap<String, Arc<[(String, i32)]>>;

/// Maximum number of dependencies of all outputs together; a file can name more than fit into
/// memory.
const MAX_DEPENDENCIES: usize = 20_000_000;

/// Reads `file`; `shown` is its name in messages.
pub fn read(file: &Path, shown: &Path) -> Result<Description> {
    of(&xml::read(file, shown)?, shown)
}

/// Reads a description from memory; `shown` is its name in messages.
pub fn parse(text: &[u8], shown: &Path) -> Result<Description> {
    of(&xml::decode(text, shown)?, shown)
}

fn of(root: &Element, file: &Path) -> Result<Description> {
    let reader = Reader {
        file,
        enumerations: enumerations(root, file)?,
        units_of_types: units_of_types(root),
    };
    reader.description(root)
}

struct Reader<'a> {
    file: &'a Path,
    enumerations: Enumerations,
    /// What a Real without a unit inherits from its declared type.
    units_of_types: BTreeMap<String, String>,
}

fn units_of_types(root: &Element) -> BTreeMap<String, String> {
    let types = root.grandchildren("TypeDefinitions").iter();
    types
        .filter_map(|simple| {
            let unit = simple.child("Real")?.get("unit")?;
            Some((simple.get("name")?.to_owned(), unit.to_owned()))
        })
        .collect()
}

fn enumerations(root: &Element, file: &Path) -> Result<Enumerations> {
    let mut found = Enumerations::new();
    for simple in root.grandchildren("TypeDefinitions") {
        let Some(list) = simple.child("Enumeration") else {
            continue;
        };
        let mut items = Vec::new();
        for item in &list.children {
            let name = item.require("name", file, Code::Description)?.to_owned();
            let value = item.parse("value", file, Code::Description)?.unwrap_or(0);
            items.push((name, value));
        }
        found.insert(simple.require("name", file, Code::Description)?.to_owned(), items.into());
    }
    Ok(found)
}

impl Reader<'_> {
    fn description(&self, root: &Element) -> Result<Description> {
        if root.name != "fmiModelDescription" {
            return Err(self.wrong(root, format!("the root element is <{}>", root.name)));
        }
        let version = root.require("fmiVersion", self.file, Code::Description)?;
        if version != "2.0" {
            let what = format!("the FMU is of FMI version {version}");
            return Err(Error::new(Code::Version, what)
                .at_line(self.file, root.line)
                .help("export it for FMI 2.0: only that is supported"));
        }
        let variables = self.variables(root)?;
        let mut positions = HashMap::with_capacity(variables.len());
        for (position, variable) in variables.iter().enumerate() {
            if let Some(first) = positions.insert(variable.name.clone(), position) {
                let what = format!("the variable '{}' is declared twice", variable.name);
                return Err(Error::new(Code::Description, what)
                    .at_line(self.file, variable.line)
                    .why(format!("first on line {}", variables[first].line)));
            }
        }
        let text = |name| root.get(name).unwrap_or_default().to_owned();
        Ok(Description {
            model_name: text("modelName"),
            guid: root.require("guid", self.file, Code::Description)?.to_owned(),
            description: text("description"),
            generation_tool: text("generationTool"),
            co_simulation: root.child("CoSimulation").map(|e| self.interface(e)).transpose()?,
            model_exchange: root.child("ModelExchange").map(|e| self.interface(e)).transpose()?,
            states: self.states(root, &variables)?,
            unlisted_derivative: self.unlisted_derivative(root),
            event_indicators: root
                .parse("numberOfEventIndicators", self.file, Code::Description)?
                .unwrap_or(0),
            experiment: self.experiment(root)?,
            units: units::read(
                root.grandchildren("UnitDefinitions"),
                self.file,
                Code::Description,
            )?,
            outputs: self.outputs(root, &variables)?,
            log_categories: root
                .grandchildren("LogCategories")
                .iter()
                .filter_map(|category| category.get("name").map(str::to_owned))
                .collect(),
            warnings: known::unknown(root, self.file),
            variables,
            positions,
            feeding: OnceLock::new(),
        })
    }

    fn interface(&self, element: &Element) -> Result<Interface> {
        let flag = |name| element.flag(name, self.file, Code::Description);
        let identifier = element.require("modelIdentifier", self.file, Code::Description)?;
        if identifier.is_empty() || identifier.contains(['/', '\\', '\0']) {
            return Err(self.wrong(element, format!("modelIdentifier=\"{identifier}\"")));
        }
        Ok(Interface {
            model_identifier: identifier.to_owned(),
            needs_execution_tool: flag("needsExecutionTool")?,
            once_per_process: flag("canBeInstantiatedOnlyOncePerProcess")?,
            get_and_set_state: flag("canGetAndSetFMUstate")?,
            serialize_state: flag("canSerializeFMUstate")?,
            directional_derivative: flag("providesDirectionalDerivative")?,
            variable_step: flag("canHandleVariableCommunicationStepSize")?,
            interpolates_inputs: flag("canInterpolateInputs")?,
            output_derivative_order: element
                .parse("maxOutputDerivativeOrder", self.file, Code::Description)?
                .unwrap_or(0),
            no_completed_step: flag("completedIntegratorStepNotNeeded")?,
            own_memory: flag("canNotUseMemoryManagementFunctions")?,
            asynchronous: flag("canRunAsynchronuously")?,
        })
    }

    /// Number of continuous states: one per derivative of ModelStructure.
    fn states(&self, root: &Element, variables: &[Variable]) -> Result<usize> {
        let structure = root.child("ModelStructure");
        let derivatives = structure.map_or(&[][..], |s| s.grandchildren("Derivatives"));
        for unknown in derivatives {
            let index = unknown.require("index", self.file, Code::Description)?;
            self.position(unknown, index, variables)?;
        }
        Ok(derivatives.len())
    }

    /// A derivative, if ModelStructure lists none at all; an empty list is not valid either.
    fn unlisted_derivative(&self, root: &Element) -> Option<(String, usize)> {
        let structure = root.child("ModelStructure");
        let listed = structure.is_some_and(|s| !s.grandchildren("Derivatives").is_empty());
        let is_derivative = |variable: &&Element| {
            variable.child("Real").is_some_and(|real| real.get("derivative").is_some())
        };
        let found = root.grandchildren("ModelVariables").iter().find(is_derivative);
        let named = |variable: &Element| Some((variable.get("name")?.to_owned(), variable.line));
        found.filter(|_| !listed).and_then(named)
    }

    fn experiment(&self, root: &Element) -> Result<Experiment> {
        let Some(element) = root.child("DefaultExperiment") else {
            return Ok(Experiment::default());
        };
        let number = |name| element.parse(name, self.file, Code::Description);
        Ok(Experiment {
            start: number("startTime")?,
            stop: number("stopTime")?,
            // 0 means no step.
            step: number("stepSize")?.filter(|step| *step > 0.0),
            tolerance: number("tolerance")?,
        })
    }

    fn variables(&self, root: &Element) -> Result<Vec<Variable>> {
        root.grandchildren("ModelVariables").iter().map(|e| self.variable(e)).collect()
    }

    fn variable(&self, element: &Element) -> Result<Variable> {
        let name = element.require("name", self.file, Code::Description)?.to_owned();
        let typed = element
            .children
            .iter()
            .find(|c| self.kind(c).is_some())
            .ok_or_else(|| self.wrong(element, format!("the variable '{name}' has no type")))?;
        let kind = self.kind(typed).unwrap_or(Kind::Real);
        let value_reference = element
            .parse("valueReference", self.file, Code::Description)?
            .ok_or_else(|| self.wrong(element, format!("'{name}' has no valueReference")))?;
        let start = self.start(typed, &name, &kind)?;
        let causality = self.causality(element)?;
        let variability = self.variability(element, &kind)?;
        let exact = match element.get("initial") {
            Some(initial) => initial == Initial::Exact.name(),
            // FMI 2.0.5, table 2.2.7: the defaults of `initial`.
            None => {
                causality == Causality::Parameter
                    || (matches!(causality, Causality::Output | Causality::Local)
                        && variability == Variability::Constant)
            }
        };
        Ok(Variable {
            description: element.get("description").unwrap_or_default().to_owned(),
            unit: self.unit(typed).map(str::to_owned),
            // A nominal value that is not a magnitude is ignored.
            nominal: typed
                .get("nominal")
                .and_then(|text| text.trim().parse().ok())
                .filter(|nominal: &f64| nominal.is_finite() && *nominal > 0.0)
                .unwrap_or(1.0),
            line: element.line,
            name,
            value_reference,
            causality,
            variability,
            exact,
            kind,
            start,
        })
    }

    /// The start value; `None` if it is not a number that could be set.
    fn start(&self, typed: &Element, name: &str, kind: &Kind) -> Result<Option<Value>> {
        let Some(text) = typed.get("start") else { return Ok(None) };
        match (kind, text.trim(), text.trim().parse()) {
            (Kind::Real, "INF" | "-INF" | "NaN", _) => Ok(None),
            // Some FMUs have a start value that is not one of the items.
            (Kind::Enumeration(_), _, Ok(number)) => Ok(Some(Value::Integer(number))),
            _ => Value::parse(text, kind)
                .map(Some)
                .map_err(|e| self.wrong(typed, format!("the start value of '{name}'")).why(e.0)),
        }
    }

    fn unit<'e>(&'e self, typed: &'e Element) -> Option<&'e str> {
        let declared = || self.units_of_types.get(typed.get("declaredType")?);
        typed.get("unit").or_else(|| declared().map(String::as_str))
    }

    fn kind(&self, element: &Element) -> Option<Kind> {
        Some(match element.name.as_str() {
            "Real" => Kind::Real,
            "Integer" => Kind::Integer,
            "Boolean" => Kind::Boolean,
            "String" => Kind::String,
            "Enumeration" => {
                let declared = element.get("declaredType").unwrap_or_default();
                Kind::Enumeration(
                    self.enumerations.get(declared).cloned().unwrap_or_else(|| [].into()),
                )
            }
            _ => return None,
        })
    }

    fn causality(&self, element: &Element) -> Result<Causality> {
        let name = element.get("causality").unwrap_or("local");
        let wrong = || self.wrong(element, format!("causality=\"{name}\""));
        Causality::named(name).ok_or_else(wrong)
    }

    fn variability(&self, element: &Element, kind: &Kind) -> Result<Variability> {
        match element.get("variability") {
            // The default is "continuous" for Reals; other types cannot be continuous.
            None if *kind == Kind::Real => Ok(Variability::Continuous),
            None => Ok(Variability::Discrete),
            Some(name) => Variability::named(name)
                .ok_or_else(|| self.wrong(element, format!("variability=\"{name}\""))),
        }
    }

    /// The outputs of ModelStructure; an output variable that is missing there depends on
    /// everything.
    fn outputs(&self, root: &Element, variables: &[Variable]) -> Result<Vec<Output>> {
        let mut outputs = Vec::new();
        let mut listed = vec![false; variables.len()];
        let mut count = 0;
        let structure = root.child("ModelStructure");
        for unknown in structure.map_or(&[][..], |s| s.grandchildren("Outputs")) {
            let index = unknown.require("index", self.file, Code::Description)?;
            let dependencies = unknown.get("dependencies").map(|list| {
                list.split_whitespace()
                    .map(|index| self.position(unknown, index, variables))
                    .collect::<Result<Vec<_>>>()
            });
            let (variable, dependencies) =
                (self.position(unknown, index, variables)?, dependencies.transpose()?);
            count += dependencies.as_ref().map_or(0, Vec::len);
            if count > MAX_DEPENDENCIES {
                let what = format!("more than {MAX_DEPENDENCIES} dependencies");
                return Err(self.wrong(unknown, what));
            }
            listed[variable] = true;
            outputs.push(Output { variable, dependencies });
        }
        for (variable, declared) in variables.iter().enumerate() {
            if declared.causality == Causality::Output && !listed[variable] {
                outputs.push(Output { variable, dependencies: None });
            }
        }
        Ok(outputs)
    }

    fn position(&self, element: &Element, index: &str, variables: &[Variable]) -> Result<usize> {
        match index.parse::<usize>() {
            Ok(index) if (1..=variables.len()).contains(&index) => Ok(index - 1),
            _ => Err(self
                .wrong(element, format!("the index '{index}' does not refer to a variable"))
                .why(format!("there are {} variables, counted from 1", variables.len()))),
        }
    }

    fn wrong(&self, element: &Element, what: impl Into<String>) -> Error {
        Error::new(Code::Description, what).at_line(self.file, element.line)
    }
}
