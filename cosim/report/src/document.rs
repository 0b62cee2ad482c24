//! An interactive page: data, and the script that shows them.

use std::collections::BTreeMap;

use maud::{PreEscaped, html};
use serde::Serialize;

use super::page::{Section, whole};
use super::run::Trace;
use cosim_core::{Code, Error, Result};

/// The data of a page: a campaign, or one run.
#[derive(Serialize)]
pub struct Document<C: Serialize> {
    /// The heading.
    pub title: String,
    /// What the runs are to answer.
    pub question: String,
    /// Paragraphs at the top.
    pub summary: Vec<String>,
    /// Text, tables and pictures of a campaign.
    pub sections: Vec<Section>,
    /// Notes on what is missing.
    pub notes: Vec<String>,
    /// How the results were computed.
    pub method: Vec<Term>,
    /// Where they come from.
    pub provenance: Vec<Term>,
    /// What identifies them.
    pub identity: Vec<String>,
    /// The data of a campaign.
    pub campaign: Option<C>,
    /// The data of each shown run, by its name.
    pub runs: BTreeMap<String, Trace>,
}

/// A term and its explanation.
#[derive(Serialize)]
pub struct Term {
    term: String,
    text: String,
}

impl Term {
    /// A term with its explanation.
    pub fn new(term: impl Into<String>, text: impl Into<String>) -> Self {
        Self { term: term.into(), text: text.into() }
    }
}

/// The modules that the scripts of all pages share, in dependency order.
const COMMON: [&str; 6] = [
    include_str!("page/js/dom.js"),
    include_str!("page/js/format.js"),
    include_str!("page/js/theme.js"),
    include_str!("page/js/clock.js"),
    include_str!("page/js/timeplot.js"),
    include_str!("page/js/plane.js"),
];
const REPORT: [&str; 7] = [
    include_str!("page/js/distribution.js"),
    include_str!("page/js/sections.js"),
    include_str!("page/js/overview.js"),
    include_str!("page/js/cell.js"),
    include_str!("page/js/space.js"),
    include_str!("page/js/run.js"),
    include_str!("page/js/main.js"),
];

const LIVE: [&str; 5] = [
    include_str!("page/js/live/store.js"),
    include_str!("page/js/live/map.js"),
    include_str!("page/js/live/signals.js"),
    include_str!("page/js/live/controls.js"),
    include_str!("page/js/live/main.js"),
];

/// The page that shows a live run.
pub fn live_page() -> String {
    page("cosim live", "{}", &LIVE, "; connect-src 'self' ws: wss:")
}

/// Everything is in the page.
const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// A page with data and a script, which loads nothing but what `policy` adds.
fn page(title: &str, data: &str, modules: &[&str], policy: &str) -> String {
    let head = html! {
        meta http-equiv="Content-Security-Policy" content={ (POLICY) (policy) };
        style {
            (PreEscaped(include_str!("page/uplot/uPlot.min.css")))
            (PreEscaped(include_str!("page/report.css")))
        }
    };
    let licence = include_str!("page/uplot/LICENSE");
    let body = html! {
        header id="top" {}
        main id="view" tabindex="-1" {
            h1 { (title) }
            noscript {
                p { "This report needs JavaScript: it loads nothing, everything is in this file." }
            }
        }
        footer id="end" {}
        script type="application/json" id="data" { (PreEscaped(data)) }
        (PreEscaped(format!("<!-- uPlot\n{licence}\n-->")))
        script { (PreEscaped(include_str!("page/uplot/uPlot.iife.min.js"))) }
        script type="module" { (PreEscaped(script(modules))) }
    };
    whole(title, &head, &body)
}

impl<C: Serialize> Document<C> {
    /// The page as one HTML file.
    pub fn html(&self) -> Result<String> {
        let data = serde_json::to_string(self).map_err(|e| {
            Error::new(Code::Report, format!("cannot write the page '{}'", self.title)).why(e)
        })?;
        // Only `<` could end a script element.
        Ok(page(&self.title, &data.replace('<', "\\u003c"), &REPORT, ""))
    }
}

/// Joins the modules: they import only from each other, by whole lines, and no name is used twice.
fn script(modules: &[&str]) -> String {
    let lines = COMMON.iter().chain(modules).flat_map(|module| module.lines());
    let kept = lines.filter(|line| !line.starts_with("import ") && !line.starts_with("//"));
    kept.map(|line| line.strip_prefix("export ").unwrap_or(line)).fold(
        String::new(),
        |mut text, line| {
            text.push_str(line);
            text.push('\n');
            text
        },
    )
}

/// Explanations for the plots of a run.
pub fn run_terms() -> Vec<Term> {
    let terms = [
        (
            "Map",
            "North is up, east is right, and the scale is the same in both directions. Ellipses \
             contain 95 % of the horizontal position, by the covariance that the estimator \
             reports.",
        ),
        (
            "Truth and estimates",
            "From the figures of a campaign, or given by --truth and --estimate or --roles. Otherwise, a \
             group called pose or position whose component has standard deviations (sigma.x, \
             sigma.y) is an estimate, and the first pose without them is the truth. A group called \
             target, reference or setpoint is the course.",
        ),
        (
            "Units",
            "From the description of the system, if given (--system); otherwise as names \
             suggest. A variable whose unit is not known shares an axis only with elements of its \
             array.",
        ),
        (
            "Fewer points",
            "Curves keep the minimum and maximum of each part of the run, so no peak is \
             lost; numbers have five digits.",
        ),
    ];
    terms.into_iter().map(|(term, text)| Term::new(term, text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_cannot_become_markup_and_the_page_loads_nothing() {
        let document = Document::<()> {
            title: "</script><script>alert(1)</script>".into(),
            question: String::new(),
            summary: Vec::new(),
            sections: Vec::new(),
            notes: vec!["<!-- <img src=x onerror=alert(1)>".into()],
            method: run_terms(),
            provenance: Vec::new(),
            identity: Vec::new(),
            campaign: None,
            runs: BTreeMap::new(),
        };
        let html = document.html().unwrap();
        assert!(!html.contains("<script>alert") && !html.contains("<img"), "{html}");
        assert!(html.contains("&lt;/script&gt;&lt;script&gt;alert(1)"));
        for outside in ["src=\"", "@import", "url(", "fetch("] {
            assert!(!html.contains(outside), "{outside}");
        }
        for modules in [&REPORT[..], &LIVE] {
            let script = script(modules);
            assert!(!script.contains("import ") && !script.contains("export "));
        }
    }
}
