//! Connectors of the outermost system: what they lead to, and the conversion of values on the way.
//!
//! In a run nothing drives or reads them. They matter if the system is part of something else: an
//! exported FMU exposes them as its own variables.

use super::Findings;
use super::components::{Opened, unknown_component, variable};
use super::conversion::{self, Measured};
use super::places::Places;
use crate::system::raw::{RawConnector, RawEnd, RawPort, RawSystem};
use crate::system::{Conversion, Port, SystemPort};
use cosim_base::error::{Code, Error, Result};
use cosim_import::{Causality, Kind, Variable};

pub(super) fn check(
    raw: &RawSystem,
    places: &Places<'_>,
    opened: &[Opened],
    findings: &mut Findings,
) -> Vec<SystemPort> {
    let mut ports = Vec::new();
    for port in &raw.ports {
        let name = &port.connector.name;
        if port.ends.is_empty() {
            findings.notes.push(format!("the system's connector '{name}' leads nowhere"));
            continue;
        }
        let found = of(port, places, opened).map_err(|error| port.connector.place.mark(error));
        ports.extend(findings.note(found).flatten());
    }
    ports
}

/// `None`: it depends on an FMU that could not be opened.
fn of(port: &RawPort, places: &Places<'_>, opened: &[Opened]) -> Result<Option<SystemPort>> {
    let RawPort { connector, ends, inward } = port;
    let causality = match (connector.kind.as_str(), inward) {
        ("parameter" | "structuralParameter", true) => Causality::Parameter,
        (_, true) => Causality::Input,
        ("calculatedParameter", false) => Causality::CalculatedParameter,
        (_, false) => Causality::Output,
    };
    let mut found = Vec::new();
    for end in ends {
        let Some((port, variable, measured)) = inner(end, places, opened)? else {
            return Ok(None);
        };
        let wanted = connector.kind_of_value.as_deref();
        if wanted.is_some_and(|wanted| !fits(wanted, &variable.kind)) {
            let what = format!("the system's connector '{}'", connector.name);
            let (component, own) = &end.name;
            return Err(Error::new(Code::Connection, what).why(format!(
                "it is a {}, and '{component}.{own}' is a {}",
                wanted.unwrap_or_default(),
                variable.kind.name()
            )));
        }
        found.push((port, conversion(&measured, end, (connector, *inward))?));
    }
    let unit = connector.unit.clone();
    Ok(Some(SystemPort { name: connector.name.clone(), causality, ends: found, unit }))
}

type Found<'a> = (Port, &'a Variable, Measured<'a>);

fn inner<'a>(end: &RawEnd, places: &Places<'a>, opened: &'a [Opened]) -> Result<Option<Found<'a>>> {
    let (owner, name) = &end.name;
    let component = places.component(owner).ok_or_else(|| {
        let names = opened.iter().map(|o| o.name.as_str());
        unknown_component(owner, names)
    })?;
    let Some(model) = &opened[component].model else {
        return Ok(None);
    };
    let (position, variable) = variable(owner, model, name)?;
    let Some(description) = model.description() else {
        return Ok(None);
    };
    let listed = places.connector(component, name).filter(|_| !opened[component].replaced);
    let connector = listed.and_then(|connector| connector.unit.as_ref());
    let measured = Measured { variable, units: &description.units, connector };
    Ok(Some((Port { component, variable: position }, variable, measured)))
}

fn conversion(
    measured: &Measured<'_>,
    end: &RawEnd,
    (connector, inward): (&RawConnector, bool),
) -> Result<Option<Conversion>> {
    let variable = measured.variable;
    if let Some(map) = conversion::map(&variable.kind, &variable.kind, &end.stages)? {
        return Ok(Some(Conversion::Map(map)));
    }
    if variable.kind != Kind::Real {
        return Ok(None);
    }
    let way = match inward {
        true => conversion::of_value(connector.unit.as_ref(), measured, &end.stages)?,
        false => conversion::outward(measured, &end.stages)?,
    };
    Ok(way.conversion)
}

/// Whether a connector of that type is compatible with a variable.
fn fits(connector: &str, kind: &Kind) -> bool {
    match kind {
        Kind::Integer | Kind::Enumeration(_) => matches!(connector, "Integer" | "Enumeration"),
        _ => connector == kind.name(),
    }
}
