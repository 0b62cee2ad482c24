//! Which recorded signals belong together.
//!
//! `vehicle.pose.x` belongs to component `vehicle`, group `pose`; `plant.thruster[3].thrust` to
//! group `thruster[].thrust`. Within a group, signals of like size share a panel.

use super::style::DISTINCT_SIGNALS;
use crate::Recording;

/// Signals of one group share a panel while their sizes differ by less than this factor.
const LIKE_SIZE: f64 = 20.0;

/// The signals of one component.
pub(super) struct Component<'a> {
    pub(super) name: String,
    pub(super) groups: Vec<Group<'a>>,
}

/// Signals of one prefix and of like size.
pub(super) struct Group<'a> {
    pub(super) name: String,
    /// Labels (names without the component) and values.
    pub(super) signals: Vec<(String, &'a [f64])>,
    size: f64,
}

/// The components in the order of their first signals.
pub(super) fn components(recording: &Recording) -> Vec<Component<'_>> {
    let mut components: Vec<Component> = Vec::new();
    for (name, values) in recording.columns().filter(|(name, _)| !recording.is_text(name)) {
        let (component, rest) = name.split_once('.').unwrap_or(("", name));
        let place = components.iter().position(|c| c.name == component).unwrap_or_else(|| {
            components.push(Component { name: component.into(), groups: Vec::new() });
            components.len() - 1
        });
        components[place].add(rest, values);
    }
    components
}

impl<'a> Component<'a> {
    fn add(&mut self, signal: &str, values: &'a [f64]) {
        let size = size(values);
        let name = group_name(signal);
        let fits = |g: &&mut Group| {
            g.name == name && g.signals.len() < DISTINCT_SIGNALS && are_alike(g.size, size)
        };
        let entry = (signal.to_string(), values);
        match self.groups.iter_mut().find(fits) {
            Some(group) => {
                group.size = group.size.max(size);
                group.signals.push(entry);
            }
            None => self.groups.push(Group { name, size, signals: vec![entry] }),
        }
    }
}

/// The prefix without the last part; of an array its element's name with empty brackets.
fn group_name(signal: &str) -> String {
    match (signal.split_once('['), signal.rsplit_once('.')) {
        (Some((array, rest)), _) => {
            format!("{array}[]{}", rest.split_once(']').map_or("", |(_, leaf)| leaf))
        }
        (None, Some((prefix, _))) => prefix.into(),
        (None, None) => signal.into(),
    }
}

/// Greatest finite magnitude.
fn size(values: &[f64]) -> f64 {
    values.iter().filter(|v| v.is_finite()).fold(0.0, |greatest, v| greatest.max(v.abs()))
}

fn are_alike(a: f64, b: f64) -> bool {
    a == 0.0 || b == 0.0 || (a / b < LIKE_SIZE && b / a < LIKE_SIZE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_are_grouped_by_component_prefix_and_size() {
        let sizes = [
            ("a.pose.x", 60.0),
            ("a.pose.y", 30.0),
            ("a.pose.yaw", 0.5),
            ("a.thruster[0].thrust", 100.0),
            ("a.thruster[1].thrust", 90.0),
            ("b.depth", f64::NAN),
            ("alone", 1.0),
        ];
        let names = sizes.iter().map(|s| s.0.to_string()).collect();
        let columns = sizes.iter().map(|s| vec![0.0, s.1]).collect();
        let recording = Recording::from_columns(names, vec![0.0, 1.0], columns);
        let mut groups = Vec::new();
        for component in components(&recording) {
            for group in component.groups {
                groups.push((component.name.clone(), group.name, group.signals.len()));
            }
        }
        let expected = [
            ("a", "pose", 2),
            ("a", "pose", 1),
            ("a", "thruster[].thrust", 2),
            ("b", "depth", 1),
            ("", "alone", 1),
        ];
        assert_eq!(groups, expected.map(|(c, g, n)| (c.to_string(), g.to_string(), n)));
    }

    #[test]
    fn a_panel_has_no_more_signals_than_distinct_colours() {
        let names = (0..20).map(|i| format!("a.cell[{i}].voltage")).collect();
        let recording = Recording::from_columns(names, vec![0.0], vec![vec![1.0]; 20]);
        let counts =
            components(&recording)[0].groups.iter().map(|g| g.signals.len()).collect::<Vec<_>>();
        assert_eq!(counts, [8, 8, 4]);
    }
}
