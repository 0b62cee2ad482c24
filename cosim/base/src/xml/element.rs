//! The tree: elements with their line, attributes and children.

use std::fmt;
use std::ops::Deref;
use std::path::Path;
use std::sync::Arc;

use crate::error::{Code, Error, Result};
use crate::names;

/// An element.
#[derive(Debug, Clone)]
pub struct Element {
    /// The URI of the namespace, empty if there is none.
    pub namespace: Name,
    /// The name without its prefix.
    pub name: Name,
    /// The line of its start tag.
    pub line: usize,
    /// Attributes in order, without namespace declarations.
    pub attributes: Vec<Attribute>,
    /// Child elements in order.
    pub children: Vec<Element>,
    /// The text directly inside.
    pub text: String,
}

/// An attribute.
#[derive(Debug, Clone)]
pub struct Attribute {
    /// The name as written, with its prefix.
    pub name: Name,
    /// The value, unescaped.
    pub value: String,
}

/// A name or namespace. A document stores each of them once.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Name(Arc<str>);

impl Name {
    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl From<Arc<str>> for Name {
    fn from(text: Arc<str>) -> Self {
        Self(text)
    }
}

impl From<&str> for Name {
    fn from(text: &str) -> Self {
        Self(text.into())
    }
}

impl Deref for Name {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

impl PartialEq<str> for Name {
    fn eq(&self, other: &str) -> bool {
        &*self.0 == other
    }
}

impl PartialEq<&str> for Name {
    fn eq(&self, other: &&str) -> bool {
        &*self.0 == *other
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

impl Element {
    /// The value of an attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|a| a.name == name).map(|a| a.value.as_str())
    }

    /// The value of a required attribute.
    pub fn require(&self, name: &str, file: &Path, code: Code) -> Result<&str> {
        self.get(name).ok_or_else(|| {
            Error::new(code, format!("<{}> has no attribute '{name}'", self.name))
                .at_line(file, self.line)
                .maybe_help(names::did_you_mean(
                    name,
                    self.attributes.iter().map(|a| a.name.as_str()),
                ))
        })
    }

    /// The value of an attribute as a number, a Boolean ...; `None` if it is absent.
    pub fn parse<T: std::str::FromStr>(
        &self,
        name: &str,
        file: &Path,
        code: Code,
    ) -> Result<Option<T>> {
        let Some(text) = self.get(name) else {
            return Ok(None);
        };
        text.trim().parse().map(Some).map_err(|_| {
            let kind = std::any::type_name::<T>();
            Error::new(code, format!("{name}=\"{text}\" of <{}> is not a valid {kind}", self.name))
                .at_line(file, self.line)
        })
    }

    /// The first child of that name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|c| c.name == name)
    }

    /// The children of the first child of that name: `<Units><Unit/><Unit/></Units>`.
    pub fn grandchildren(&self, name: &str) -> &[Element] {
        self.child(name).map_or(&[], |c| &c.children)
    }

    /// `true`, `1` and `false`, `0` as in XML Schema.
    pub fn flag(&self, name: &str, file: &Path, code: Code) -> Result<bool> {
        match self.get(name).map(str::trim) {
            None | Some("false" | "0") => Ok(false),
            Some("true" | "1") => Ok(true),
            Some(text) => Err(Error::new(
                code,
                format!("{name}=\"{text}\" of <{}> is neither true nor false", self.name),
            )
            .at_line(file, self.line)),
        }
    }
}
