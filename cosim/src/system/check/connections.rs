//! Connections: both ends exist, an output drives an input of its type, and no other does.

use super::Findings;
use super::components::{Opened, unknown_component, variable};
use crate::error::{Code, Error, Result};
use crate::fmi::{Causality, Fmu, Kind, Variable};
use crate::names;
use crate::system::raw::{RawConnection, RawSystem};
use crate::system::{Connection, Port};

pub(super) fn check(
    raw: &RawSystem,
    opened: &[Opened],
    findings: &mut Findings,
) -> Vec<Connection> {
    let mut connections: Vec<(Connection, usize)> = Vec::new();
    for connection in &raw.connections {
        let checker = Checker { raw, opened, connection };
        let found = checker.check(&mut findings.warnings);
        let Some(found) = findings.note(found).flatten() else {
            continue;
        };
        match connections.iter().find(|(other, _)| other.to == found.to) {
            None => connections.push((found, connection.line)),
            Some((_, first)) => findings.problems.push(checker.two_drivers(*first)),
        }
    }
    connections.into_iter().map(|(connection, _)| connection).collect()
}

struct Checker<'a> {
    raw: &'a RawSystem,
    opened: &'a [Opened],
    connection: &'a RawConnection,
}

/// An end that was found.
struct End<'a> {
    port: Port,
    variable: &'a Variable,
}

impl<'a> Checker<'a> {
    /// `None`: dropped with a warning, or depends on an FMU that could not be opened.
    fn check(&self, warnings: &mut Vec<String>) -> Result<Option<Connection>> {
        let (from, to) = (&self.connection.from, &self.connection.to);
        let Some((source, source_fmu)) = self.component(from, "output")? else {
            return Ok(None);
        };
        let Some((sink, sink_fmu)) = self.component(to, "input")? else {
            return Ok(None);
        };
        if self.opened[sink].replaced && sink_fmu.description().variable(&to.1).is_none() {
            warnings.push(format!(
                "{}:{}: the connection {}.{} -> {}.{} is dropped: the FMU put in place of '{}' \
                 has no such input",
                self.raw.file.display(),
                self.connection.line,
                from.0,
                from.1,
                to.0,
                to.1,
                to.0,
            ));
            return Ok(None);
        }
        let start = self.end(source, source_fmu, &from.1)?;
        let end = self.end(sink, sink_fmu, &to.1)?;
        self.causality(&start, &from.0, Causality::Output, "startElement")?;
        self.causality(&end, &to.0, Causality::Input, "endElement")?;
        self.kinds(&start, &end)?;
        self.units(&start, &end, warnings);
        Ok(Some(Connection { from: start.port, to: end.port }))
    }

    /// The component of an end; its connector must be listed, as SSP demands.
    fn component(
        &self,
        (component, connector): &(String, String),
        kind: &str,
    ) -> Result<Option<(usize, &'a Fmu)>> {
        let names = self.raw.components.iter().map(|c| c.name.as_str());
        let Some(position) = self.raw.components.iter().position(|c| c.name == *component) else {
            return Err(self.place(unknown_component(component, names)));
        };
        let listed = &self.raw.components[position];
        let fmu = self.opened[position].fmu.as_deref();
        if listed.connectors.iter().any(|c| c.name == *connector) {
            return Ok(fmu.map(|fmu| (position, fmu)));
        }
        let exists = fmu.and_then(|fmu| fmu.description().variable(connector));
        let connectors = listed.connectors.iter().map(|c| c.name.as_str());
        let error = match exists {
            Some(variable) => self
                .wrong(Code::Connection, format!("'{component}' lists no connector '{connector}'"))
                .why("SSP connects only connectors that the component lists")
                .help(format!(
                    "add to <ssd:Connectors> of '{component}': \
                     <ssd:Connector name=\"{connector}\" kind=\"{kind}\"><ssc:{}/></ssd:Connector>",
                    variable.kind.name()
                )),
            None => {
                let variables = fmu.iter().flat_map(|fmu| fmu.description().names());
                let what = format!("'{component}' has no variable '{connector}'");
                self.wrong(Code::UnknownName, what)
                    .maybe_help(names::did_you_mean(connector, connectors.chain(variables)))
            }
        };
        Err(error)
    }

    fn end(&self, component: usize, fmu: &'a Fmu, name: &str) -> Result<End<'a>> {
        let opened = &self.opened[component];
        let Some(position) = fmu.description().position(name) else {
            if opened.replaced {
                return Err(self
                    .wrong(Code::Replacement, format!("'{}' has no output '{name}'", opened.name))
                    .why(format!(
                        "{} was put in its place, and the connection to {}.{} needs it",
                        fmu.path().display(),
                        self.connection.to.0,
                        self.connection.to.1,
                    ))
                    .help("take an FMU with the same outputs"));
            }
            let unknown = variable(&opened.name, fmu, name).err();
            return Err(self.place(unknown.unwrap_or_else(|| {
                Error::new(Code::UnknownName, format!("'{name}' is unknown"))
            })));
        };
        let port = Port { component, variable: position };
        Ok(End { port, variable: &fmu.description().variables[position] })
    }

    fn causality(
        &self,
        end: &End<'_>,
        component: &str,
        wanted: Causality,
        attribute: &str,
    ) -> Result<()> {
        if end.variable.causality == wanted {
            return Ok(());
        }
        let (name, causality) = (&end.variable.name, end.variable.causality.name());
        Err(self
            .wrong(Code::Connection, format!("'{component}.{name}' is no {}", wanted.name()))
            .why(format!("its causality is {causality}"))
            .help(format!(
                "a connection goes from an output to an input: {attribute} must name an {}",
                wanted.name()
            )))
    }

    fn kinds(&self, from: &End<'_>, to: &End<'_>) -> Result<()> {
        let integer = |kind: &Kind| matches!(kind, Kind::Integer | Kind::Enumeration(_));
        let (start, end) = (&from.variable.kind, &to.variable.kind);
        let same = start.name() == end.name() || (integer(start) && integer(end));
        if same && *start != Kind::String {
            return Ok(());
        }
        let (from, to) = (&self.connection.from, &self.connection.to);
        Err(self
            .wrong(Code::Connection, format!("{}.{} -> {}.{}", from.0, from.1, to.0, to.1))
            .why(format!("it joins {} and {}", start.name(), end.name()))
            .help("Real joins Real, Integer and Enumeration each other, Boolean Boolean"))
    }

    fn units(&self, from: &End<'_>, to: &End<'_>, warnings: &mut Vec<String>) {
        let (Some(start), Some(end)) = (&from.variable.unit, &to.variable.unit) else {
            return;
        };
        if start != end && !self.connection.suppress_unit_conversion {
            let (from, to) = (&self.connection.from, &self.connection.to);
            warnings.push(format!(
                "{}:{}: {}.{} is in {start}, {}.{} in {end}; the value is passed on unconverted \
                 (suppressUnitConversion=\"true\" silences this)",
                self.raw.file.display(),
                self.connection.line,
                from.0,
                from.1,
                to.0,
                to.1,
            ));
        }
    }

    fn two_drivers(&self, first: usize) -> Error {
        let (component, name) = &self.connection.to;
        self.wrong(Code::Connection, format!("the input '{component}.{name}' has two drivers"))
            .why(format!("the connection on line {first} drives it already"))
            .help("remove one of the two")
    }

    fn wrong(&self, code: Code, what: String) -> Error {
        self.place(Error::new(code, what))
    }

    fn place(&self, error: Error) -> Error {
        error.at_line(&self.raw.file, self.connection.line)
    }
}
