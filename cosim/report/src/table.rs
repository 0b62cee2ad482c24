//! A table as data, written as aligned text or as part of a page.

use serde::Serialize;

use cosim_base::shown;

/// A table with a header; the first column is text, the others are numbers.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Table {
    /// What the table shows.
    pub caption: String,
    /// Column headings.
    pub header: Vec<String>,
    /// Cells, row by row; short rows are filled with empty cells.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(caption: impl Into<String>, header: &[&str]) -> Self {
        Table {
            caption: caption.into(),
            header: header.iter().map(|h| (*h).to_string()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// The table as text: first column to the left, the others to the right, rule under the header.
    pub fn text(&self) -> String {
        let lines = || std::iter::once(&self.header).chain(&self.rows);
        let columns = lines().map(Vec::len).max().unwrap_or(0);
        let cell = |row: &[String], i: usize| row.get(i).cloned().unwrap_or_default();
        let widths: Vec<usize> = (0..columns)
            .map(|i| shown::width(lines().map(|row| row.get(i).map_or("", String::as_str))))
            .collect();
        let line = |row: &Vec<String>| {
            let cells = widths.iter().enumerate().map(|(i, &width)| match i {
                0 => format!("{:<width$}", cell(row, i)),
                _ => format!("{:>width$}", cell(row, i)),
            });
            cells.collect::<Vec<_>>().join("  ").trim_end().to_string()
        };
        let rule: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
        let mut text = vec![self.caption.clone(), line(&self.header), rule.join("  ")];
        text.extend(self.rows.iter().map(line));
        text.join("\n") + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_columns_are_aligned_whatever_the_characters() {
        let mut table = Table::new("Errors", &["Error", "dynamic", "σ"]);
        table.push(["Total", "0.16 m", "1"]);
        table.push(["Y-Kalman", "12.345 m"]);
        let expected = "Errors\n\
                        Error      dynamic  σ\n\
                        --------  --------  -\n\
                        Total       0.16 m  1\n\
                        Y-Kalman  12.345 m\n";
        assert_eq!(table.text(), expected);
    }
}
