//! A static report page: one self-contained HTML file, for screen and print.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use serde::Serialize;

use super::{Figure, Table};
use cosim_core::{Code, Error, Result};

/// A page of sections.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// The main conclusions, one paragraph each.
    pub summary: Vec<String>,
    /// The body; two or more sections get a table of contents.
    pub sections: Vec<Section>,
    /// Small print at the end: how the page was made.
    pub footer: String,
}

/// A part of the page under one heading.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Section {
    /// Heading.
    pub heading: String,
    /// Contents in order.
    pub blocks: Vec<Block>,
}

/// One piece of a section. Texts are plain: the page escapes them.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "kind", content = "value", rename_all = "snake_case")]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// An unordered list.
    List(Vec<String>),
    /// Commands or other verbatim text.
    Code(String),
    /// A table.
    Table(Table),
    /// A drawn figure.
    Figure {
        /// The SVG element.
        svg: String,
        /// What it shows, and how to read it.
        caption: String,
    },
}

impl Block {
    /// Draws a figure into a block.
    pub fn figure(figure: &Figure, caption: impl Into<String>) -> Result<Self> {
        Ok(Block::Figure { svg: figure.svg()?, caption: caption.into() })
    }
}

impl Section {
    /// A section without contents.
    pub fn new(heading: impl Into<String>) -> Self {
        Section { heading: heading.into(), blocks: Vec::new() }
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }
}

impl Page {
    /// The page as HTML.
    pub fn html(&self) -> Result<String> {
        render(context! { page => Value::from(Serde(self)) }).map_err(|e| {
            Error::new(Code::Report, format!("cannot write the page '{}'", self.title)).why(e)
        })
    }
}

/// The page for the values of a template, with the style shared by all pages.
pub(super) fn render(values: Value) -> Result<String, minijinja::Error> {
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?;
    let mut environment = Environment::new();
    environment.set_syntax(syntax);
    environment.add_template("page.html", include_str!("page/page.html"))?;
    environment.get_template("page.html")?.render(context! {
        style => include_str!("page/base.css"),
        ..values
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page() -> Page {
        let mut section = Section::new("Signals <1>");
        section.text("a < b & c");
        let mut table = Table::new("Sizes", &["name", "value"]);
        table.push(["<script>", "1"]);
        section.blocks.push(Block::Table(table));
        section.blocks.push(Block::Code("cosim run a.ssd --parameter \"x=1\"".into()));
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"><line x1=\"1\"/></svg>".into();
        section.blocks.push(Block::Figure { svg, caption: "A line".into() });
        let sections = vec![section.clone(), section];
        Page { title: "Run".into(), summary: vec!["Short.".into()], sections, footer: "".into() }
    }

    #[test]
    fn text_is_escaped_and_figures_are_not() {
        let html = page().html().unwrap();
        assert!(html.contains("a &lt; b &amp; c"));
        assert!(html.contains("&lt;script&gt;") && !html.contains("<script"));
        assert!(html.contains("<line x1=\"1\"/>"));
    }

    #[test]
    fn the_page_loads_nothing() {
        let html = page().html().unwrap().replace("http://www.w3.org/2000/svg", "");
        for outside in ["http", "src=", "@import", "url("] {
            assert!(!html.contains(outside), "{outside}");
        }
    }

    #[test]
    fn the_same_page_gives_the_same_bytes() {
        assert_eq!(page().html().unwrap(), page().html().unwrap());
    }
}
