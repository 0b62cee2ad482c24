//! `cosim score`: figures of merit of existing results.

use std::path::PathBuf;

use clap::Args;
use cosim::Result;
use cosim::campaign::Figures;
use cosim::shown::one_line;

use super::Format;
use super::output::print;
use super::problems;

/// Compute figures of merit of existing results
#[derive(Args)]
pub(crate) struct Score {
    /// The results: CSV, MCAP or Parquet
    #[arg(required = true)]
    results: Vec<PathBuf>,
    /// The file with the [figures] to compute: TOML, such as that of a campaign
    #[arg(long, value_name = "FILE")]
    figures: PathBuf,
    /// Format of the figures on stdout
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

impl Score {
    pub(crate) fn run(self) -> Result<()> {
        problems::reported(self.format, self.computed())
    }

    fn computed(&self) -> Result<()> {
        let figures = Figures::read(&self.figures)?;
        let mut rows = Vec::new();
        for file in &self.results {
            rows.push((file.display().to_string(), figures.of(&cosim::observe::read(file)?)?));
        }
        if self.format == Format::Json {
            let row = |(file, values): &(String, Vec<f64>)| {
                let named =
                    figures.names().map(str::to_owned).zip(values.iter().map(|v| (*v).into()));
                let named: serde_json::Map<String, serde_json::Value> = named.collect();
                serde_json::json!({ "file": file, "figures": named })
            };
            let rows: Vec<_> = rows.iter().map(row).collect();
            return print(&serde_json::Value::from(rows).to_string());
        }
        let width = rows.iter().map(|(file, _)| file.chars().count()).max().unwrap_or(0);
        let mut lines = vec![format!("{:width$}", "file")];
        lines[0].extend(figures.names().map(|name| format!("  {name:>14}")));
        for (file, values) in &rows {
            let mut line = format!("{file:width$}");
            for (value, name) in values.iter().zip(figures.names()) {
                let cell = name.chars().count().max(14);
                line += &format!("  {value:>cell$.6}");
            }
            lines.push(line);
        }
        let lines: Vec<_> = lines.iter().map(|line| one_line(line)).collect();
        print(&lines.join("\n"))
    }
}
