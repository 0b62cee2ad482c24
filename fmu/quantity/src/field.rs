//! The declaration of a variable, collected by walking the fields of a struct.
//!
//! The derive calls [`Field::member`] for each field of a struct, arrays call [`Field::element`]
//! or, if their elements have names, [`Field::elements`], and each leaf pushes one [`Declaration`]. Names are joined with a dot, descriptions with a
//! colon; unit, bounds and nominal value of a field apply to the leaves below it until one
//! overrides them.

use crate::Variables;

/// The declarations of a struct, in the order of its fields.
pub type Declarations = Vec<Declaration>;

/// A leaf: one scalar FMI variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Declaration {
    /// Name, description and attributes gathered on the way down.
    pub field: Field,
    /// Type and start value.
    pub start: Start,
}

/// The type of a variable together with its start value.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// `f64`
    Real(f64),
    /// `i32`
    Integer(i32),
    /// `bool`
    Boolean(bool),
    /// `String`
    String(String),
    /// An enum deriving `Enumeration`.
    Enumeration {
        /// Name of the type.
        name: &'static str,
        /// Description of the type.
        description: &'static str,
        /// Names and descriptions of the items, whose values are 1, 2, 3 …
        items: &'static [(&'static str, &'static str)],
        /// Value of the start item.
        value: i32,
    },
}

/// The position of the walk: a structured name and the attributes so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// Structured name, `thruster[0].force`; empty at the root.
    pub name: String,
    /// Descriptions of the fields on the way, joined by `: `.
    pub description: String,
    /// Unit, `kg.m2/s`.
    pub unit: Option<&'static str>,
    /// Smallest allowed value.
    pub min: Option<f64>,
    /// Largest allowed value.
    pub max: Option<f64>,
    /// Typical magnitude.
    pub nominal: Option<f64>,
    /// A parameter that may change while the simulation runs.
    pub tunable: bool,
    /// Units of members below this place, by their names.
    pub unit_of: &'static [(&'static str, &'static str)],
    /// Whether names and descriptions stay empty: a walk for values, units and bounds alone is
    /// several times faster.
    pub nameless: bool,
}

/// One field of a struct as the derive saw it, or a named element of an array.
///
/// ```
/// use fmu_quantity::Member;
///
/// /// Depth and heading.
/// const PLACE: [Member; 2] =
///     [Member::new("z", "down").unit("m"), Member::new("yaw", "from north").unit("rad")];
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Member {
    /// Name of the field.
    pub name: &'static str,
    /// First paragraph of its doc comment.
    pub description: &'static str,
    /// `#[var(unit = "…")]`
    pub unit: Option<&'static str>,
    /// `#[var(unit_of(… = "…"))]`
    pub unit_of: &'static [(&'static str, &'static str)],
    /// `#[var(min = …)]`
    pub min: Option<f64>,
    /// `#[var(max = …)]`
    pub max: Option<f64>,
    /// `#[var(nominal = …)]`
    pub nominal: Option<f64>,
    /// `#[var(tunable)]`
    pub tunable: bool,
}

impl Member {
    /// A member with its name and description, without unit and bounds.
    #[must_use]
    pub const fn new(name: &'static str, description: &'static str) -> Self {
        Self {
            name,
            description,
            unit: None,
            unit_of: &[],
            min: None,
            max: None,
            nominal: None,
            tunable: false,
        }
    }

    /// With its unit.
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit: Some(unit), ..self }
    }

    /// With its smallest allowed value.
    #[must_use]
    pub const fn min(self, min: f64) -> Self {
        Self { min: Some(min), ..self }
    }

    /// With its largest allowed value.
    #[must_use]
    pub const fn max(self, max: f64) -> Self {
        Self { max: Some(max), ..self }
    }

    /// With its typical magnitude.
    #[must_use]
    pub const fn nominal(self, nominal: f64) -> Self {
        Self { nominal: Some(nominal), ..self }
    }
}

impl Field {
    /// The root of a walk without names and descriptions.
    #[must_use]
    pub fn nameless() -> Self {
        Self { nameless: true, ..Self::default() }
    }

    /// The field `member` of the struct at this place.
    #[must_use]
    pub fn member(&self, member: &Member) -> Self {
        let join = |parent: &str, separator: &str, own: &str| match (parent, own) {
            _ if self.nameless => String::new(),
            ("", text) | (text, "") => text.to_owned(),
            (parent, own) => format!("{parent}{separator}{own}"),
        };
        let from_above = self.unit_of.iter().find(|(name, _)| *name == member.name);
        let unit_of = if member.unit_of.is_empty() { self.unit_of } else { member.unit_of };
        Self {
            name: join(&self.name, ".", member.name),
            description: join(&self.description, ": ", member.description),
            unit: from_above.map(|(_, unit)| *unit).or(member.unit).or(self.unit),
            unit_of,
            min: member.min.or(self.min),
            max: member.max.or(self.max),
            nominal: member.nominal.or(self.nominal),
            tunable: member.tunable || self.tunable,
            nameless: self.nameless,
        }
    }

    /// Element `index` of the array at this place, counted from zero.
    #[must_use]
    pub fn element(&self, index: usize) -> Self {
        if self.nameless {
            return self.clone();
        }
        Self {
            name: format!("{}[{index}]", self.name),
            description: format!("{} {index}", self.description),
            ..self.clone()
        }
    }

    /// Declares an array whose elements have names, as those of a vector.
    pub fn elements<T: Variables, const N: usize>(
        &self,
        values: &[T; N],
        members: &[Member; N],
        into: &mut Declarations,
    ) {
        for (value, member) in values.iter().zip(members) {
            value.declare(&self.member(member), into);
        }
    }

    /// Declares an array whose elements are numbered and have one member each:
    /// `thruster[0].force`.
    pub fn each<T: Variables, const N: usize>(
        &self,
        values: &[T; N],
        member: &Member,
        into: &mut Declarations,
    ) {
        for (index, value) in values.iter().enumerate() {
            value.declare(&self.element(index).member(member), into);
        }
    }
}
