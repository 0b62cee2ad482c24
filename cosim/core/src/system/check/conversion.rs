//! The conversion of a value between two variables: units along the path, transformations, maps.
//!
//! A value passes through the unit of its variable, that of the listed connector, those of
//! connectors of systems, and so on to the variable at the other end. Between two known units of
//! the same dimension it is converted, unless the connection suppresses that; different dimensions
//! are an error.

use std::collections::HashMap;

use crate::system::Conversion;
use crate::system::raw::{RawUnit, Stage, Transformation};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::units::{Linear, Units};
use cosim_import::{Kind, Variable};

/// The units at one end.
pub(super) struct Measured<'a> {
    pub variable: &'a Variable,
    /// Unit definitions of the variable's FMU.
    pub units: &'a Units,
    /// Unit of the listed connector.
    pub connector: Option<&'a RawUnit>,
}

/// Findings along the path.
pub(super) struct Way {
    pub conversion: Option<Conversion>,
    /// The first or the last unit, if the other end has none.
    pub missing: Option<String>,
    /// A unit that differs and is not defined anywhere, or that is suppressed.
    pub undefined: Option<String>,
    /// Units that were converted: from and to.
    pub converted: Option<(String, String)>,
}

impl Measured<'_> {
    fn own(&self) -> Option<RawUnit> {
        let name = self.variable.unit.as_ref()?;
        Some(RawUnit { name: name.clone(), unit: self.units.get(name).copied() })
    }

    /// The unit of the connector; if its file does not define it, the FMU may.
    fn listed(&self) -> Option<RawUnit> {
        self.connector.map(|unit| define(unit, self.units))
    }
}

fn define(unit: &RawUnit, units: &Units) -> RawUnit {
    let defined = unit.unit.or_else(|| units.get(&unit.name).copied());
    RawUnit { name: unit.name.clone(), unit: defined }
}

/// The path of a Real.
struct Walk {
    linear: Linear,
    unit: Option<RawUnit>,
    undefined: Option<String>,
}

impl Walk {
    /// Continues to `target`; nothing is converted if a unit is unknown.
    fn to(&mut self, target: Option<RawUnit>, suppress: bool) -> Result<()> {
        let Some(target) = target else {
            return Ok(());
        };
        if let (Some(unit), false) = (&self.unit, suppress) {
            match (&unit.unit, &target.unit) {
                (Some(from), Some(to)) => {
                    let linear = Linear::between(from, to).ok_or_else(|| {
                        Error::new(Code::Unit, format!("{} meets {}", unit.name, target.name)).why(
                            format!(
                                "they are of different dimensions: {} and {}",
                                from.dimension(),
                                to.dimension()
                            ),
                        )
                    })?;
                    self.linear = self.linear.then(linear);
                }
                _ if unit.name != target.name => {
                    self.undefined = Some(format!("{} and {}", unit.name, target.name));
                }
                _ => (),
            }
        }
        self.unit = Some(target);
        Ok(())
    }

    fn transform(&mut self, transformation: Option<&Transformation>) {
        if let Some(Transformation::Linear { factor, offset }) = transformation {
            self.linear = self.linear.then(Linear { factor: *factor, offset: *offset });
        }
    }

    fn conversion(&self) -> Option<Conversion> {
        (self.linear != Linear::IDENTITY).then_some(Conversion::Linear(self.linear))
    }
}

/// The path from an output to an input.
pub(super) fn between(from: &Measured, to: &Measured, stages: &[Stage]) -> Result<Way> {
    let mut way = Way { conversion: None, missing: None, undefined: None, converted: None };
    if let Some(map) = map(&from.variable.kind, &to.variable.kind, stages)? {
        way.conversion = Some(Conversion::Map(map));
        return Ok(way);
    }
    if from.variable.kind != Kind::Real {
        return Ok(way);
    }
    let mut walk = Walk { linear: Linear::IDENTITY, unit: from.own(), undefined: None };
    walk.to(from.listed(), false)?;
    let first = walk.unit.clone();
    walk_through(&mut walk, to, stages)?;
    let last = to.own().or(to.listed());
    way.missing = match (&first, &last) {
        (Some(unit), None) | (None, Some(unit)) => Some(unit.name.clone()),
        _ => None,
    };
    if let (Some(first), Some(last)) = (&first, &last) {
        let suppressed = stages.iter().any(|s| s.suppress_unit_conversion);
        if first.name != last.name && walk.undefined.is_none() && !suppressed {
            way.converted = Some((first.name.clone(), last.name.clone()));
        }
    }
    way.conversion = walk.conversion();
    way.undefined = walk.undefined;
    Ok(way)
}

fn walk_through(walk: &mut Walk, to: &Measured, stages: &[Stage]) -> Result<()> {
    for (position, stage) in stages.iter().enumerate() {
        let target = match position + 1 == stages.len() {
            true => to.listed().or_else(|| to.own()),
            false => stage.unit.clone(),
        };
        walk.to(target, stage.suppress_unit_conversion)?;
        walk.transform(stage.transformation.as_ref());
    }
    walk.to(to.own(), false)
}

/// The path of a value in a file, a Real in `unit`, to its variable.
pub(super) fn of_value(unit: Option<&RawUnit>, to: &Measured, stages: &[Stage]) -> Result<Way> {
    let unit = unit.map(|unit| define(unit, to.units));
    let mut walk = Walk { linear: Linear::IDENTITY, unit: unit.clone(), undefined: None };
    walk_through(&mut walk, to, stages)?;
    Ok(Way {
        conversion: walk.conversion(),
        missing: None,
        undefined: walk.undefined,
        converted: None,
    })
}

/// The path of an output to a connector of the outermost system.
pub(super) fn outward(from: &Measured, stages: &[Stage]) -> Result<Way> {
    let mut walk = Walk { linear: Linear::IDENTITY, unit: from.own(), undefined: None };
    walk.to(from.listed(), false)?;
    for stage in stages {
        let target = stage.unit.as_ref().map(|unit| define(unit, from.units));
        walk.to(target, stage.suppress_unit_conversion)?;
        walk.transform(stage.transformation.as_ref());
    }
    let (conversion, undefined) = (walk.conversion(), walk.undefined);
    Ok(Way { conversion, missing: None, undefined, converted: None })
}

/// The effect of the mappings among the stages on integers; `None` if there are none.
pub(super) fn map(from: &Kind, to: &Kind, stages: &[Stage]) -> Result<Option<Vec<(i32, i32)>>> {
    let mut whole: Option<Vec<(i32, i32)>> = None;
    let transformations = stages.iter().filter_map(|s| s.transformation.as_ref());
    for transformation in transformations {
        let entries = match (transformation, from, to) {
            (Transformation::Linear { .. }, Kind::Real, Kind::Real) => continue,
            (Transformation::Boolean(entries), Kind::Boolean, Kind::Boolean) => {
                entries.iter().map(|&(a, b)| (i32::from(a), i32::from(b))).collect()
            }
            (
                Transformation::Integer(entries),
                Kind::Integer | Kind::Enumeration(_),
                Kind::Integer | Kind::Enumeration(_),
            ) => entries.clone(),
            (Transformation::Enumeration(names), Kind::Enumeration(a), Kind::Enumeration(b)) => {
                let (a, b) = (Items::of(a), Items::of(b));
                let pairs = names.iter().map(|(from, to)| Ok((a.value(from)?, b.value(to)?)));
                pairs.collect::<Result<Vec<_>>>()?
            }
            (other, ..) => return Err(misfit(other, from, to)),
        };
        whole = Some(match whole {
            None => entries,
            Some(before) => {
                // Of two entries for one value, the first counts.
                let next: HashMap<i32, i32> = entries.into_iter().rev().collect();
                before.into_iter().filter_map(|(a, b)| Some((a, *next.get(&b)?))).collect()
            }
        });
    }
    Ok(whole)
}

/// The items of an enumeration by name; of two with one name, the first counts.
struct Items<'a> {
    all: &'a [(String, i32)],
    values: HashMap<&'a str, i32>,
}

impl<'a> Items<'a> {
    fn of(all: &'a [(String, i32)]) -> Self {
        Self {
            all,
            values: all.iter().rev().map(|(name, value)| (name.as_str(), *value)).collect(),
        }
    }

    fn value(&self, name: &str) -> Result<i32> {
        self.values.get(name).copied().ok_or_else(|| {
            Error::new(Code::UnknownName, format!("the enumeration has no item '{name}'"))
                .maybe_help(names::did_you_mean(name, self.all.iter().map(|(n, _)| n.as_str())))
        })
    }
}

fn misfit(transformation: &Transformation, from: &Kind, to: &Kind) -> Error {
    let (name, wanted) = match transformation {
        Transformation::Linear { .. } => ("LinearTransformation", "Real"),
        Transformation::Boolean(_) => ("BooleanMappingTransformation", "Boolean"),
        Transformation::Integer(_) => ("IntegerMappingTransformation", "Integer or Enumeration"),
        Transformation::Enumeration(_) => ("EnumerationMappingTransformation", "Enumeration"),
    };
    let what = format!("<{name}> between {} and {}", from.name(), to.name());
    Error::new(Code::Connection, what).why(format!("it changes values of the type {wanted}"))
}
