//! Documentation in an exported FMU: `documentation/index.html` describes what is inside and which
//! variables are exposed, `documentation/licenses/` the terms. An icon represents it in diagrams of
//! other tools.

use std::collections::BTreeMap;
use std::path::Path;

use super::Inner;
use super::archive::{self, Content, Entry};
use super::description::Description;
use super::library::Library;
use cosim_base::error::Result;
use cosim_base::xml::Element;
use cosim_core::system::{Component, Model, base_step};
use cosim_report::{Block, Page, Section, Table};

/// The folder for the licences of an FMU (FMI 2.0, 2.3).
pub(super) const LICENSES: &str = "documentation/licenses";
const LICENSE_MIT: &str = include_str!("../LICENSE-MIT");
const LICENSE_APACHE: &str = include_str!("../LICENSE-APACHE");
/// Linked components; drawn from `icon.svg` in this folder.
const ICON: &[u8] = include_bytes!("icon.png");

/// The documentation files.
pub(super) fn entries(
    described: &Description<'_>,
    guid: &str,
    inside: &[Inner],
    libraries: &[Library],
) -> Result<Vec<Entry>> {
    let roots = described.roots()?;
    let page = page(described, guid, &roots).html();
    let mut entries = vec![
        ("model.png".to_owned(), Content::bytes(ICON)),
        ("documentation/index.html".to_owned(), Content::bytes(page)),
        (format!("{LICENSES}/LICENSE-MIT"), Content::bytes(LICENSE_MIT)),
        (format!("{LICENSES}/LICENSE-APACHE"), Content::bytes(LICENSE_APACHE)),
    ];
    let mut terms = format!(
        "This FMU is a system of FMUs and a program that runs it.\n\n\
         The program, cosim {}, is licensed under MIT or Apache-2.0, at your option:\n\
         see LICENSE-MIT and LICENSE-APACHE in this folder.\n",
        env!("CARGO_PKG_VERSION")
    );
    if let Some(linked) = libraries.iter().find_map(|library| library.linked.clone()) {
        entries.push((format!("{LICENSES}/cosim.txt"), Content::bytes(linked)));
        terms.push_str("What it is made of, with its terms: cosim.txt in this folder.\n");
    }
    terms.push_str("\nThe FMUs inside keep their own licences:\n");
    for Inner { name, path, folder } in inside {
        let stem = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let own = licenses(folder.path())?;
        let says = roots.get(path.as_path()).and_then(|root| root.get("license")).unwrap_or("");
        let place = if own.is_empty() { String::new() } else { format!(" (folder {stem})") };
        let said = if says.is_empty() { "does not say" } else { says };
        terms.push_str(&format!("- {stem}: {said}{place}\n"));
        let own = own.into_iter();
        entries.extend(own.map(|(file, what)| (format!("{LICENSES}/{stem}/{file}"), what)));
    }
    entries.push((format!("{LICENSES}/license.txt"), Content::bytes(terms)));
    Ok(entries)
}

/// The licence files of an unpacked FMU, in alphabetical order.
fn licenses(folder: &Path) -> Result<Vec<Entry>> {
    let folder = folder.join(LICENSES);
    if folder.is_dir() { archive::files(&folder) } else { Ok(Vec::new()) }
}

/// The page: components, connections, stepping, variables.
fn page(described: &Description<'_>, guid: &str, roots: &BTreeMap<&Path, Element>) -> Page {
    let (system, name) = (described.system, described.model_name);
    let count = system.components().len();
    Page {
        title: name.to_owned(),
        summary: vec![format!(
            "The system '{}' of {count} components as one FMU for co-simulation (FMI 2.0).",
            system.name()
        )],
        sections: vec![
            components(described, roots),
            stepping(described),
            connections(described),
            variables(described),
        ],
        footer: format!("GUID {guid}, exported by cosim {}.", env!("CARGO_PKG_VERSION")),
    }
}

fn components(described: &Description<'_>, roots: &BTreeMap<&Path, Element>) -> Section {
    let header = ["component", "model", "version", "step (s)", "licence", "author", "GUID"];
    let mut table = Table::new("What is inside", &header);
    for component in described.system.components() {
        let root = component.fmu().and_then(|fmu| roots.get(fmu.path()));
        let says = |attribute| root.and_then(|root| root.get(attribute)).unwrap_or("–").to_owned();
        let model = match &component.model {
            Model::Fmu(fmu) => fmu.description().model_name.clone(),
            Model::Signals(_) => "signals".to_owned(),
            Model::Function(_) => "a function of its inputs".to_owned(),
        };
        let Component { name, step, .. } = component;
        let (version, author) = (says("version"), says("author"));
        let (license, guid) = (says("license"), says("guid"));
        let step = step.seconds().to_string();
        table.push([name.clone(), model, version, step, license, author, guid]);
    }
    section("Components", table)
}

fn stepping(described: &Description<'_>) -> Section {
    let system = described.system;
    let mut section = Section::new("Stepping");
    section.text(format!(
        "Algorithm: {}. The components step at their own multiples of time, whatever the \
         communication step is; {} s is the longest step of which theirs are multiples, or the shortest of \
         theirs.",
        system.algorithm(),
        base_step(system).seconds()
    ));
    if let Some(tolerance) = system.step_control() {
        section.text(format!("Steps follow the relative tolerance {tolerance}."));
    }
    section.text(
        "Inputs hold during a step, and outputs hold between the steps of their components. States \
         can be saved if all components can.",
    );
    section
}

fn connections(described: &Description<'_>) -> Section {
    let system = described.system;
    let mut table = Table::new("Sources and destinations", &["from", "to", "on the way"]);
    for connection in system.connections() {
        let change = connection.conversion.as_ref().map_or(String::new(), ToString::to_string);
        let (from, to) = (system.port_name(connection.from), system.port_name(connection.to));
        table.push([from, to, change]);
    }
    section("Connections", table)
}

fn variables(described: &Description<'_>) -> Section {
    let header = ["name", "causality", "unit", "start", "description"];
    let mut table = Table::new("Variables of the FMU", &header);
    for chosen in described.chosen {
        let (port, exposed) = (chosen.port(), &chosen.exposed);
        let model = &described.system.components()[port.component].model;
        let variable = model.description().map(|d| &d.variables[port.variable]);
        let own = chosen.unit.as_ref().map(|(unit, _)| unit.clone());
        let unit = own.or_else(|| variable.and_then(|v| v.unit.clone())).unwrap_or_default();
        let start = if exposed.role.starts() { exposed.start.to_string() } else { String::new() };
        let text = variable.map_or("", |v| &v.description).to_owned();
        let causality = chosen.causality.name().to_owned();
        table.push([exposed.name.clone(), causality, unit, start, text]);
    }
    section("Variables", table)
}

fn section(heading: &str, table: Table) -> Section {
    let mut section = Section::new(heading);
    section.blocks.push(Block::Table(table));
    section
}
