//! Which recorded signals belong together.
//!
//! `vehicle.pose.x` belongs to component `vehicle`, group `pose`; `plant.thruster[3].thrust` to
//! group `thruster[].thrust`. Within a group, signals with the same unit and similar magnitude
//! share a panel; a signal whose unit is unknown shares a panel only with elements of the same
//! array.

use super::style::DISTINCT_SIGNALS;

/// Signals of one group share a panel if their magnitudes differ by less than this factor.
const LIKE_SIZE: f64 = 20.0;

/// A signal to be grouped.
pub(super) struct Signal<'a> {
    pub(super) name: String,
    pub(super) unit: Option<&'a str>,
    pub(super) values: Vec<f64>,
}

/// The signals of one component.
pub(super) struct Component {
    pub(super) name: String,
    pub(super) groups: Vec<Group>,
}

/// Signals with the same prefix, the same unit and similar magnitude.
pub(super) struct Group {
    pub(super) name: String,
    pub(super) unit: Option<String>,
    /// Labels (names without the component) and values.
    pub(super) signals: Vec<(String, Vec<f64>)>,
    size: f64,
}

/// The components in the order of their first signals.
pub(super) fn components(signals: Vec<Signal<'_>>) -> Vec<Component> {
    let mut components: Vec<Component> = Vec::new();
    for Signal { name, unit, values } in signals {
        let (component, rest) = name.split_once('.').unwrap_or(("", &name));
        let place = components.iter().position(|c| c.name == component).unwrap_or_else(|| {
            components.push(Component { name: component.into(), groups: Vec::new() });
            components.len() - 1
        });
        components[place].add(rest, unit, values);
    }
    components
}

impl Component {
    fn add(&mut self, signal: &str, unit: Option<&str>, values: Vec<f64>) {
        let size = size(&values);
        let array = signal.contains('[');
        let name = if unit.is_some() || array { group_name(signal) } else { signal.into() };
        let fits = |g: &&mut Group| {
            g.name == name
                && g.unit.as_deref() == unit
                && g.signals.len() < DISTINCT_SIGNALS
                && are_alike(g.size, size)
        };
        let entry = (signal.to_string(), values);
        match self.groups.iter_mut().find(fits) {
            Some(group) => {
                group.size = group.size.max(size);
                group.signals.push(entry);
            }
            None => {
                let unit = unit.map(str::to_owned);
                self.groups.push(Group { name, unit, size, signals: vec![entry] });
            }
        }
    }
}

/// The prefix without the last part; for an array the name of its element with empty brackets.
pub(super) fn group_name(signal: &str) -> String {
    match (signal.split_once('['), signal.rsplit_once('.')) {
        (Some((array, rest)), _) => {
            format!("{array}[]{}", rest.split_once(']').map_or("", |(_, leaf)| leaf))
        }
        (None, Some((prefix, _))) => prefix.into(),
        (None, None) => signal.into(),
    }
}

/// Maximum finite magnitude.
fn size(values: &[f64]) -> f64 {
    values.iter().filter(|v| v.is_finite()).fold(0.0, |greatest, v| greatest.max(v.abs()))
}

fn are_alike(a: f64, b: f64) -> bool {
    a == 0.0 || b == 0.0 || (a / b < LIKE_SIZE && b / a < LIKE_SIZE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn groups(signals: &[(&str, Option<&str>, f64)]) -> Vec<(String, String, usize)> {
        let signal = |(name, unit, size): &(&str, Option<&'static str>, f64)| Signal {
            name: (*name).to_owned(),
            unit: *unit,
            values: vec![0.0, *size],
        };
        let signals: Vec<(&str, Option<&'static str>, f64)> = signals
            .iter()
            .map(|(n, u, s)| (*n, u.map(|u| if u == "m" { "m" } else { "rad" }), *s))
            .collect();
        let components = components(signals.iter().map(signal).collect());
        let all = components.into_iter().flat_map(|component| {
            let name = component.name;
            let groups = component.groups.into_iter();
            groups.map(move |group| (name.clone(), group.name, group.signals.len()))
        });
        all.collect()
    }

    #[test]
    fn signals_are_grouped_by_component_prefix_unit_and_size() {
        let found = groups(&[
            ("a.pose.x", Some("m"), 60.0),
            ("a.pose.y", Some("m"), 30.0),
            ("a.pose.z", Some("m"), 0.5),
            ("a.pose.yaw", Some("rad"), 30.0),
            ("a.thruster[0].thrust", None, 100.0),
            ("a.thruster[1].thrust", None, 90.0),
            ("b.c.d", None, f64::NAN),
            ("b.c.e", None, f64::NAN),
            ("alone", None, 1.0),
        ]);
        let expected = [
            ("a", "pose", 2),
            ("a", "pose", 1),
            ("a", "pose", 1),
            ("a", "thruster[].thrust", 2),
            ("b", "c.d", 1),
            ("b", "c.e", 1),
            ("", "alone", 1),
        ];
        assert_eq!(found, expected.map(|(c, g, n)| (c.to_string(), g.to_string(), n)));
    }

    #[test]
    fn a_panel_has_no_more_signals_than_distinct_colours() {
        let names: Vec<String> = (0..20).map(|i| format!("a.cell[{i}].voltage")).collect();
        let signals: Vec<_> = names.iter().map(|name| (name.as_str(), None, 1.0)).collect();
        let counts: Vec<usize> = groups(&signals).into_iter().map(|(_, _, n)| n).collect();
        assert_eq!(counts, [8, 8, 4]);
    }
}
