//! The variable table: every variable of a component with all its FMI attributes.
//!
//! Value references are indices into the value arrays of their type. Reals are in the order
//! parameters, inputs, outputs, states, derivatives, time; the other types in the same order, as
//! far as they have these.

use std::collections::BTreeMap;
use std::ops::Range;

use fmu_standard::{Basic, Unit};

use crate::author::{Component, Count, Declaration, Declarations, Field, Start, Variables};

use super::parameters::Parameters;
use super::unit::{is_type_name, per_second};
use super::values::Values;

/// The group of a variable; causality, variability and initial follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Fixed once initialization is over.
    Parameter,
    /// Set by the importer.
    Input,
    /// Read by the importer.
    Output,
    /// A continuous state.
    State,
    /// The derivative of the state of the same index.
    Derivative,
    /// The independent variable.
    Time,
}

impl Group {
    /// Its variables in words, for log lines.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Parameter => "parameters",
            Self::Input => "inputs",
            Self::Output => "outputs",
            Self::State => "continuous states",
            Self::Derivative => "state derivatives",
            Self::Time => "time",
        }
    }
}

/// One scalar variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// The group it belongs to.
    pub group: Group,
    /// Index into the value array of its type.
    pub reference: u32,
    /// Structured name.
    pub name: String,
    /// Description.
    pub description: String,
    /// Type and start value.
    pub start: Start,
    /// Unit.
    pub unit: Option<String>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Typical magnitude.
    pub nominal: Option<f64>,
    /// A parameter that may change while the simulation runs.
    pub tunable: bool,
}

impl Variable {
    /// Whether it is one of the Reals.
    pub(crate) fn is_real(&self) -> bool {
        matches!(self.start, Start::Real(_))
    }

    /// Whether it can be set after initialization.
    pub(crate) fn is_settable_later(&self) -> bool {
        self.group == Group::Input || (self.group == Group::Parameter && self.tunable)
    }
}

/// Why a table is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// Two variables share a name.
    #[error("two variables are called \"{0}\"; nest one of them in a struct to give it a prefix")]
    Duplicate(String),
    /// A start value is not finite or out of bounds.
    #[error("start value {value} of \"{name}\" is not within {min} and {max}")]
    Start {
        /// The variable.
        name: String,
        /// Its start value.
        value: f64,
        /// Lower bound.
        min: f64,
        /// Upper bound.
        max: f64,
    },
    /// A unit cannot be read.
    #[error("\"{name}\": {reason}")]
    Unit {
        /// The variable.
        name: String,
        /// What is wrong with its unit.
        reason: String,
    },
    /// Two enumerations share a type name but not their items.
    #[error("two enumeration types are called \"{0}\"; rename one")]
    Enumeration(String),
    /// A name that the description needs for a type of Real.
    #[error("\"{0}\" is the name of a type of numbers in every description; choose another")]
    TypeName(String),
}

/// The positions of the groups of Reals, and how many parameters of each type there are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Parameters come first in every array.
    pub parameters: Count,
    /// Inputs among the Reals.
    pub inputs: Range<usize>,
    /// Outputs among the Reals.
    pub outputs: Range<usize>,
    /// How many variables of each type come before the inputs and before the outputs.
    pub before: [Count; 2],
    /// States among the Reals.
    pub states: Range<usize>,
    /// Derivatives among the Reals.
    pub derivatives: Range<usize>,
    /// Time among the Reals, the last.
    pub time: usize,
}

/// All variables of a component, in the order of the description.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    variables: Vec<Variable>,
    layout: Layout,
    indicators: &'static [&'static str],
    tangent: bool,
    any_input: bool,
}

impl Table {
    /// The table of a component.
    ///
    /// # Errors
    /// Names the variable whose declaration is invalid.
    pub fn of<C: Component>() -> Result<Self, TableError> {
        let table = Self::new(
            declarations(&Parameters::<C>::with(C::Parameters::default())),
            declarations(&C::Inputs::default()),
            declarations(&C::Outputs::default()),
            declarations(&C::States::default()),
        )?;
        let (indicators, tangent, any_input) = (C::INDICATORS, C::TANGENT, C::ANY_INPUT);
        Ok(Self { indicators, tangent, any_input, ..table })
    }

    /// The table of four groups of declared variables.
    ///
    /// # Errors
    /// Names the variable whose declaration is invalid.
    pub fn new(
        parameters: Declarations,
        inputs: Declarations,
        outputs: Declarations,
        states: Declarations,
    ) -> Result<Self, TableError> {
        let mut table = Builder::default();
        let derivatives = states.iter().map(derivative).collect();
        let time = Declaration {
            field: Field {
                name: "time".to_owned(),
                description: "Simulation time".to_owned(),
                unit: Some("s"),
                ..Field::default()
            },
            start: Start::Real(0.0),
        };
        table.add(Group::Parameter, parameters, None);
        let count = table.count;
        let inputs = table.add(Group::Input, inputs, None);
        let before = [count, table.count];
        let outputs = table.add(Group::Output, outputs, None);
        let units: Vec<_> = states.iter().map(|state| per_second(state.field.unit)).collect();
        let states = table.add(Group::State, states, None);
        let derivatives = table.add(Group::Derivative, derivatives, Some(&units));
        let time = table.add(Group::Time, vec![time], None).start;
        let layout =
            Layout { parameters: count, inputs, outputs, before, states, derivatives, time };
        check(&table.variables)?;
        Ok(Self { variables: table.variables, layout, ..Self::default() })
    }

    /// The variables, in the order of the description.
    #[must_use]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// The positions of the groups.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Names of the event indicators.
    #[must_use]
    pub fn indicators(&self) -> &'static [&'static str] {
        self.indicators
    }

    /// Whether there are directional derivatives.
    #[must_use]
    pub fn has_tangent(&self) -> bool {
        self.tangent
    }

    /// Whether inputs may be infinite or not a number.
    #[must_use]
    pub fn takes_any_input(&self) -> bool {
        self.any_input
    }

    /// The variables of a group with their indices in the description, from zero.
    pub fn group(&self, group: Group) -> impl Iterator<Item = (usize, &Variable)> {
        self.variables.iter().enumerate().filter(move |(_, variable)| variable.group == group)
    }

    /// The variable of a type and value reference.
    pub(crate) fn find(&self, kind: Basic, reference: u32) -> Option<&Variable> {
        self.variables
            .iter()
            .find(|variable| variable.reference == reference && kind == basic(&variable.start))
    }

    /// The variable of a name.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// Every variable at its start value.
    pub(crate) fn start_values(&self) -> Values {
        let count = self.variables.iter().fold(Count::NONE, |n, v| n.plus(one(&v.start)));
        let mut values = Values::zeros(count);
        let (mut reals, mut integers) = (values.reals.iter_mut(), values.integers.iter_mut());
        let (mut booleans, mut strings) = (values.booleans.iter_mut(), values.strings.iter_mut());
        for variable in &self.variables {
            match &variable.start {
                Start::Real(start) => set(reals.next(), *start),
                Start::Integer(start) | Start::Enumeration { value: start, .. } => {
                    set(integers.next(), *start);
                }
                Start::Boolean(start) => set(booleans.next(), *start),
                Start::String(start) => {
                    let [text] = &*Values::of(start).strings else {
                        continue;
                    };
                    set(strings.next(), text.clone());
                }
            }
        }
        values
    }
}

fn set<T>(place: Option<&mut T>, value: T) {
    if let Some(place) = place {
        *place = value;
    }
}

/// The base type of a start value.
fn basic(start: &Start) -> Basic {
    match start {
        Start::Real(_) => Basic::Real,
        Start::Integer(_) | Start::Enumeration { .. } => Basic::Integer,
        Start::Boolean(_) => Basic::Boolean,
        Start::String(_) => Basic::String,
    }
}

fn one(start: &Start) -> Count {
    match basic(start) {
        Basic::Real => f64::COUNT,
        Basic::Integer => i32::COUNT,
        Basic::Boolean => bool::COUNT,
        Basic::String => String::COUNT,
    }
}

fn declarations(group: &impl Variables) -> Declarations {
    let mut list = Declarations::new();
    group.declare(&Field::default(), &mut list);
    list
}

fn derivative(state: &Declaration) -> Declaration {
    let description = format!("Time derivative of {}", state.field.name);
    let name = format!("der({})", state.field.name);
    Declaration { field: Field { name, description, ..Field::default() }, start: Start::Real(0.0) }
}

#[derive(Default)]
struct Builder {
    variables: Vec<Variable>,
    count: Count,
}

impl Builder {
    /// Appends a group and returns the position of its Reals.
    fn add(
        &mut self,
        group: Group,
        declarations: Declarations,
        units: Option<&[String]>,
    ) -> Range<usize> {
        let from = self.count.reals;
        for (index, Declaration { field, start }) in declarations.into_iter().enumerate() {
            let reference = match basic(&start) {
                Basic::Real => self.count.reals,
                Basic::Integer => self.count.integers,
                Basic::Boolean => self.count.booleans,
                Basic::String => self.count.strings,
            };
            self.count = self.count.plus(one(&start));
            let given = units.and_then(|units| units.get(index)).cloned();
            // A number without a unit gets unit 1: to importers, no unit means an unknown one.
            let plain = matches!(start, Start::Real(_)).then(|| "1".to_owned());
            self.variables.push(Variable {
                group,
                reference: u32::try_from(reference).unwrap_or(u32::MAX),
                name: field.name,
                description: field.description,
                start,
                unit: given.or(field.unit.map(str::to_owned)).or(plain),
                min: field.min,
                max: field.max,
                nominal: field.nominal,
                tunable: field.tunable,
            });
        }
        from..self.count.reals
    }
}

fn check(variables: &[Variable]) -> Result<(), TableError> {
    let mut names = std::collections::BTreeSet::new();
    let mut types = BTreeMap::new();
    for variable in variables {
        let name = &variable.name;
        if !names.insert(name) {
            return Err(TableError::Duplicate(name.clone()));
        }
        if is_type_name(name) {
            return Err(TableError::TypeName(name.clone()));
        }
        if let Some(reason) = variable.unit.as_deref().and_then(|unit| Unit::parse(unit).err()) {
            return Err(TableError::Unit { name: name.clone(), reason });
        }
        let value = match &variable.start {
            Start::Real(value) => *value,
            Start::Integer(value) => f64::from(*value),
            Start::Enumeration { name, items, .. } => {
                if is_type_name(name) {
                    return Err(TableError::TypeName((*name).to_owned()));
                }
                if types.insert(*name, *items).is_some_and(|earlier| earlier != *items) {
                    return Err(TableError::Enumeration((*name).to_owned()));
                }
                continue;
            }
            Start::Boolean(_) | Start::String(_) => continue,
        };
        let (min, max) = (variable.min.unwrap_or(f64::MIN), variable.max.unwrap_or(f64::MAX));
        if !(min..=max).contains(&value) {
            return Err(TableError::Start { name: name.clone(), value, min, max });
        }
    }
    Ok(())
}
