//! The documentation of a component: `documentation/index.html` of its FMU and a chapter of
//! Markdown for a list of components. Both come from the same table as modelDescription.xml, so
//! they cannot differ from it.

use std::fmt::Write;

use fmu_standard::{escape, number};

use crate::author::{Info, Start};

use super::table::{Group, Table, Variable};

const STYLE: &str = "\
:root{color-scheme:light dark;--line:#8884;--soft:#8881;--accent:#0072b2}\
body{font:16px/1.55 system-ui,sans-serif;max-width:62em;margin:2em auto;padding:0 1.2em;\
position:relative}\
h1{margin:0 9rem .2em 0;font-size:2em}h2{margin:1.8em 0 .5em;border-bottom:2px solid var(--accent);\
padding-bottom:.15em;font-size:1.3em}h1+p,h1+p+p{margin-right:9rem}\
.icon{position:absolute;right:1.2em;top:0;width:7rem;height:7rem}\
nav a{margin-right:1em}a{color:var(--accent)}\
table{border-collapse:collapse;width:100%;font-size:.92em}\
th,td{text-align:left;padding:.25em .6em;border-bottom:1px solid var(--line);vertical-align:top}\
thead th{background:var(--soft)}tr:hover td{background:var(--soft)}\
th:nth-child(n+4),td.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}\
td ul{margin:.2em 0;padding-left:1.2em}code{white-space:nowrap;font-size:.95em}\
math{font-family:Latin Modern Math,STIX Two Math,Cambria Math,DejaVu Math TeX Gyre,math}\
math[display=block]{margin:.9em 0;font-size:1.12em}mtd{padding:.2em .1em}\
.menv-alignlike>mtr>mtd:nth-child(odd){text-align:right;text-align:-webkit-right}\
.menv-alignlike>mtr>mtd:nth-child(even){text-align:left}\
figure{margin:1em 0;background:#fff;border:1px solid var(--line)}\
figure svg{display:block;width:100%;height:auto}";

/// The groups of variables that users see, with their titles.
const GROUPS: [(Group, &str); 4] = [
    (Group::Input, "Inputs"),
    (Group::Output, "Outputs"),
    (Group::Parameter, "Parameters"),
    (Group::State, "Continuous states"),
];

/// Writes the page. `chapters` is the author's HTML (equations, figures), shown between the
/// description and the tables of variables.
pub(crate) fn html(info: &Info, table: &Table, chapters: &str) -> String {
    let (name, description) = (escape(info.name), escape(info.description));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{name}</title>\
         <style>{STYLE}</style></head><body>\n<h1>{name}</h1>\n<p>{description}.</p>\n"
    );
    // Writing to a String cannot fail.
    let _ = write!(page, "<p>{}", kind(info));
    for (label, text) in
        [("Version", info.version), ("By", info.author), ("Licence:", info.license)]
    {
        if !text.is_empty() {
            let _ = write!(page, " {label} {}.", escape(text));
        }
    }
    page.push_str("</p>\n");
    let sections: Vec<_> = GROUPS
        .iter()
        .map(|(group, title)| (title, rows(table, *group)))
        .filter(|(_, rows)| !rows.is_empty())
        .collect();
    page.push_str("<nav>");
    for (title, _) in &sections {
        let _ = write!(page, "<a href=\"#{}\">{title}</a>", anchor(title));
    }
    let _ = writeln!(page, "</nav>\n{chapters}");
    for (title, rows) in sections {
        let _ = writeln!(
            page,
            "<h2 id=\"{}\">{title}</h2>\n<table><thead><tr><th>Name</th><th>Description</th>\
             <th>Unit</th><th>Start</th><th>Range</th></tr></thead><tbody>",
            anchor(title)
        );
        for row in rows {
            page.push_str(&row.html());
        }
        page.push_str("</tbody></table>\n");
    }
    page.push_str("</body></html>\n");
    page
}

/// Writes the chapter: a heading of the second level and a table for each group.
pub(crate) fn markdown(info: &Info, table: &Table) -> String {
    let mut text = format!("## {}\n\n{}. {}\n", info.name, info.description, kind(info));
    for (group, title) in GROUPS {
        let rows = rows(table, group);
        if !rows.is_empty() {
            let _ = write!(
                text,
                "\n### {}: {title}\n\n| name | description | unit | start | range |\n\
                 |---|---|---|--:|--:|\n",
                info.name
            );
            rows.iter().for_each(|row| text.push_str(&row.markdown()));
        }
    }
    text
}

fn kind(info: &Info) -> String {
    let interfaces = match info.model_exchange {
        true => "co-simulation and model exchange",
        false => "co-simulation",
    };
    let kind = match info.sampled {
        true => "Outputs change at sample instants and are held between them.",
        false => "Continuous in time.",
    };
    format!("FMI 2.0, {interfaces}. {kind}")
}

fn anchor(title: &str) -> String {
    title.to_lowercase().replace(' ', "-")
}

/// A variable in words.
struct Row<'a> {
    variable: &'a Variable,
    unit: &'a str,
    start: String,
    range: String,
    items: &'static [(&'static str, &'static str)],
}

fn rows(table: &Table, group: Group) -> Vec<Row<'_>> {
    table.group(group).map(|(_, variable)| Row::of(variable)).collect()
}

impl<'a> Row<'a> {
    fn of(variable: &'a Variable) -> Self {
        let (start, items): (_, &[_]) = match &variable.start {
            Start::Real(value) => (number(*value), &[]),
            Start::Integer(value) => (value.to_string(), &[]),
            Start::Boolean(value) => (value.to_string(), &[]),
            Start::String(value) => (format!("\"{value}\""), &[]),
            Start::Enumeration { items, value, .. } => {
                let index = usize::try_from(*value).unwrap_or_default().checked_sub(1);
                let chosen = index.and_then(|index| items.get(index));
                (chosen.map(|(name, _)| (*name).to_owned()).unwrap_or_default(), items)
            }
        };
        let bound = |bound: f64| match variable.start {
            Start::Integer(_) => bound.to_string(),
            _ => number(bound),
        };
        let range = match (variable.min.map(bound), variable.max.map(bound)) {
            (None, None) => String::new(),
            (Some(min), None) => format!("≥ {min}"),
            (None, Some(max)) => format!("≤ {max}"),
            (Some(min), Some(max)) => format!("{min} … {max}"),
        };
        let unit = variable.unit.as_deref().unwrap_or_default();
        // Values that the component computes have no start value of their own.
        let settable = matches!(variable.group, Group::Parameter | Group::Input);
        Self { variable, unit, start: if settable { start } else { String::new() }, range, items }
    }

    fn html(&self) -> String {
        let mut items = String::new();
        for (value, (name, description)) in (1..).zip(self.items) {
            let (name, description) = (escape(name), escape(description));
            let _ = write!(items, "<li>{value} <code>{name}</code>: {description}</li>");
        }
        if !items.is_empty() {
            items = format!("<ul>{items}</ul>");
        }
        format!(
            "<tr><td><code>{}</code></td><td>{}{items}</td><td>{}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td></tr>\n",
            escape(&self.variable.name),
            escape(&self.variable.description),
            escape(self.unit),
            escape(&self.start),
            escape(&self.range),
        )
    }

    fn markdown(&self) -> String {
        let mut description = self.variable.description.clone();
        for (value, (name, item)) in (1..).zip(self.items) {
            let _ = write!(description, "<br>{value} `{name}`: {item}");
        }
        let cells = [
            format!("`{}`", self.variable.name),
            description,
            self.unit.to_owned(),
            self.start.clone(),
            self.range.clone(),
        ];
        format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | "))
    }
}
