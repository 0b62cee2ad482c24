//! Checks connections: both ends exist, an output drives an input of its type, and no other does.

use std::collections::HashMap;

use super::Findings;
use super::components::{Opened, unknown_component, variable};
use super::connection_notes::{ConnectionNotes, Dropped};
use super::conversion::{self, Measured, Way};
use super::places::Places;
use crate::system::raw::{RawConnection, RawConnector, RawSystem};
use crate::system::{Connection, Model, Port};
use cosim_base::Warnings;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_import::{Causality, Kind, Variable};

pub(super) fn check(
    raw: &RawSystem,
    places: &Places<'_>,
    opened: &[Opened],
    findings: &mut Findings,
) -> Vec<Connection> {
    let mut connections: Vec<Connection> = Vec::new();
    let mut drivers: HashMap<Port, &RawConnection> = HashMap::new();
    let mut notes = ConnectionNotes::default();
    for connection in &raw.connections {
        let checker = Checker { raw, places, opened, connection };
        let found = checker.check(&mut findings.warnings, &mut notes);
        let Some(found) = findings.note(found).flatten() else {
            continue;
        };
        match drivers.get(&found.to) {
            None => {
                drivers.insert(found.to, connection);
                connections.push(found);
            }
            Some(first) => findings.problems.push(checker.two_drivers(&found, first)),
        }
    }
    notes.report(&mut findings.warnings, &mut findings.notes);
    connections
}

struct Checker<'a> {
    raw: &'a RawSystem,
    places: &'a Places<'a>,
    opened: &'a [Opened],
    connection: &'a RawConnection,
}

/// An end that was found.
struct End<'a> {
    port: Port,
    variable: &'a Variable,
    model: &'a Model,
    listed: Option<&'a RawConnector>,
}

/// Component and connector as written.
type Name = (String, String);

impl<'a> Checker<'a> {
    /// `None`: dropped with a warning, or depends on an FMU that could not be opened.
    fn check(
        &self,
        warnings: &mut Warnings,
        notes: &mut ConnectionNotes,
    ) -> Result<Option<Connection>> {
        let (from, to) = self.directed();
        let Some((source, source_model)) = self.component(from, "output")? else {
            return Ok(None);
        };
        let Some((sink, sink_model)) = self.component(to, "input")? else {
            return Ok(None);
        };
        let has_input = sink_model.description().is_some_and(|d| d.position(&to.1).is_some());
        if self.opened[sink].replaced && !has_input {
            notes.dropped.push(Dropped {
                place: self.connection.place.to_string(),
                from: format!("{}.{}", from.0, from.1),
                to: to.clone(),
            });
            return Ok(None);
        }
        let start = self.end(source, source_model, from)?;
        let end = self.end(sink, sink_model, to)?;
        self.causality(&start, &from.0, Causality::Output)?;
        self.causality(&end, &to.0, Causality::Input)?;
        self.kinds(&start, &end)?;
        let conversion = self.convert(&start, &end, warnings, notes)?;
        Ok(Some(Connection { from: start.port, to: end.port, conversion }))
    }

    /// Source and destination: the order in the file does not matter.
    fn directed(&self) -> (&'a Name, &'a Name) {
        let (first, second) = (&self.connection.from, &self.connection.to);
        let causality = |name: &Name| {
            let component = &self.opened[self.places.component(&name.0)?];
            Some(component.description()?.variable(&name.1)?.causality)
        };
        let (a, b) = (causality(first), causality(second));
        match a == Some(Causality::Input) && b == Some(Causality::Output) {
            true => (second, first),
            false => (first, second),
        }
    }

    /// The component of an end; if connectors are listed, this one must be among them.
    fn component(
        &self,
        (component, connector): &Name,
        kind: &str,
    ) -> Result<Option<(usize, &'a Model)>> {
        let names = self.raw.components.iter().map(|c| c.name.as_str());
        let Some(position) = self.places.component(component) else {
            return Err(self.place(unknown_component(component, names)));
        };
        let model = self.opened[position].model.as_ref();
        let Some(listed) = &self.raw.components[position].connectors else {
            return Ok(model.map(|model| (position, model)));
        };
        if self.places.connector(position, connector).is_some() {
            return Ok(model.map(|model| (position, model)));
        }
        let description = model.and_then(Model::description);
        let exists = description.and_then(|d| d.variable(connector));
        let connectors = listed.iter().map(|c| c.name.as_str());
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
                let variables = description.into_iter().flat_map(|d| d.names());
                let what = format!("'{component}' has no variable '{connector}'");
                self.wrong(Code::UnknownName, what)
                    .maybe_help(names::did_you_mean(connector, connectors.chain(variables)))
            }
        };
        Err(error)
    }

    fn end(&self, component: usize, model: &'a Model, (_, name): &Name) -> Result<End<'a>> {
        let opened = &self.opened[component];
        let found = variable(&opened.name, model, name);
        let (position, variable) =
            found.map_err(|unknown| match (&opened.model, opened.replaced) {
                (Some(Model::Fmu(fmu)), true) => self
                    .wrong(Code::Replacement, format!("'{}' has no output '{name}'", opened.name))
                    .why(format!(
                        "{} replaces it, and the connection to {}.{} needs that output",
                        fmu.path().display(),
                        self.connection.to.0,
                        self.connection.to.1,
                    ))
                    .help("use an FMU with the same outputs"),
                _ => self.place(unknown),
            })?;
        let listed = self.places.connector(component, name).filter(|_| !opened.replaced);
        Ok(End { port: Port { component, variable: position }, variable, model, listed })
    }

    fn causality(&self, end: &End<'_>, component: &str, wanted: Causality) -> Result<()> {
        if end.variable.causality == wanted {
            return Ok(());
        }
        let (name, causality) = (&end.variable.name, end.variable.causality.name());
        Err(self
            .wrong(Code::Connection, format!("'{component}.{name}' is not an {}", wanted.name()))
            .why(format!("its causality is {causality}"))
            .help("a connection joins an output and an input"))
    }

    fn kinds(&self, from: &End<'_>, to: &End<'_>) -> Result<()> {
        let integer = |kind: &Kind| matches!(kind, Kind::Integer | Kind::Enumeration(_));
        let (start, end) = (&from.variable.kind, &to.variable.kind);
        let same = start.name() == end.name() || (integer(start) && integer(end));
        if same {
            return Ok(());
        }
        let (from, to) = (&self.connection.from, &self.connection.to);
        Err(self
            .wrong(Code::Connection, format!("{}.{} -> {}.{}", from.0, from.1, to.0, to.1))
            .why(format!("it joins {} and {}", start.name(), end.name()))
            .help(
                "Real connects to Real, Integer and Enumeration to each other, Boolean and String to their own type",
            ))
    }

    fn convert(
        &self,
        from: &End<'_>,
        to: &End<'_>,
        warnings: &mut Warnings,
        notes: &mut ConnectionNotes,
    ) -> Result<Option<crate::system::Conversion>> {
        let name = |end: &End<'_>| {
            format!("{}.{}", self.opened[end.port.component].name, end.variable.name)
        };
        let names = format!("{} -> {}", name(from), name(to));
        let (Some(start), Some(end)) = (measured(from), measured(to)) else {
            return Ok(None);
        };
        let way = conversion::between(&start, &end, &self.connection.stages).map_err(|error| {
            let help = match error.code() {
                Code::Unit => Some(
                    "correct a unit, or specify the conversion: a transformation with \
                     suppressUnitConversion=\"true\""
                        .to_owned(),
                ),
                _ => None,
            };
            let what = format!("{names}: {}", error.what());
            let placed = self.wrong(error.code(), what).maybe_help(help);
            match error.reason() {
                Some(why) => placed.why(why),
                None => placed,
            }
        })?;
        let Way { conversion, missing, undefined, converted } = way;
        let function = [from, to].iter().any(|e| matches!(e.model, Model::Function(_)));
        if let (Some(unit), false) = (missing, function) {
            notes.missing.push(format!("{names} ({unit})"));
        }
        if let Some(units) = undefined {
            warnings.push(format!(
                "{}: {names} joins the units {units}, of which one is not defined; the value is \
                 passed on unconverted (suppressUnitConversion=\"true\" silences this)",
                self.connection.place
            ));
        }
        if let (Some((a, b)), Some(conversion)) = (converted, &conversion) {
            notes.converted.push(format!("{names} from {a} to {b}, {conversion}"));
        }
        Ok(conversion)
    }

    fn two_drivers(&self, found: &Connection, first: &RawConnection) -> Error {
        let component = &self.opened[found.to.component];
        let name = component.description().map_or("", |d| &d.variables[found.to.variable].name);
        let what = format!("the input '{}.{name}' has two drivers", component.name);
        self.wrong(Code::Connection, what)
            .why(format!("the connection on line {} already drives it", first.place.line))
            .help("remove one of the two")
    }

    fn wrong(&self, code: Code, what: String) -> Error {
        self.place(Error::new(code, what))
    }

    fn place(&self, error: Error) -> Error {
        self.connection.place.mark(error)
    }
}

fn measured<'a>(end: &End<'a>) -> Option<Measured<'a>> {
    Some(Measured {
        variable: end.variable,
        units: &end.model.description()?.units,
        connector: end.listed.and_then(|l| l.unit.as_ref()),
    })
}
