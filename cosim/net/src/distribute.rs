//! Turns a checked system into the set-up of each host.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::layout::{Group, Layout};
use super::setup::{Blueprint, FmuFile, Setup, Source};
use cosim_base::error::{Code, Error, Result};
use cosim_base::sha256;
use cosim_core::master::{Converted, Plan};
use cosim_core::system::{Component, Model, System};
use cosim_import::InterfaceType;

/// A system divided into groups.
pub(crate) struct Distribution {
    pub plan: Plan,
    pub layout: Layout,
    pub setups: Vec<Setup>,
    /// The FMU files of each group, by their hash.
    pub files: Vec<BTreeMap<String, PathBuf>>,
}

impl Distribution {
    /// `places` gives the group of each component.
    pub(crate) fn new(system: &System, places: &[usize]) -> Result<Self> {
        let plan = Plan::new(system);
        possible(system, places)?;
        let layout = Layout::new(&plan, places).map_err(|position| {
            let names = &plan.loops[position].names;
            Error::new(Code::Placement, format!("the loop through {names} is in several places"))
                .why("its members are iterated together at every step")
                .help("place them on the same worker, or use --algorithm gauss-seidel")
        })?;
        let mut known = BTreeMap::new();
        let mut blueprints = Vec::new();
        for (component, node) in system.components().iter().zip(&plan.nodes) {
            let converted = system.converted(blueprints.len(), node);
            blueprints.push(blueprint(component, converted, &mut known)?);
        }
        let setups = layout.groups.iter().map(|group| setup(system, &plan, group, &blueprints));
        let setups: Vec<Setup> = setups.collect();
        let files = setups.iter().map(|setup| files_of(setup, &known)).collect();
        Ok(Self { plan, layout, setups, files })
    }
}

/// The files that a group needs.
fn files_of(setup: &Setup, known: &BTreeMap<String, PathBuf>) -> BTreeMap<String, PathBuf> {
    let needed = setup.components.iter().filter_map(|component| match &component.source {
        Source::Fmu(file) => known.get_key_value(&file.sha256),
        _ => None,
    });
    needed.map(|(hash, path)| (hash.clone(), path.clone())).collect()
}

/// Refuses what cannot be decided within one group.
fn possible(system: &System, places: &[usize]) -> Result<()> {
    let fmus = system.components().iter().filter_map(|c| Some((c.name.as_str(), c.fmu()?)));
    system.logging().check(fmus)?;
    if system.step_control().is_some() {
        return Err(Error::new(Code::Placement, "steps under error control are not distributed")
            .why("a rejected step would have to be taken back everywhere")
            .help("remove the error control, or run in one process"));
    }
    let connections = system.connections().iter().enumerate();
    let apart = connections
        .filter(|(position, _)| system.is_linear(*position))
        .find(|(_, c)| places[c.from.component] != places[c.to.component]);
    if let Some((_, connection)) = apart {
        let (from, to) = (system.port_name(connection.from), system.port_name(connection.to));
        return Err(Error::new(Code::Placement, format!("{to} is linear during steps"))
            .why(format!("it follows {from}, which is on another worker"))
            .help("place both on the same worker, or hold the input"));
    }
    Ok(())
}

fn blueprint(
    component: &Component,
    converted: Vec<Converted>,
    files: &mut BTreeMap<String, PathBuf>,
) -> Result<Blueprint> {
    let source = match &component.model {
        Model::Fmu(fmu) => {
            let path = component.file.as_deref().unwrap_or(fmu.path());
            let known = files.iter().find(|(_, known)| *known == path);
            let sha256 = match known {
                Some((hash, _)) => hash.clone(),
                None => {
                    let bytes = std::fs::read(path).map_err(|why| {
                        Error::new(Code::File, "the FMU cannot be read").at(path).why(why)
                    })?;
                    sha256(bytes)
                }
            };
            files.insert(sha256.clone(), path.to_owned());
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            Source::Fmu(FmuFile { sha256, name })
        }
        Model::Signals(signals) => Source::Signals((**signals).clone()),
        Model::Function(function) => Source::Sum(function.inputs(), function.dimension()),
    };
    Ok(Blueprint {
        name: component.name.clone(),
        source,
        model_exchange: component.interface == InterfaceType::ModelExchange,
        step: component.step,
        start_values: component.start_values.clone(),
        converted,
    })
}

fn setup(system: &System, plan: &Plan, group: &Group, blueprints: &[Blueprint]) -> Setup {
    Setup {
        plan: plan.restrict(&group.own),
        group: group.local(),
        components: group.own.iter().map(|&component| blueprints[component].clone()).collect(),
        making: system.making(),
        start: system.start_time(),
        stop: system.stop_time(),
        state: None,
    }
}
