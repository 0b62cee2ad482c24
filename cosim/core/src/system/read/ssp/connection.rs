//! `<ssd:Connection>` and its conversion of the value.

use super::flatten::{End, Wire};
use super::{Reader, join};
use crate::system::raw::{Stage, Transformation};
use cosim_base::error::{Code, Result};
use cosim_base::xml::Element;

/// The elements that change a value.
pub(super) const TRANSFORMATIONS: [&str; 4] = [
    "LinearTransformation",
    "BooleanMappingTransformation",
    "IntegerMappingTransformation",
    "EnumerationMappingTransformation",
];

impl Reader<'_> {
    /// A connection of the system `path`.
    pub(super) fn wire(&mut self, element: &Element, path: &str) -> Result<Wire> {
        if element.name != "Connection" {
            return Err(
                self.wrong(element, format!("<{}> among connections is unknown", element.name))
            );
        }
        let children = [&TRANSFORMATIONS[..], &["ConnectionGeometry", "Annotations"]].concat();
        let children = [&children[..], &["MetaData", "Signature"]].concat();
        self.known(
            element,
            &children,
            &[
                "startElement",
                "startConnector",
                "endElement",
                "endConnector",
                "suppressUnitConversion",
                "startIndices",
                "endIndices",
            ],
        );
        if element.get("startIndices").or(element.get("endIndices")).is_some() {
            return Err(self.unsupported(element, "connections of parts of arrays"));
        }
        let end = |which: [&str; 2]| -> Result<End> {
            Ok(End {
                // Empty is the same as missing: some tools write it for the system itself.
                element: (element.get(which[0]).filter(|name| !name.is_empty()))
                    .map(|name| join(path, name)),
                connector: element.require(which[1], &self.file, Code::Ssd)?.to_owned(),
            })
        };
        Ok(Wire {
            system: path.to_owned(),
            start: end(["startElement", "startConnector"])?,
            end: end(["endElement", "endConnector"])?,
            stage: self.stage(element)?,
            place: self.place(element),
        })
    }

    /// The conversion of a value by a connection or a mapping entry.
    pub(super) fn stage(&mut self, element: &Element) -> Result<Stage> {
        let all = element.children.iter();
        let mut all = all.filter(|c| TRANSFORMATIONS.contains(&c.name.as_str()));
        let transformation = all.next().map(|e| self.transformation(e)).transpose()?;
        if let Some(second) = all.next() {
            return Err(self.wrong(second, format!("a second transformation, <{}>", second.name)));
        }
        let suppress = element.flag("suppressUnitConversion", &self.file, Code::Ssd)?;
        Ok(Stage { transformation, suppress_unit_conversion: suppress, unit: None })
    }

    fn transformation(&mut self, element: &Element) -> Result<Transformation> {
        if element.name == "LinearTransformation" {
            self.known(element, &[], &["factor", "offset"]);
            let number = |name| element.parse::<f64>(name, &self.file, Code::Ssd);
            let (factor, offset) =
                (number("factor")?.unwrap_or(1.0), number("offset")?.unwrap_or(0.0));
            if !factor.is_finite() || !offset.is_finite() {
                return Err(self.wrong(element, "factor and offset must be finite"));
            }
            return Ok(Transformation::Linear { factor, offset });
        }
        self.known(element, &["MapEntry"], &[]);
        let entries = element.children.iter();
        Ok(match element.name.as_str() {
            "BooleanMappingTransformation" => Transformation::Boolean(
                entries
                    .map(|entry| {
                        self.entry(entry)?;
                        let flag = |name| entry.flag(name, &self.file, Code::Ssd);
                        Ok((flag("source")?, flag("target")?))
                    })
                    .collect::<Result<_>>()?,
            ),
            "IntegerMappingTransformation" => Transformation::Integer(
                entries
                    .map(|entry| {
                        self.entry(entry)?;
                        let number = |name| entry.parse(name, &self.file, Code::Ssd);
                        Ok((number("source")?.unwrap_or(0), number("target")?.unwrap_or(0)))
                    })
                    .collect::<Result<_>>()?,
            ),
            _ => Transformation::Enumeration(
                entries
                    .map(|entry| {
                        let (source, target) = self.entry(entry)?;
                        Ok((source.to_owned(), target.to_owned()))
                    })
                    .collect::<Result<_>>()?,
            ),
        })
    }

    fn entry<'e>(&self, entry: &'e Element) -> Result<(&'e str, &'e str)> {
        let text = |name| entry.require(name, &self.file, Code::Ssd);
        Ok((text("source")?, text("target")?))
    }
}
