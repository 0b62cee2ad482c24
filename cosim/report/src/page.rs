//! A static report page: one self-contained HTML file, for screen and print.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;

use super::{Figure, Table};
use cosim_core::Result;

/// A page of sections.
#[derive(Debug, Clone, Default)]
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
    pub fn html(&self) -> String {
        let body = html! {
            main.document {
                h1 { (self.title) }
                @for paragraph in &self.summary {
                    p.summary { (paragraph) }
                }
                @if self.sections.len() > 1 {
                    nav aria-label="Contents" {
                        ol {
                            @for (section, number) in self.sections.iter().zip(1..) {
                                li { a href={ "#section-" (number) } { (section.heading) } }
                            }
                        }
                    }
                }
                @for (section, number) in self.sections.iter().zip(1..) {
                    section id={ "section-" (number) } {
                        h2 { (section.heading) }
                        @for block in &section.blocks { (block.html()) }
                    }
                }
                @if !self.footer.is_empty() {
                    footer { (self.footer) }
                }
            }
        };
        whole(&self.title, &html! {}, &body)
    }
}

impl Block {
    fn html(&self) -> Markup {
        html! {
            @match self {
                Self::Text(text) => p { (text) },
                Self::List(items) => ul {
                    @for item in items { li { (item) } }
                },
                Self::Code(code) => pre tabindex="0" { code { (code) } },
                Self::Table(table) => div.table tabindex="0" { (table.html()) },
                Self::Figure { svg, caption } => figure {
                    div.picture tabindex="0" role="group" aria-label="Picture" { (PreEscaped(svg)) }
                    figcaption { (caption) }
                },
            }
        }
    }
}

impl Table {
    fn html(&self) -> Markup {
        html! {
            table {
                caption { (self.caption) }
                thead {
                    tr {
                        @for cell in &self.header { th scope="col" { (cell) } }
                    }
                }
                tbody {
                    @for row in &self.rows {
                        tr {
                            @for (place, cell) in row.iter().enumerate() {
                                @if place == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A page with the style shared by all pages, and more elements in its head.
pub(super) fn whole(title: &str, head: &Markup, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(include_str!("page/base.css"))) }
                (head)
            }
            body { (body) }
        }
    };
    page.into_string()
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
        let html = page().html();
        assert!(html.contains("a &lt; b &amp; c"));
        assert!(html.contains("&lt;script&gt;") && !html.contains("<script"));
        assert!(html.contains("<line x1=\"1\"/>"));
    }

    #[test]
    fn the_page_loads_nothing() {
        let html = page().html().replace("http://www.w3.org/2000/svg", "");
        for outside in ["http", "src=", "@import", "url("] {
            assert!(!html.contains(outside), "{outside}");
        }
    }

    #[test]
    fn the_same_page_gives_the_same_bytes() {
        assert_eq!(page().html(), page().html());
    }
}
