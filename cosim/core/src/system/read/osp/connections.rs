//! `<Connections>`: of variables, of signals, and of groups of them.

use super::Reader;
use crate::system::raw::{RawComponent, RawConnection, RawModel, Stage};
use cosim_base::error::{Code, Error, Result};
use cosim_base::names;
use cosim_base::xml::Element;

/// Memory for a connection without its names, in bytes.
const PER_CONNECTION: usize = size_of::<RawConnection>() + size_of::<Stage>();

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
        for (from, to) in of_a.variables().iter().zip(of_b.variables()) {
            self.spend(PER_CONNECTION + a.0.len() + from.len() + b.0.len() + to.len(), element)?;
            self.connect((a.0.clone(), from.clone()), (b.0.clone(), to.clone()), element);
        }
        Ok(())
    }

    fn of_signal(&mut self, element: &Element) -> Result<()> {
        let (function, signal, variable) = self.mixed(element, "Signal", "Variable")?;
        if let Some(linear) = self.linear_by_name.get(&function).copied() {
            let place = self.place(element);
            match signal.as_str() {
                "in" if self.linear[linear].source.is_some() => {
                    let what = format!("the input of the function '{function}' has two drivers");
                    return Err(place.mark(Error::new(Code::Connection, what)));
                }
                "in" => self.linear[linear].source = Some(variable),
                "out" => self.through(linear, variable, place)?,
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
        let Some(found) = self.group(&group, element)? else {
            return Ok(());
        };
        let variables = found.variables();
        if variables.len() != dimension {
            return Err(self
                .wrong(element, format!("'{}' has {} variables", group.1, variables.len()))
                .why(format!("the vectors of '{function}' have {dimension}")));
        }
        for (index, variable) in variables.iter().enumerate() {
            let names = function.len() + signals.len() + group.0.len() + variable.len();
            self.spend(PER_CONNECTION + names, element)?;
            let signal = format!("{signals}[{index}]");
            let end = (group.0.clone(), variable.clone());
            self.connect((function.clone(), signal), end, element);
        }
        Ok(())
    }

    /// The dimension of a sum.
    fn function(&self, name: &str, element: &Element) -> Result<Option<usize>> {
        if let Some(RawModel::Function(function)) = self.component(name).map(|c| &c.model) {
            return Ok(function.dimension());
        }
        let is_function = |c: &&RawComponent| matches!(c.model, RawModel::Function(_));
        let functions = self.components.iter().filter(is_function).map(|c| c.name.as_str());
        let all = functions.chain(self.linear.iter().map(|l| l.name.as_str()));
        Err(Error::new(Code::UnknownName, format!("there is no function '{name}'"))
            .at_line(&self.file, element.line)
            .maybe_help(names::did_you_mean(name, all)))
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
