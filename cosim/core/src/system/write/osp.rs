//! OSP: `OspSystemStructure.xml` 0.1 and `LogConfig.xml`.
//!
//! A conversion becomes a linear transformation between two signal connections. The algorithm is
//! `fixedStep`, the only one of OSP that we support; vector sums are written element by element.

use std::collections::BTreeSet;

use fmu_standard::{Xml, number};

use super::files::Files;
use super::ssd::base_step;
use super::{units, unsaid};
use crate::system::read::OSP_NAMESPACE;
use crate::system::{Algorithm, Connection, Conversion, Function, Model, Port, System};
use cosim_base::error::Result;
use cosim_base::units::Linear;
use cosim_import::{InterfaceType, Kind, Value};

pub(super) use crate::system::read::LOG_FILE;

/// The structure of a system whose FMUs are in `files`.
pub(super) fn text(system: &System, files: &Files, notes: &mut Vec<String>) -> Result<String> {
    let writer = Writer { system, converted: converted(system)? };
    if system.algorithm != Algorithm::Jacobi {
        notes.push(format!(
            "OSP has no {}: its fixedStep is jacobi, with one step of delay on every connection",
            system.algorithm
        ));
    }
    let mut xml = Xml::new();
    xml.start("OspSystemStructure", &[("xmlns", OSP_NAMESPACE), ("version", "0.1")]);
    xml.element("StartTime").text(&number(system.start.seconds()));
    xml.element("EndTime").text(&number(system.stop.seconds()));
    xml.element("BaseStepSize").text(&number(base_step(system).seconds()));
    xml.element("Algorithm").text("fixedStep");
    xml.start("Simulators", &[]);
    for component in 0..system.components().len() {
        writer.simulator(&mut xml, component, files)?;
        notes.extend(writer.enumerations(component));
    }
    xml.close();
    writer.functions(&mut xml);
    if !system.connections().is_empty() {
        xml.start("Connections", &[]);
        for (position, connection) in system.connections().iter().enumerate() {
            writer.connection(&mut xml, position, connection);
        }
        xml.close();
    }
    Ok(xml.finish())
}

/// The converted connections: position, name of the function, conversion.
fn converted(system: &System) -> Result<Vec<(usize, String, Linear)>> {
    let mut taken: BTreeSet<String> = system.components().iter().map(|c| c.name.clone()).collect();
    let mut found = Vec::new();
    for (position, connection) in system.connections().iter().enumerate() {
        let names =
            || [connection.from, connection.to].map(|port| system.port_name(port)).join(" -> ");
        let linear = match &connection.conversion {
            None if meet_unconverted(system, connection) => Linear::IDENTITY,
            None => continue,
            Some(Conversion::Linear(linear)) => *linear,
            Some(Conversion::Map(_)) => {
                return Err(unsaid("OSP", format!("{} is mapped", names()))
                    .why("its functions change Reals only"));
            }
        };
        let mut name = format!("to.{}", system.port_name(connection.to));
        while !taken.insert(name.clone()) {
            name.push('_');
        }
        found.push((position, name, linear));
    }
    Ok(found)
}

/// Whether the units differ and their conversion is suppressed: without a function between them
/// they would be converted when the file is read.
fn meet_unconverted(system: &System, connection: &Connection) -> bool {
    match (units::of(system, connection.from), units::of(system, connection.to)) {
        (Some((_, from)), Some((_, to))) => Linear::between(&from, &to) != Some(Linear::IDENTITY),
        _ => false,
    }
}

struct Writer<'a> {
    system: &'a System,
    converted: Vec<(usize, String, Linear)>,
}

impl Writer<'_> {
    fn simulator(&self, xml: &mut Xml, position: usize, files: &Files) -> Result<()> {
        let component = &self.system.components()[position];
        let Model::Fmu(fmu) = &component.model else {
            return Ok(());
        };
        if component.interface == InterfaceType::ModelExchange {
            return Err(unsaid("OSP", format!("'{}' is a model exchange FMU", component.name))
                .help("write an SSP, or use --interface-type NAME=cs if the FMU supports it"));
        }
        let step = number(component.step.seconds());
        let source = files.source(position);
        let attributes =
            [("name", component.name.as_str()), ("source", source), ("stepSize", &step)];
        if component.start_values.is_empty() {
            xml.empty("Simulator", &attributes);
            return Ok(());
        }
        xml.start("Simulator", &attributes);
        xml.start("InitialValues", &[]);
        for (variable, value) in &component.start_values {
            let name = &fmu.description().variables[*variable].name;
            xml.start("InitialValue", &[("variable", name)]);
            let (kind, text) = match value {
                Value::Real(value) => ("Real", number(*value)),
                Value::Integer(value) => ("Integer", value.to_string()),
                Value::Boolean(value) => ("Boolean", value.to_string()),
                Value::String(value) => ("String", value.clone()),
            };
            xml.empty(kind, &[("value", &text)]);
            xml.close();
        }
        xml.close();
        xml.close();
        Ok(())
    }

    /// OSP has no enumeration values.
    fn enumerations(&self, component: usize) -> impl Iterator<Item = String> {
        let component = &self.system.components()[component];
        let variables = component.model.description().map_or(&[][..], |d| &d.variables);
        let set = component.start_values.iter().map(|(position, _)| &variables[*position]);
        set.filter(|v| matches!(v.kind, Kind::Enumeration(_))).map(|v| {
            let name = format!("{}.{}", component.name, v.name);
            format!("the initial value of {name} is written as an Integer, which libcosim refuses")
        })
    }

    fn sums(&self) -> impl Iterator<Item = (&str, &Function)> {
        self.system.components().iter().filter_map(|c| match &c.model {
            Model::Function(function) => Some((c.name.as_str(), &**function)),
            _ => None,
        })
    }

    fn functions(&self, xml: &mut Xml) {
        if self.converted.is_empty() && self.sums().next().is_none() {
            return;
        }
        xml.start("Functions", &[]);
        for (_, name, linear) in &self.converted {
            let (factor, offset) = (number(linear.factor), number(linear.offset));
            let attributes = [("name", name.as_str()), ("factor", &factor), ("offset", &offset)];
            xml.empty("LinearTransformation", &attributes);
        }
        for (name, function) in self.sums() {
            let count = function.inputs().to_string();
            for element in 0..function.dimension().unwrap_or(1) {
                let name = element_name(name, function, element);
                xml.empty("Sum", &[("name", &name), ("inputCount", &count)]);
            }
        }
        xml.close();
    }

    fn connection(&self, xml: &mut Xml, position: usize, connection: &Connection) {
        let (from, to) = (connection.from, connection.to);
        let through = self.converted.iter().find(|(p, ..)| *p == position);
        let (signal_from, signal_to) = (self.signal(from), self.signal(to));
        match (through, signal_from, signal_to) {
            (Some((_, function, _)), ..) => {
                self.signal_connection(xml, from, (function, "in"));
                self.signal_connection(xml, to, (function, "out"));
            }
            (None, Some((function, signal)), _) => {
                self.signal_connection(xml, to, (&function, &signal));
            }
            (None, _, Some((function, signal))) => {
                self.signal_connection(xml, from, (&function, &signal));
            }
            (None, None, None) => {
                xml.start("VariableConnection", &[]);
                self.variable(xml, from);
                self.variable(xml, to);
                xml.close();
            }
        }
    }

    fn signal_connection(&self, xml: &mut Xml, port: Port, (function, signal): (&str, &str)) {
        xml.start("SignalConnection", &[]);
        self.variable(xml, port);
        xml.empty("Signal", &[("function", function), ("name", signal)]);
        xml.close();
    }

    fn variable(&self, xml: &mut Xml, port: Port) {
        let component = &self.system.components()[port.component];
        let name = component.model.variable_name(port.variable);
        xml.empty("Variable", &[("simulator", &component.name), ("name", name)]);
    }

    /// Function and signal of a sum's port.
    fn signal(&self, port: Port) -> Option<(String, String)> {
        let component = &self.system.components()[port.component];
        let Model::Function(function) = &component.model else {
            return None;
        };
        let width = function.dimension().unwrap_or(1);
        let (input, element) = (port.variable / width, port.variable % width);
        let signal = match input < function.inputs() {
            true => format!("in[{input}]"),
            false => "out".to_owned(),
        };
        Some((element_name(&component.name, function, element), signal))
    }
}

fn element_name(name: &str, function: &Function, element: usize) -> String {
    match function.dimension() {
        Some(_) => format!("{name}[{element}]"),
        None => name.to_owned(),
    }
}

/// `LogConfig.xml`; `None`: all outputs are recorded at every step, which is the default.
pub(super) fn log_config(system: &System, notes: &mut Vec<String>) -> Option<String> {
    let smallest = system.components().iter().map(|c| c.step).min()?;
    if system.records_all_outputs() && system.output_interval == smallest {
        return None;
    }
    let mut xml = Xml::new();
    xml.start("simulators", &[("timeStampedFileNames", "false")]);
    for (position, component) in system.components().iter().enumerate() {
        let own: Vec<&str> = system
            .columns()
            .iter()
            .filter(|c| c.port.component == position)
            .map(|c| component.model.variable_name(c.port.variable))
            .collect();
        if own.is_empty() {
            continue;
        }
        if matches!(component.model, Model::Function(_)) {
            notes.push(format!("LogConfig.xml cannot record the sum '{}'", component.name));
            continue;
        }
        let interval = system.output_interval;
        let factor = match component.step.parts_of(interval) {
            Some(factor) => factor,
            None => {
                notes.push(format!(
                    "LogConfig.xml records '{}' at every step: {interval} is not a multiple of {}",
                    component.name, component.step
                ));
                1
            }
        };
        let factor = factor.to_string();
        xml.start("simulator", &[("name", &component.name), ("decimationFactor", &factor)]);
        own.iter().for_each(|name| xml.empty("variable", &[("name", name)]));
        xml.close();
    }
    Some(xml.finish())
}
