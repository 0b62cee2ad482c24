//! Functions between components: sums of scalars or vectors, as in OSP.
//!
//! out[j] = in[0][j] + in[1][j] + ..., immediately: a function has no state and no delay of its
//! own.

use cosim_import::{Causality, Description, Kind, Output, Variability, Variable};

/// A sum. Its ports are variables of a description, so it is named and checked like an FMU.
#[derive(Debug)]
pub struct Function {
    inputs: usize,
    /// `None`: scalars, whose ports have no second index.
    dimension: Option<usize>,
    description: Description,
}

/// Maximum number of ports: a file may declare any number.
pub(super) const MAX_PORTS: usize = 10_000;

impl Function {
    /// The sum of this many inputs; `None` if that would be too many ports, or none.
    pub fn sum(name: &str, inputs: usize, dimension: Option<usize>) -> Option<Self> {
        let width = dimension.unwrap_or(1);
        let ports = inputs.checked_mul(width).filter(|&n| n > 0 && n <= MAX_PORTS)?;
        let index = |element: usize| match dimension {
            Some(_) => format!("[{element}]"),
            None => String::new(),
        };
        let mut variables = Vec::with_capacity(ports + width);
        for input in 0..inputs {
            for element in 0..width {
                variables.push(port(format!("in[{input}]{}", index(element)), Causality::Input));
            }
        }
        let outputs = (0..width).map(|element| Output {
            variable: ports + element,
            dependencies: Some((0..inputs).map(|input| input * width + element).collect()),
        });
        let outputs = outputs.collect();
        variables.extend((0..width).map(|e| port(format!("out{}", index(e)), Causality::Output)));
        let description = Description::of_model(name, variables, outputs);
        Some(Self { inputs, dimension, description })
    }

    /// Number of terms.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Length of the vectors; `None` for scalars.
    pub fn dimension(&self) -> Option<usize> {
        self.dimension
    }

    /// Its ports.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Positions of the inputs that an output sums.
    pub fn terms(&self, output: usize) -> impl Iterator<Item = usize> {
        let width = self.dimension.unwrap_or(1);
        let element = output.saturating_sub(self.inputs * width);
        (0..self.inputs).map(move |input| input * width + element)
    }
}

fn port(name: String, causality: Causality) -> Variable {
    Variable {
        name,
        value_reference: 0,
        description: String::new(),
        causality,
        variability: Variability::Continuous,
        exact: false,
        nominal: 1.0,
        kind: Kind::Real,
        unit: None,
        start: None,
        line: 0,
    }
}
