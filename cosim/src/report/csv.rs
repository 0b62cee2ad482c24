//! Reads result files in the form of FMPy: a header that starts with `time`, commas, one row an
//! instant. Names may stand in double quotes.

use std::path::Path;

use crate::{Code, Error, Result};

/// A result file in memory.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Results {
    /// Names of the signals, without `time`.
    pub names: Vec<String>,
    /// Instants, s, never decreasing.
    pub time: Vec<f64>,
    /// One column of values for each name.
    pub columns: Vec<Vec<f64>>,
}

impl Results {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self> {
        let fail = || Error::new(Code::Results, "cannot read the results");
        let text = std::fs::read_to_string(path).map_err(|e| fail().at(path).why(e))?;
        Results::parse(&text).map_err(|(line, reason)| fail().at_line(path, line).why(reason))
    }

    /// The values of a signal, by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.names
            .iter()
            .position(|n| n == name)
            .map(|i| self.columns[i].as_slice())
    }

    /// Parses the text; an error is the line (from 1) and what is wrong there.
    fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
        let (_, header) = lines.next().ok_or((1, "the file is empty".to_string()))?;
        let names = header_names(header).map_err(|reason| (1, reason))?;
        let mut results = Results {
            columns: vec![Vec::new(); names.len()],
            names,
            time: Vec::new(),
        };
        for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
            results.push(line).map_err(|reason| (number, reason))?;
        }
        Ok(results)
    }

    fn push(&mut self, line: &str) -> Result<(), String> {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() != self.names.len() + 1 {
            let expected = self.names.len() + 1;
            return Err(format!(
                "{} values where the header has {expected}",
                cells.len()
            ));
        }
        let time = number(cells[0], "time")?;
        if !time.is_finite() {
            return Err(format!("time {time} is not a finite number"));
        }
        if self.time.last().is_some_and(|last| time < *last) {
            return Err(format!("time {time} lies before that of the row above"));
        }
        self.time.push(time);
        for ((cell, name), column) in cells[1..].iter().zip(&self.names).zip(&mut self.columns) {
            column.push(number(cell, name)?);
        }
        Ok(())
    }
}

fn header_names(line: &str) -> Result<Vec<String>, String> {
    let unquoted = |name: &str| name.trim().trim_matches('"').to_string();
    let mut names = line.trim_start_matches('\u{feff}').split(',').map(unquoted);
    match names.next() {
        Some(first) if first == "time" => {}
        first => {
            let found = first.unwrap_or_default();
            return Err(format!(
                "the first column must be \"time\", found \"{found}\""
            ));
        }
    }
    let names: Vec<String> = names.collect();
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort();
    match sorted.windows(2).find(|w| w[0] == w[1]) {
        Some(twice) => Err(format!("the column \"{}\" appears twice", twice[0])),
        None => Ok(names),
    }
}

fn number(cell: &str, name: &str) -> Result<f64, String> {
    match cell {
        "True" | "true" => Ok(1.0),
        "False" | "false" => Ok(0.0),
        _ => cell
            .parse()
            .map_err(|_| format!("\"{cell}\" in column \"{name}\" is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_fmpy_writes() {
        let results = Results::parse("\"time\",\"h\",\"v\"\n0.0,1.0,-0.5\n1e-1,nan,2\n").unwrap();
        assert_eq!(results.names, ["h", "v"]);
        assert_eq!(results.time, [0.0, 0.1]);
        assert_eq!(results.column("v"), Some(&[-0.5, 2.0][..]));
        assert!(results.columns[0][1].is_nan());
        assert_eq!(results.column("w"), None);
    }

    #[test]
    fn errors_name_the_line_and_the_column() {
        let error = |text: &str| Results::parse(text).unwrap_err();
        assert_eq!(error("").0, 1);
        assert!(error("t,x\n").1.contains("\"t\""));
        assert!(error("time,x,x\n").1.contains("twice"));
        let bad = error("time,x\n0,1\n\n1,one\n");
        assert_eq!(bad, (4, "\"one\" in column \"x\" is not a number".into()));
        assert_eq!(
            error("time,x\n0,1,2\n"),
            (2, "3 values where the header has 2".into())
        );
        assert_eq!(error("time,x\n1,1\n0,2\n").0, 3);
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = Results::read(Path::new("no/such.csv")).unwrap_err();
        assert!(error.to_string().contains("no/such.csv"));
    }
}
