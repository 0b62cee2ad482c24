//! Resolves full names of variables, `component.variable`, to ports.

use std::sync::Arc;

use super::components::{Opened, unknown_component, variable};
use crate::system::raw::RawUnit;
use crate::system::{Component, Model, Port};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_import::{Fmu, Variable};

/// The names of a system's variables.
pub(in crate::system) struct Names {
    /// In the order of the components.
    targets: Vec<Target>,
    /// Their positions in the order of their prefixes, each with the place in this list of the
    /// longest other prefix that it starts with.
    sorted: Vec<(usize, Option<usize>)>,
    /// A component could not be opened, so a correct name may not be found.
    incomplete: bool,
}

struct Target {
    /// The prefix of its variables: `component.`, or empty for a single FMU.
    prefix: String,
    component: usize,
    model: Option<Model>,
}

impl Names {
    pub(super) fn of(opened: &[Opened]) -> Self {
        let targets = opened.iter().enumerate().map(|(component, opened)| Target {
            prefix: format!("{}.", opened.name),
            component,
            model: opened.model.clone(),
        });
        Self::new(targets.collect(), opened.iter().any(|o| o.model.is_none()))
    }

    /// Names of one FMU without a prefix.
    pub(in crate::system) fn single(fmu: &Arc<Fmu>) -> Self {
        let model = Some(Model::Fmu(fmu.clone()));
        let target = Target { prefix: String::new(), component: 0, model };
        Self::new(vec![target], false)
    }

    /// Names of components with the prefix `component.`, or of the first one without it.
    pub(in crate::system) fn of_components(components: &[Component], prefixed: bool) -> Self {
        let targets = components.iter().enumerate().filter_map(|(component, c)| {
            c.model.description()?;
            let prefix = if prefixed { format!("{}.", c.name) } else { String::new() };
            Some(Target { prefix, component, model: Some(c.model.clone()) })
        });
        Self::new(targets.collect(), false)
    }

    fn new(targets: Vec<Target>, incomplete: bool) -> Self {
        let prefix = |at: usize| targets[at].prefix.as_str();
        let mut order: Vec<usize> = (0..targets.len()).collect();
        // Stable: of two components with one name, the last is found.
        order.sort_by_key(|&at| prefix(at));
        let mut sorted: Vec<(usize, Option<usize>)> = Vec::with_capacity(order.len());
        for at in order {
            let mut shorter = sorted.len().checked_sub(1);
            while let Some(place) = shorter {
                let (other, next) = sorted[place];
                if prefix(at).starts_with(prefix(other)) {
                    break;
                }
                shorter = next;
            }
            sorted.push((at, shorter));
        }
        Self { targets, sorted, incomplete }
    }

    /// The component with the longest prefix that a name starts with: names of components may
    /// contain dots.
    fn target(&self, name: &str) -> Option<&Target> {
        let after = self.sorted.partition_point(|&(at, _)| *self.targets[at].prefix <= *name);
        let mut place = after.checked_sub(1);
        while let Some((at, shorter)) = place.map(|place| self.sorted[place]) {
            let target = &self.targets[at];
            if name.starts_with(&target.prefix) {
                return Some(target);
            }
            place = shorter;
        }
        None
    }

    /// A port by full name.
    pub(in crate::system) fn port(&self, name: &str) -> Result<Port> {
        self.find(name)?.map(|(port, _)| port).ok_or_else(|| self.unknown(name))
    }

    /// A port and its variable by full name; `None` if its component could not be opened.
    pub(in crate::system) fn find(&self, name: &str) -> Result<Option<(Port, &Variable)>> {
        let Some(target) = self.target(name) else {
            return Err(self.unknown(name));
        };
        let Some(model) = &target.model else {
            return Ok(None);
        };
        let rest = &name[target.prefix.len()..];
        let owner = match (target.prefix.trim_end_matches('.'), model.description()) {
            ("", Some(description)) => &description.model_name,
            (component, _) => component,
        };
        let (position, found) = variable(owner, model, rest)?;
        Ok(Some((Port { component: target.component, variable: position }, found)))
    }

    fn unknown(&self, name: &str) -> Error {
        let components = self.targets.iter().map(|t| t.prefix.trim_end_matches('.'));
        match name.split_once('.') {
            Some((component, _)) => unknown_component(component, components)
                .why(format!("'{name}' is read as component.variable")),
            None => Error::new(Code::UnknownName, format!("'{name}' is not a variable"))
                .why("in a system a variable is named component.variable")
                .maybe_help(names::did_you_mean(name, components)),
        }
    }

    /// The unit of a variable, as named and defined in its description.
    pub(in crate::system) fn unit(&self, port: Port) -> Option<RawUnit> {
        let found = self.targets.binary_search_by_key(&port.component, |target| target.component);
        self.targets[found.ok()?].model.as_ref()?.unit(port.variable)
    }

    /// Every variable with its full name, component by component.
    pub(in crate::system) fn all(&self) -> impl Iterator<Item = (String, Port, &Variable)> {
        self.starting_with("")
    }

    /// Those whose full name may start with `start`.
    pub(in crate::system) fn starting_with<'a>(
        &'a self,
        start: &'a str,
    ) -> impl Iterator<Item = (String, Port, &'a Variable)> {
        let may = move |target: &&Target| {
            let prefix = target.prefix.as_str();
            prefix.starts_with(start) || start.starts_with(prefix)
        };
        self.targets.iter().filter(may).flat_map(|target| {
            let description = target.model.as_ref().and_then(Model::description);
            let variables = description.into_iter().flat_map(|d| &d.variables).enumerate();
            variables.map(|(position, variable)| {
                let port = Port { component: target.component, variable: position };
                (format!("{}{}", target.prefix, variable.name), port, variable)
            })
        })
    }

    /// The number of components.
    pub(in crate::system) fn components(&self) -> usize {
        self.targets.len()
    }

    pub(in crate::system) fn incomplete(&self) -> bool {
        self.incomplete
    }
}
