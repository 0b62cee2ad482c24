//! `<Functions>`: linear transformations and sums.

use std::collections::HashSet;
use std::sync::Arc;

use super::Reader;
use crate::system::function::{Function, MAX_PORTS};
use crate::system::raw::{Place, RawComponent, RawConnection, RawModel, Stage, Transformation};
use cosim_base::error::{Code, Error, Result};
use cosim_base::xml::Element;

/// Memory for a port of a sum, in bytes.
const PER_PORT: usize = 512;

/// A linear transformation: y = offset + factor x.
pub(super) struct Linear {
    pub name: String,
    pub factor: f64,
    pub offset: f64,
    pub place: Place,
    /// The variable at `in`.
    pub source: Option<(String, String)>,
    /// Connections at `out`, by position.
    pub sinks: Vec<usize>,
}

impl Reader {
    pub(super) fn functions(&mut self, root: &Element) {
        let Some(list) = root.child("Functions") else {
            return;
        };
        self.known(list, &["LinearTransformation", "Sum", "VectorSum"], &[]);
        for element in &list.children {
            let done = match element.name.as_str() {
                "LinearTransformation" => self.linear(element),
                "Sum" => self.sum(element, &["name", "inputCount"]),
                "VectorSum" => self.sum(element, &["name", "inputCount", "dimension"]),
                // Already reported as unknown.
                _ => Ok(()),
            };
            self.gathered.take(done);
        }
    }

    fn linear(&mut self, element: &Element) -> Result<()> {
        self.known(element, &[], &["name", "factor", "offset"]);
        let number = |name| element.parse::<f64>(name, &self.file, Code::Ssd);
        let (factor, offset) = (number("factor")?.unwrap_or(1.0), number("offset")?.unwrap_or(0.0));
        if !factor.is_finite() || !offset.is_finite() {
            return Err(self.wrong(element, "factor and offset must be finite"));
        }
        let name = element.require("name", &self.file, Code::Ssd)?.to_owned();
        let place = self.place(element);
        if let Some(first) = self.linear_by_name.get(&name).map(|&at| &self.linear[at]) {
            return Err(self
                .wrong(element, format!("two functions are named '{name}'"))
                .why(format!("the first on line {}", first.place.line)));
        }
        self.linear_by_name.insert(name.clone(), self.linear.len());
        self.linear.push(Linear { name, factor, offset, place, source: None, sinks: Vec::new() });
        Ok(())
    }

    fn sum(&mut self, element: &Element, attributes: &[&str]) -> Result<()> {
        self.known(element, &[], attributes);
        let name = element.require("name", &self.file, Code::Ssd)?;
        let count = |name| element.parse::<usize>(name, &self.file, Code::Ssd);
        element.require("inputCount", &self.file, Code::Ssd)?;
        let inputs = count("inputCount")?.unwrap_or(0);
        let dimension = match element.name.as_str() {
            "VectorSum" => {
                element.require("dimension", &self.file, Code::Ssd)?;
                count("dimension")?
            }
            _ => None,
        };
        let ports = inputs.saturating_add(1).saturating_mul(dimension.unwrap_or(1));
        let ports = ports.min(2 * MAX_PORTS);
        self.spend(ports.saturating_mul(PER_PORT), element)?;
        let function = Function::sum(name, inputs, dimension).ok_or_else(|| {
            self.wrong(element, format!("'{name}' has {inputs} inputs"))
                .why(format!("inputCount times dimension must be 1 to {MAX_PORTS}"))
        })?;
        let place = self.place(element);
        self.add(RawComponent {
            name: name.to_owned(),
            model: RawModel::Function(Arc::new(function)),
            interface: None,
            step: None,
            worker: None,
            connectors: None,
            place,
        });
        Ok(())
    }

    /// A connection from `out` represents the whole path, in its place among the others.
    pub(super) fn through(
        &mut self,
        linear: usize,
        to: (String, String),
        place: Place,
    ) -> Result<()> {
        let linear = &mut self.linear[linear];
        self.gathered.spend(linear.name.len(), &place)?;
        linear.sinks.push(self.connections.len());
        let (factor, offset) = (linear.factor, linear.offset);
        let stage = Stage {
            transformation: Some(Transformation::Linear { factor, offset }),
            // Such a function is meant to use the numbers unconverted.
            suppress_unit_conversion: true,
            unit: None,
        };
        let from = (linear.name.clone(), "out".to_owned());
        self.connections.push(RawConnection { from, to, stages: vec![stage], place });
        Ok(())
    }

    /// Sets the sources of the connections through linear transformations.
    pub(super) fn join_linear(&mut self) {
        let mut without_source = HashSet::new();
        for linear in std::mem::take(&mut self.linear) {
            if linear.sinks.is_empty() {
                self.gathered.warnings.push(format!(
                    "{}: nothing is connected to 'out' of the function '{}': it is left out",
                    linear.place, linear.name
                ));
            }
            if let Some(source) = linear.source {
                let size = (source.0.len() + source.1.len()) * linear.sinks.len();
                let affordable = self.gathered.spend(size, &linear.place);
                if self.gathered.take(affordable).is_none() {
                    return;
                }
                for sink in linear.sinks {
                    self.connections[sink].from = source.clone();
                }
                continue;
            }
            let what = format!("nothing is connected to 'in' of the function '{}'", linear.name);
            self.gathered.problems.push(linear.place.mark(Error::new(Code::Connection, what)));
            without_source.extend(linear.sinks);
        }
        let mut position = 0;
        self.connections.retain(|_| {
            position += 1;
            !without_source.contains(&(position - 1))
        });
    }
}
