//! Components and their listed connectors by name; of two with one name, the first.

use std::collections::HashMap;

use crate::system::raw::{RawConnector, RawSystem};

pub(super) struct Places<'a> {
    components: HashMap<&'a str, usize>,
    connectors: HashMap<(usize, &'a str), &'a RawConnector>,
}

impl<'a> Places<'a> {
    pub(super) fn of(raw: &'a RawSystem) -> Self {
        let (mut components, mut connectors) = (HashMap::new(), HashMap::new());
        for (position, component) in raw.components.iter().enumerate() {
            components.entry(component.name.as_str()).or_insert(position);
            for connector in component.connectors.iter().flatten() {
                connectors.entry((position, connector.name.as_str())).or_insert(connector);
            }
        }
        Self { components, connectors }
    }

    /// The position of a component.
    pub(super) fn component(&self, name: &str) -> Option<usize> {
        self.components.get(name).copied()
    }

    /// A connector that a component lists.
    pub(super) fn connector(&self, component: usize, name: &str) -> Option<&'a RawConnector> {
        self.connectors.get(&(component, name)).copied()
    }
}
