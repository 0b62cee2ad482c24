//! `LogConfig.xml`: which variables of which simulators are recorded, and how often.
//!
//! `decimationFactor` n records every n-th step of its simulator. Here, all results have the same
//! interval, so the finest one is used.

use super::Reader;
use crate::system::raw::RawMaster;
use cosim_base::error::Code;
use cosim_base::time::Step;
use cosim_base::xml::{self, Element};

/// The file beside the structure.
pub(in crate::system) const LOG_FILE: &str = "LogConfig.xml";

impl Reader {
    /// Patterns of the recorded variables; empty if there is no such file.
    pub(super) fn log_config(&mut self, master: &mut RawMaster) -> Vec<String> {
        let file = self.base.folder.as_ref().map(|folder| folder.join(LOG_FILE));
        let Some(file) = file.filter(|file| file.is_file()) else {
            return Vec::new();
        };
        let root = xml::read(&file, &file);
        let Some(root) = self.gathered.take(root) else {
            return Vec::new();
        };
        self.file = file.as_path().into();
        self.chosen(&root, master)
    }

    fn chosen(&mut self, root: &Element, master: &mut RawMaster) -> Vec<String> {
        if root.name != "simulators" {
            let problem = self.wrong(root, format!("the root element is <{}>", root.name));
            self.gathered.problems.push(problem.why("a LogConfig has <simulators>"));
            return Vec::new();
        }
        self.known(root, &["simulator"], &["timeStampedFileNames", "precision"]);
        let (mut patterns, mut intervals) = (Vec::new(), Vec::new());
        for simulator in root.children.iter().filter(|c| c.name == "simulator") {
            self.known(simulator, &["variable"], &["name", "decimationFactor"]);
            let name = simulator.require("name", &self.file, Code::Ssd);
            let Some(name) = self.gathered.take(name) else { continue };
            let factor = simulator.parse::<u32>("decimationFactor", &self.file, Code::Ssd);
            let factor = self.gathered.take(factor).flatten().unwrap_or(1).max(1);
            let own = self.component(name).and_then(|c| c.step);
            intervals.extend(own.or(master.step).map(|step| step * f64::from(factor)));
            let affordable = self.spend(simulator.children.len() * name.len(), simulator);
            if self.gathered.take(affordable).is_none() {
                break;
            }
            let variables = simulator.children.iter().filter(|c| c.name == "variable");
            let before = patterns.len();
            for variable in variables {
                let variable = variable.require("name", &self.file, Code::Ssd);
                let variable = self.gathered.take(variable);
                patterns.extend(variable.map(|variable| format!("{name}.{variable}")));
            }
            if patterns.len() == before {
                patterns.push(format!("{name}.*"));
            }
        }
        master.output_interval = common(&intervals);
        if intervals.iter().any(|i| Some(*i) != master.output_interval) {
            self.gathered.notes.push(format!(
                "{}: results have one interval for all simulators: {} s",
                self.file.display(),
                master.output_interval.unwrap_or_default()
            ));
        }
        patterns
    }
}

/// The greatest common divisor.
fn common(intervals: &[f64]) -> Option<f64> {
    let steps = intervals.iter().filter_map(|&i| Step::from_seconds(i).ok());
    steps.reduce(Step::gcd).map(Step::seconds)
}
