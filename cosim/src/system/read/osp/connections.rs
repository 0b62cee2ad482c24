//! `<Connections>`: of variables, of signals, and of groups of them.

use super::Reader;
use crate::error::{Code, Error, Result};
use crate::names;
use crate::system::raw::{RawConnection, RawModel, Stage};
use crate::xml::Element;

/// Component and variable.
type Name = (String, String);

impl Reader {
    pub(super) fn connections(&mut self, root: &Element) {
        let Some(list) = root.child("Connections") else {
            self.join_linear();
            return;
        };
        let kinds = [
            "VariableConnection",
            "SignalConnection",
            "VariableGroupConnection",
            "SignalGroupConnection",
        ];
        self.known(list, &kinds, &[]);
        for element in &list.children {
            let done = match element.name.as_str() {
                "VariableConnection" => self.of_variables(element),
                "SignalConnection" => self.of_signal(element),
                "VariableGroupConnection" => self.of_groups(element),
                "SignalGroupConnection" => self.of_signal_group(element),
                // Already reported as unknown.
                _ => Ok(()),
            };
            self.gathered.take(done);
        }
        self.join_linear();
    }

    fn of_variables(&mut self, element: &Element) -> Result<()> {
        let [first, second] = self.two(element, "Variable")?;
        let (from, to) = (self.endpoint(first)?, self.endpoint(second)?);
        self.connect(from, to, element);
        Ok(())
    }

    fn of_groups(&mut self, element: &Element) -> Result<()> {
        let [first, second] = self.two(element, "VariableGroup")?;
        let (a, b) = (self.endpoint(first)?, self.endpoint(second)?);
        let (Some(of_a), Some(of_b)) = (self.group(&a, first)?, self.group(&b, second)?) else {
            return Ok(());
        };
        if of_a.len() != of_b.len() {
            return Err(self.wrong(element, "the two groups differ in size").why(format!(
                "'{}' of '{}' has {} variables, '{}' of '{}' has {}",
                a.1,
                a.0,
                of_a.len(),
                b.1,
                b.0,
                of_b.len()
            )));
        }
        for (from, to) in of_a.into_iter().zip(of_b) {
            self.connect((a.0.clone(), from), (b.0.clone(), to), element);
        }
        Ok(())
    }

    fn of_signal(&mut self, element: &Element) -> Result<()> {
        let (function, signal, variable) = self.mixed(element, "Signal", "Variable")?;
        if let Some(linear) = self.linear.iter().position(|l| l.name == function) {
            let place = self.place(element);
            match signal.as_str() {
                "in" if self.linear[linear].source.is_some() => {
                    let what = format!("the input of the function '{function}' has two drivers");
                    return Err(place.mark(Error::new(Code::Connection, what)));
                }
                "in" => self.linear[linear].source = Some(variable),
                "out" => self.through(linear, variable, place),
                other => {
                    let what = format!("the function '{function}' has no signal '{other}'");
                    return Err(place
                        .mark(Error::new(Code::UnknownName, what))
                        .help("a linear transformation has the signals in and out"));
                }
            }
            return Ok(());
        }
        self.function(&function, element)?;
        self.connect((function, signal), variable, element);
        Ok(())
    }

    fn of_signal_group(&mut self, element: &Element) -> Result<()> {
        let (function, signals, group) = self.mixed(element, "SignalGroup", "VariableGroup")?;
        let dimension = self.function(&function, element)?.unwrap_or(1);
        let Some(variables) = self.group(&group, element)? else {
            return Ok(());
        };
        if variables.len() != dimension {
            return Err(self
                .wrong(element, format!("'{}' has {} variables", group.1, variables.len()))
                .why(format!("the vectors of '{function}' have {dimension}")));
        }
        for (index, variable) in variables.into_iter().enumerate() {
            let signal = format!("{signals}[{index}]");
            self.connect((function.clone(), signal), (group.0.clone(), variable), element);
        }
        Ok(())
    }

    /// The dimension of a sum.
    fn function(&self, name: &str, element: &Element) -> Result<Option<usize>> {
        let functions = self.components.iter().filter_map(|c| match &c.model {
            RawModel::Function(function) => Some((c.name.as_str(), function)),
            _ => None,
        });
        let linear = self.linear.iter().map(|l| l.name.as_str());
        let all = functions.clone().map(|(name, _)| name).chain(linear);
        match functions.clone().find(|(n, _)| *n == name) {
            Some((_, function)) => Ok(function.dimension()),
            None => Err(Error::new(Code::UnknownName, format!("there is no function '{name}'"))
                .at_line(&self.file, element.line)
                .maybe_help(names::did_you_mean(name, all))),
        }
    }

    /// The check determines which of the two is the output.
    fn connect(&mut self, from: Name, to: Name, element: &Element) {
        let place = self.place(element);
        self.connections.push(RawConnection { from, to, stages: vec![Stage::default()], place });
    }

    fn two<'e>(&mut self, element: &'e Element, name: &str) -> Result<[&'e Element; 2]> {
        self.known(element, &[name], &["powerBond"]);
        let ends: Vec<&Element> = element.children.iter().filter(|c| c.name == name).collect();
        <[&Element; 2]>::try_from(ends).map_err(|ends| {
            let what = format!("<{}> has {} <{name}>, not two", element.name, ends.len());
            self.wrong(element, what)
        })
    }

    /// Function, its signal, and the variable.
    fn mixed(
        &mut self,
        element: &Element,
        signal: &str,
        variable: &str,
    ) -> Result<(String, String, Name)> {
        self.known(element, &[signal, variable], &[]);
        let child = |name: &str| {
            element
                .child(name)
                .ok_or_else(|| self.wrong(element, format!("<{}> has no <{name}>", element.name)))
        };
        let (signal, variable) = (child(signal)?, child(variable)?);
        let text = |name| signal.require(name, &self.file, Code::Ssd).map(str::to_owned);
        Ok((text("function")?, text("name")?, self.endpoint(variable)?))
    }

    fn endpoint(&self, element: &Element) -> Result<Name> {
        let text = |name| element.require(name, &self.file, Code::Ssd).map(str::to_owned);
        Ok((text("simulator")?, text("name")?))
    }
}
