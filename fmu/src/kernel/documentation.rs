//! `documentation/index.html` of a component: its description and every variable, from the same
//! table as modelDescription.xml.

use std::fmt::Write;

use crate::author::{Info, Start};

use super::table::{Group, Table, Variable};
use super::xml::{escape, number};

const STYLE: &str = "body{font:15px/1.5 sans-serif;max-width:70em;margin:2em auto;padding:0 1em}\
table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.2em .6em;\
border-bottom:1px solid #ccc;vertical-align:top}td.n{text-align:right;white-space:nowrap}\
code{white-space:nowrap}";

/// Writes the page.
pub(crate) fn write(info: &Info, table: &Table) -> String {
    let (name, description) = (escape(info.name), escape(info.description));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{name}</title>\
         <style>{STYLE}</style></head><body>\n<h1>{name}</h1>\n<p>{description}.</p>\n"
    );
    let interfaces = match info.model_exchange {
        true => "co-simulation and model exchange",
        false => "co-simulation",
    };
    let kind = match info.sampled {
        true => "Outputs change at sample instants and are held between them.",
        false => "Continuous in time.",
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        page,
        "<p>FMI 2.0, {interfaces}. {kind} Version {}, {}. Licence: {}.</p>",
        escape(info.version),
        escape(info.author),
        escape(info.license),
    );
    for (group, title) in [
        (Group::Input, "Inputs"),
        (Group::Output, "Outputs"),
        (Group::Parameter, "Parameters"),
        (Group::State, "Continuous states"),
    ] {
        section(&mut page, title, table.variables().iter().filter(|v| v.group == group));
    }
    page.push_str("</body></html>\n");
    page
}

fn section<'a>(page: &mut String, title: &str, variables: impl Iterator<Item = &'a Variable>) {
    let rows: String = variables.map(row).collect();
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<h2>{title}</h2>\n<table><tr><th>Name</th><th>Description</th><th>Unit</th>\
         <th>Start</th><th>Range</th></tr>\n{rows}</table>"
    );
}

fn row(variable: &Variable) -> String {
    let (start, items) = start(&variable.start);
    let range = match (variable.min, variable.max) {
        (None, None) => String::new(),
        (min, max) => {
            let bound = |bound: Option<f64>| bound.map(number).unwrap_or_default();
            format!("{} … {}", bound(min), bound(max))
        }
    };
    format!(
        "<tr><td><code>{}</code></td><td>{}{items}</td><td>{}</td><td class=\"n\">{}</td>\
         <td class=\"n\">{range}</td></tr>\n",
        escape(&variable.name),
        escape(&variable.description),
        escape(variable.unit.as_deref().unwrap_or_default()),
        escape(&start),
    )
}

/// The start value, and the list of items of an enumeration.
fn start(start: &Start) -> (String, String) {
    match start {
        Start::Real(value) => (number(*value), String::new()),
        Start::Integer(value) => (value.to_string(), String::new()),
        Start::Boolean(value) => (value.to_string(), String::new()),
        Start::String(value) => (format!("\"{value}\""), String::new()),
        Start::Enumeration { items, value, .. } => {
            let mut list = String::from("<ul>");
            let mut chosen = String::new();
            for (value_of_item, (name, description)) in (1..).zip(*items) {
                if value_of_item == *value {
                    chosen = (*name).to_owned();
                }
                let (name, description) = (escape(name), escape(description));
                let _ = write!(list, "<li>{value_of_item} <code>{name}</code>: {description}</li>");
            }
            (chosen, list + "</ul>")
        }
    }
}
