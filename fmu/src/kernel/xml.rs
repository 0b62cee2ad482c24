//! Writing XML: elements, attributes, indentation, escaping. The same input gives the same bytes.

use std::fmt::Display;

/// An XML document being written.
pub(crate) struct Xml {
    text: String,
    open: Vec<&'static str>,
}

/// An element whose attributes are being written; closes itself if it gets no children.
pub(crate) struct Element<'a> {
    xml: &'a mut Xml,
    name: &'static str,
}

impl Xml {
    pub(crate) fn new() -> Self {
        let declaration = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
        Self { text: declaration.to_owned(), open: Vec::new() }
    }

    /// Starts an element; finish it with `children` or `empty`.
    pub(crate) fn element(&mut self, name: &'static str) -> Element<'_> {
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        Element { xml: self, name }
    }

    /// Closes the innermost open element.
    pub(crate) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            self.text.push_str(&format!("</{name}>\n"));
        }
    }

    pub(crate) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }

    fn indent(&mut self) {
        for _ in &self.open {
            self.text.push_str("  ");
        }
    }
}

impl Element<'_> {
    pub(crate) fn attribute(self, name: &str, value: impl Display) -> Self {
        let value = escape(&value.to_string());
        self.xml.text.push_str(&format!(" {name}=\"{value}\""));
        self
    }

    /// An attribute that is omitted if it is empty.
    pub(crate) fn maybe(self, name: &str, value: Option<impl Display>) -> Self {
        match value {
            Some(value) => self.attribute(name, value),
            None => self,
        }
    }

    pub(crate) fn empty(self) {
        self.xml.text.push_str("/>\n");
    }

    pub(crate) fn children(self) {
        self.xml.text.push_str(">\n");
        self.xml.open.push(self.name);
    }
}

/// An attribute's text; control characters that XML cannot contain become spaces.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' => escaped.push_str("&#10;"),
            '\t' => escaped.push_str("&#9;"),
            '\r' => escaped.push_str("&#13;"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A number in the shortest form that reads back to the same bits.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}
