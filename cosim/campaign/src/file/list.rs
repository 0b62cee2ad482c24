//! The list of a campaign: parameters in the first line of a CSV file, their values in the others.

use std::collections::HashMap;
use std::path::Path;

use cosim_base::error::{Code, Error, Result};
use cosim_report::rounded;

/// The rows of a list.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct List {
    pub(crate) parameters: Vec<String>,
    /// For each row: the values of the parameters.
    pub(crate) rows: Vec<Vec<String>>,
    /// For each row: what it is called.
    pub(crate) labels: Vec<String>,
}

/// The column with the names of rows: no parameter, as that would have a component before a dot.
const NAME: &str = "name";
/// How many values a label has.
const VALUES: usize = 3;

impl List {
    pub(super) fn read(file: &Path, text: &str) -> Result<Self> {
        let cells = |line: &str| -> Vec<String> {
            line.split(',').map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
        };
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let mut parameters = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
        let (mut rows, mut problems) = (Vec::new(), Vec::new());
        for (number, line) in lines {
            let row = cells(line);
            if row.len() == parameters.len() {
                rows.push(row);
            } else {
                let what = format!("{} values, and {} names", row.len(), parameters.len());
                problems.push(Error::new(Code::Campaign, what).at_line(file, number + 1));
            }
        }
        if rows.is_empty() && problems.is_empty() {
            problems.push(Error::new(Code::Campaign, "the list is empty").at(file));
        }
        Error::all(problems)?;
        let mut labels = Vec::new();
        if let Some(column) = parameters.iter().position(|known| known == NAME) {
            parameters.remove(column);
            labels = rows.iter_mut().map(|row| row.remove(column)).collect();
        }
        let mut list = Self { parameters, rows, labels };
        if list.labels.is_empty() {
            let differs =
                |column: &usize| list.rows.iter().any(|r| r[*column] != list.rows[0][*column]);
            let columns: Vec<usize> = (0..list.parameters.len()).filter(differs).collect();
            list.labels = list.rows.iter().map(|row| list.label(row, &columns)).collect();
        }
        // Cells are found by their names.
        let mut count: HashMap<String, usize> = HashMap::new();
        list.labels.iter().for_each(|label| *count.entry(label.clone()).or_default() += 1);
        for (row, label) in list.labels.iter_mut().enumerate() {
            if count[label] > 1 || (label.is_empty() && list.rows.len() > 1) {
                *label = format!("{label} (row {})", row + 1).trim_start().to_owned();
            }
        }
        Ok(list)
    }

    /// The values of these columns, each with the last part of the parameter's name if that is
    /// enough.
    fn label(&self, row: &[String], columns: &[usize]) -> String {
        let last = |name: &str| name.rsplit('.').next().unwrap_or_default().to_owned();
        let part = |column: &usize| {
            let (name, value) = (&self.parameters[*column], &row[*column]);
            let alike = self.parameters.iter().filter(|other| last(other) == last(name)).count();
            let name = if alike == 1 { last(name) } else { name.clone() };
            match value.parse() {
                Ok(number) if value.len() > 7 && value.contains('.') => {
                    format!("{name}={}", rounded(number, 4))
                }
                _ => format!("{name}={value}"),
            }
        };
        let mut parts: Vec<String> = columns.iter().take(VALUES).map(part).collect();
        parts.extend((columns.len() > VALUES).then(|| "…".to_owned()));
        parts.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(text: &str) -> Vec<String> {
        List::read(Path::new("l.csv"), text).unwrap().labels
    }

    #[test]
    fn rows_are_called_by_what_differs_or_by_their_names() {
        let text = "a.depth,b.sigma,b.k,c.k\n20,0.1,1,0.123456789\n30,0.1,1,2\n";
        assert_eq!(labels(text), ["depth=20, c.k=0.1235", "depth=30, c.k=2"]);
        let named = "a.depth,name\n20,shallow\n30,deep\n40,deep\n50,\n";
        assert_eq!(labels(named), ["shallow", "deep (row 2)", "deep (row 3)", "(row 4)"]);
        assert_eq!(List::read(Path::new("l.csv"), named).unwrap().parameters, ["a.depth"]);
        let many = "a.a,a.b,a.c,a.d\n1,1,1,1\n1,2,2,1\n2,2,2,2\n2,2,2,3\n";
        assert_eq!(labels(many)[2..], ["a=2, b=2, c=2, … (row 3)", "a=2, b=2, c=2, … (row 4)"]);
        assert_eq!(labels("a.b\n1\n"), [""]);
    }
}
