//! Selected signals: `--plot "title: a, b"` over time and `--xy "title: x, y; x2, y2"` as paths.

use super::Units;
use cosim_core::{Code, Error, Result};

/// Signals to draw over time in one panel for each unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plot {
    /// Title of the figure.
    pub title: String,
    /// Names of the signals.
    pub signals: Vec<String>,
}

/// Pairs of signals to draw against each other, at equal scale.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct XyPlot {
    /// Title of the figure.
    pub title: String,
    /// Names of horizontal and vertical signals.
    pub pairs: Vec<(String, String)>,
}

impl XyPlot {
    /// The pairs, grouped so that those of a group may share their axes.
    pub(super) fn by_unit(&self, units: &Units) -> Vec<Vec<&(String, String)>> {
        let axes = |(x, y): &(String, String)| (units.axis(x), units.axis(y));
        let mut groups: Vec<Vec<&(String, String)>> = Vec::new();
        for pair in &self.pairs {
            match groups.iter_mut().find(|group| axes(group[0]) == axes(pair)) {
                Some(group) => group.push(pair),
                None => groups.push(vec![pair]),
            }
        }
        groups
    }
}

impl std::str::FromStr for Plot {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let expected = "'title: signal, signal ...'";
        let (title, signals) = split(text, ',', expected)?;
        Ok(Plot { title, signals })
    }
}

impl std::str::FromStr for XyPlot {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let expected = "'title: x, y; x, y ...'";
        let (title, pairs) = split(text, ';', expected)?;
        let pair = |text: &String| match text.split(',').map(str::trim).collect::<Vec<_>>()[..] {
            [x, y] if !x.is_empty() && !y.is_empty() => Ok((x.to_string(), y.to_string())),
            _ => Err(form(text, "'x, y'")),
        };
        Ok(XyPlot { title, pairs: pairs.iter().map(pair).collect::<Result<_, _>>()? })
    }
}

/// The title before the colon and the parts after it.
fn split(text: &str, separator: char, expected: &str) -> Result<(String, Vec<String>)> {
    let parts = text.split_once(':').map(|(title, list)| {
        let parts = list.split(separator).map(|part| part.trim().to_string());
        (title.trim().to_string(), parts.filter(|part| !part.is_empty()).collect::<Vec<_>>())
    });
    match parts {
        Some((title, parts)) if !title.is_empty() && !parts.is_empty() => Ok((title, parts)),
        _ => Err(form(text, expected)),
    }
}

fn form(text: &str, expected: &str) -> Error {
    Error::new(Code::Usage, format!("cannot read the selection '{text}'"))
        .help(format!("the form is {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selections_are_a_title_and_names() {
        let plot: Plot = "Depth: vehicle.pose.z, pressure.depth".parse().unwrap();
        assert_eq!(plot.title, "Depth");
        assert_eq!(plot.signals, ["vehicle.pose.z", "pressure.depth"]);
        let xy: XyPlot = "Path: a.x, a.y; b.x, b.y".parse().unwrap();
        assert_eq!(xy.pairs[1], ("b.x".to_string(), "b.y".to_string()));
    }

    #[test]
    fn a_selection_of_another_form_is_refused_with_the_form() {
        for text in ["", "a, b", "title:", ": a", "title: ,"] {
            let error = text.parse::<Plot>().unwrap_err();
            assert!(error.to_string().contains("title: signal"), "{error}");
        }
        assert!("Path: a, b, c".parse::<XyPlot>().is_err());
    }
}
