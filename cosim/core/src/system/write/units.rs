//! `<ssd:Units>`: definitions of the units of connected variables.

use std::collections::BTreeMap;

use fmu_standard::Xml;

use crate::system::{Port, System};
use cosim_base::units::{Unit, Units};
use cosim_import::Variable;

/// Units of connected variables that their FMUs define; if two differ, the first is kept.
pub(super) fn collect(system: &System) -> Units {
    let mut units = Units::new();
    let ports = system.connections().iter().flat_map(|c| [c.from, c.to]);
    for (variable, unit) in ports.filter_map(|port| of(system, port)) {
        let name = variable.unit.clone().unwrap_or_default();
        units.entry(name).or_insert(unit);
    }
    units
}

/// A variable and its unit, if its FMU defines it.
pub(super) fn of(system: &System, port: Port) -> Option<(&Variable, Unit)> {
    let description = system.components()[port.component].model.description()?;
    let variable = &description.variables[port.variable];
    Some((variable, *description.units.get(variable.unit.as_ref()?)?))
}

/// Writes the definitions.
pub(super) fn write(xml: &mut Xml, units: &Units) {
    if units.is_empty() {
        return;
    }
    xml.start("ssd:Units", &[]);
    for (name, unit) in units {
        xml.start("ssc:Unit", &[("name", name)]);
        let values: BTreeMap<&str, String> = unit.attributes().into_iter().collect();
        let attributes: Vec<(&str, &str)> =
            values.iter().map(|(name, value)| (*name, value.as_str())).collect();
        xml.empty("ssc:BaseUnit", &attributes);
        xml.close();
    }
    xml.close();
}
