//! Writing XML: elements, attributes, indentation, escaping. The same input gives the same bytes.

use std::fmt::Display;

/// An XML document being written.
#[derive(Debug)]
pub struct Xml {
    text: String,
    open: Vec<String>,
}

/// An element whose attributes are being written; closes itself if it gets no children.
#[derive(Debug)]
#[must_use]
pub struct Element<'a> {
    xml: &'a mut Xml,
    name: &'a str,
}

impl Default for Xml {
    fn default() -> Self {
        Self::new()
    }
}

impl Xml {
    /// A document without elements.
    #[must_use]
    pub fn new() -> Self {
        let declaration = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
        Self { text: declaration.to_owned(), open: Vec::new() }
    }

    /// Starts an element; finish it with `children`, `text` or `empty`.
    pub fn element<'a>(&'a mut self, name: &'a str) -> Element<'a> {
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        Element { xml: self, name }
    }

    /// `<name attributes>`, until [`Xml::close`].
    pub fn start(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.element(name).attributes(attributes).children();
    }

    /// `<name attributes/>`.
    pub fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) {
        self.element(name).attributes(attributes).empty();
    }

    /// Closes the innermost open element.
    pub fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            self.text.push_str(&format!("</{name}>\n"));
        }
    }

    /// The text, with all elements closed.
    #[must_use]
    pub fn finish(mut self) -> String {
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
    /// Adds an attribute.
    pub fn attribute(self, name: &str, value: impl Display) -> Self {
        let value = escape(&value.to_string());
        self.xml.text.push_str(&format!(" {name}=\"{value}\""));
        self
    }

    /// Adds attributes.
    pub fn attributes(self, attributes: &[(&str, &str)]) -> Self {
        attributes.iter().fold(self, |element, (name, value)| element.attribute(name, value))
    }

    /// Adds an attribute that is omitted if it is empty.
    pub fn maybe(self, name: &str, value: Option<impl Display>) -> Self {
        match value {
            Some(value) => self.attribute(name, value),
            None => self,
        }
    }

    /// Ends it without children.
    pub fn empty(self) {
        self.xml.text.push_str("/>\n");
    }

    /// Ends its tag: what follows is inside, until [`Xml::close`].
    pub fn children(self) {
        self.xml.text.push_str(">\n");
        self.xml.open.push(self.name.to_owned());
    }

    /// Ends it with this text inside.
    pub fn text(self, text: &str) {
        self.xml.text.push_str(&format!(">{}</{}>\n", escape(text), self.name));
    }
}

/// The text of an attribute or element; characters that XML cannot contain become spaces.
#[must_use]
pub fn escape(text: &str) -> String {
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
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A number in the shortest form that reads back to the same bits.
#[must_use]
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use super::{Xml, number};

    #[test]
    fn elements_are_indented_and_texts_are_escaped() {
        let mut xml = Xml::new();
        xml.start("a", &[("b", "1 < 2 & \"3\"\n")]);
        xml.element("c").maybe("d", None::<i32>).attribute("e", true).empty();
        xml.element("f").text("\u{1}>");
        let text = xml.finish();
        let lines: Vec<&str> = text.lines().skip(1).collect();
        let first = "<a b=\"1 &lt; 2 &amp; &quot;3&quot;&#10;\">";
        assert_eq!(lines, [first, "  <c e=\"true\"/>", "  <f> &gt;</f>", "</a>"]);
    }

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        for value in [0.1, -0.0, 1e300, 5e-324, 3.0] {
            assert_eq!(number(value).parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
    }
}
