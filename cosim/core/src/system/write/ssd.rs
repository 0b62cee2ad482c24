//! SSP 1.0: `SystemStructure.ssd`.
//!
//! Step sizes and the algorithm, which SSP does not define, are in annotations of ours (see
//! `read::ssp::annotation`) and of the Open Simulation Platform, so libcosim makes the same steps.

use fmu_standard::{Xml, number};

use super::files::Files;
use super::{transformation, units, unsaid};
use crate::system::check::is_base;
use crate::system::{Connection, Conversion, Model, Port, System};
use cosim_base::error::Result;
use cosim_base::time::Step;
use cosim_base::units::Units;
use cosim_import::{Causality, Kind, Value};

const OSP: &str = "com.opensimulationplatform";

/// The description of a system whose FMUs are in `files`.
pub(super) fn text(system: &System, files: &Files) -> Result<String> {
    let writer = Writer { system, units: units::collect(system) };
    let mut xml = Xml::new();
    let tool = concat!("cosim ", env!("CARGO_PKG_VERSION"));
    let namespaces = [
        ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
        ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
        ("xmlns:ssv", "http://ssp-standard.org/SSP1/SystemStructureParameterValues"),
        ("xmlns:cosim", "urn:cosim:1"),
        ("xmlns:osp", "http://opensimulationplatform.com/SSP/OSPAnnotations"),
    ];
    let top = [("name", system.name()), ("version", "1.0"), ("generationTool", tool)];
    xml.start("ssd:SystemStructureDescription", &[&top[..], &namespaces].concat());
    xml.start("ssd:System", &[("name", system.name())]);
    xml.start("ssd:Elements", &[]);
    for component in 0..system.components().len() {
        writer.component(&mut xml, component, files)?;
    }
    xml.close();
    if !system.connections().is_empty() {
        xml.start("ssd:Connections", &[]);
        system.connections().iter().for_each(|c| writer.connection(&mut xml, c));
        xml.close();
    }
    xml.close();
    units::write(&mut xml, &writer.units);
    writer.experiment(&mut xml);
    writer.master(&mut xml);
    Ok(xml.finish())
}

struct Writer<'a> {
    system: &'a System,
    units: Units,
}

impl Writer<'_> {
    fn component(&self, xml: &mut Xml, position: usize, files: &Files) -> Result<()> {
        let component = &self.system.components()[position];
        if matches!(component.model, Model::Function(_)) {
            return Err(unsaid("SSP", format!("'{}' is a sum", component.name))
                .help("write an OSP system: cosim convert IN OUT.xml"));
        }
        xml.start(
            "ssd:Component",
            &[
                ("name", &component.name),
                ("type", "application/x-fmu-sharedlibrary"),
                ("source", files.source(position)),
                ("implementation", component.interface.element()),
            ],
        );
        self.connectors(xml, position);
        self.start_values(xml, position);
        xml.start("ssd:Annotations", &[]);
        let step = number(component.step.seconds());
        let mut own = vec![("stepSize", step.as_str())];
        own.extend(component.worker.as_deref().map(|worker| ("worker", worker)));
        annotation(xml, "cosim", |xml| xml.empty("cosim:Component", &own));
        annotation(xml, OSP, |xml| xml.empty("osp:StepSizeHint", &[("value", &step)]));
        xml.close();
        xml.close();
        Ok(())
    }

    /// Only those that are connected: FMPy sets a value for every listed input.
    fn connectors(&self, xml: &mut Xml, component: usize) {
        let ports = self.system.connections().iter().flat_map(|c| [c.from, c.to]);
        let mut own: Vec<usize> =
            ports.filter(|p| p.component == component).map(|p| p.variable).collect();
        own.sort_unstable();
        own.dedup();
        let Some(description) = self.system.components()[component].model.description() else {
            return;
        };
        if own.is_empty() {
            return;
        }
        xml.start("ssd:Connectors", &[]);
        for position in own {
            let variable = &description.variables[position];
            let kind = match variable.causality {
                Causality::Input => "input",
                _ => "output",
            };
            xml.start("ssd:Connector", &[("name", &variable.name), ("kind", kind)]);
            match &variable.kind {
                Kind::Real => {
                    let port = Port { component, variable: position };
                    let unit = self.unit(port).map(|unit| [("unit", unit)]);
                    xml.empty("ssc:Real", unit.as_ref().map_or(&[], |unit| &unit[..]));
                }
                // libcosim fails on an Enumeration.
                Kind::Integer | Kind::Enumeration(_) => xml.empty("ssc:Integer", &[]),
                Kind::Boolean => xml.empty("ssc:Boolean", &[]),
                Kind::String => xml.empty("ssc:String", &[]),
            }
            xml.close();
        }
        xml.close();
    }

    /// The unit of a variable, if this file defines it like its FMU.
    fn unit(&self, port: Port) -> Option<&str> {
        let (variable, unit) = units::of(self.system, port)?;
        let name = variable.unit.as_deref()?;
        (self.units.get(name) == Some(&unit)).then_some(name)
    }

    fn start_values(&self, xml: &mut Xml, position: usize) {
        let component = &self.system.components()[position];
        let (Some(description), false) =
            (component.model.description(), component.start_values.is_empty())
        else {
            return;
        };
        xml.start("ssd:ParameterBindings", &[]);
        xml.start("ssd:ParameterBinding", &[]);
        xml.start("ssd:ParameterValues", &[]);
        // The same name for all: Ecos applies the parameter sets with one name.
        xml.start("ssv:ParameterSet", &[("version", "1.0"), ("name", "parameters")]);
        xml.start("ssv:Parameters", &[]);
        for (variable, value) in &component.start_values {
            let name = &description.variables[*variable].name;
            xml.start("ssv:Parameter", &[("name", name)]);
            let (kind, text) = match value {
                Value::Real(value) => ("ssv:Real", number(*value)),
                Value::Integer(value) => ("ssv:Integer", value.to_string()),
                Value::Boolean(value) => ("ssv:Boolean", value.to_string()),
                Value::String(value) => ("ssv:String", value.clone()),
            };
            xml.empty(kind, &[("value", &text)]);
            xml.close();
        }
        (0..5).for_each(|_| xml.close());
    }

    fn connection(&self, xml: &mut Xml, connection: &Connection) {
        let (from, to) = (connection.from, connection.to);
        let element = |port: Port| self.system.components()[port.component].name.as_str();
        let variable = |port: Port| {
            self.system.components()[port.component].model.variable_name(port.variable)
        };
        let linear = matches!(connection.conversion, Some(Conversion::Linear(_)));
        let suppress = linear || self.unit(from) != self.unit(to);
        let mut attributes = vec![
            ("startElement", element(from)),
            ("startConnector", variable(from)),
            ("endElement", element(to)),
            ("endConnector", variable(to)),
        ];
        if suppress {
            attributes.push(("suppressUnitConversion", "true"));
        }
        let Some(conversion) = &connection.conversion else {
            return xml.empty("ssd:Connection", &attributes);
        };
        let model = &self.system.components()[to.component].model;
        let kind = model.description().map(|d| d.variables[to.variable].kind.clone());
        xml.start("ssd:Connection", &attributes);
        transformation::write(xml, conversion, &kind.unwrap_or(Kind::Real));
        xml.close();
    }

    fn experiment(&self, xml: &mut Xml) {
        let system = self.system;
        let (start, stop) = (number(system.start.seconds()), number(system.stop.seconds()));
        xml.start("ssd:DefaultExperiment", &[("startTime", &start), ("stopTime", &stop)]);
        let base = number(base_step(system).seconds());
        xml.start("ssd:Annotations", &[]);
        annotation(xml, OSP, |xml| {
            xml.start("osp:Algorithm", &[]);
            xml.empty("osp:FixedStepAlgorithm", &[("baseStepSize", &base)]);
            xml.close();
        });
        xml.close();
        xml.close();
    }

    fn master(&self, xml: &mut Xml) {
        let system = self.system;
        let (algorithm, interval) =
            (system.algorithm.to_string(), number(system.output_interval.seconds()));
        let attributes = [("algorithm", algorithm.as_str()), ("outputInterval", &interval)];
        xml.start("ssd:Annotations", &[]);
        annotation(xml, "cosim", |xml| {
            if system.records_all_outputs() {
                return xml.empty("cosim:Master", &attributes);
            }
            xml.start("cosim:Master", &attributes);
            for column in &system.columns {
                xml.empty("cosim:Record", &[("variable", &column.name)]);
            }
            xml.close();
        });
        xml.close();
    }
}

fn annotation(xml: &mut Xml, kind: &str, inside: impl FnOnce(&mut Xml)) {
    xml.start("ssc:Annotation", &[("type", kind)]);
    inside(xml);
    xml.close();
}

/// The common base of all steps; other masters make a step of their own at each multiple of it.
pub fn base_step(system: &System) -> Step {
    let steps = || system.components().iter().map(|c| c.step);
    let smallest = steps().min().unwrap_or(system.output_interval);
    let base = steps().fold(smallest, Step::gcd);
    if is_base(base, smallest) { base } else { smallest }
}

impl System {
    /// Whether the columns are those that are recorded by default.
    pub(super) fn records_all_outputs(&self) -> bool {
        let outputs = self.components.iter().enumerate().flat_map(|(component, c)| {
            let variables = c.model.description().map_or(&[][..], |d| &d.variables);
            let numbers = variables
                .iter()
                .enumerate()
                .filter(|(_, v)| v.causality == Causality::Output && v.kind != Kind::String);
            numbers.map(move |(variable, _)| Port { component, variable })
        });
        outputs.eq(self.columns.iter().map(|column| column.port))
    }
}
