//! `examples/baseline.ssd` with some of its filters, steered by one of them or by the truth.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Context;
use cosim::{Overrides, System};

use super::filter::Filter;
use crate::paths;

/// The source of pose and velocity for guidance and control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Steering {
    /// The true pose and velocity: the path depends on no filter.
    Truth,
    /// The estimate of the model-aided filter closes every loop.
    Estimate,
}

/// Systems by their structure. They are kept, so that the FMUs are unpacked once.
pub(crate) struct Systems(BTreeMap<(Steering, &'static [Filter]), System>);

impl Systems {
    /// Writes and reads the systems of these kinds.
    pub(crate) fn load(
        kinds: impl IntoIterator<Item = (Steering, &'static [Filter])>,
    ) -> anyhow::Result<Self> {
        let file = paths::root().join("examples/baseline.ssd");
        let baseline = std::fs::read_to_string(&file)
            .with_context(|| format!("cannot read {}", file.display()))?;
        let mut systems = BTreeMap::new();
        for kind in kinds {
            if !systems.contains_key(&kind) {
                let file = folder()?.join(format!("{}.ssd", systems.len()));
                std::fs::write(&file, text(&baseline, kind.0, kind.1))?;
                systems.insert(kind, System::load(&file, &Overrides::new())?);
            }
        }
        Ok(Self(systems))
    }

    /// The system of a kind.
    pub(crate) fn get(&self, kind: (Steering, &'static [Filter])) -> anyhow::Result<&System> {
        self.0.get(&kind).context("this kind of system was not loaded")
    }
}

/// `target/navigate`.
pub(crate) fn folder() -> anyhow::Result<PathBuf> {
    let folder = paths::target().join("navigate");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot create {}", folder.display()))?;
    Ok(folder)
}

/// The system's description without the other filters, with its FMUs where they are relative to
/// [`folder`], and with guidance and control connected to the truth if it steers.
fn text(baseline: &str, steering: Steering, filters: &[Filter]) -> String {
    let others = Filter::ALL.iter().filter(|f| !filters.contains(f));
    let others: Vec<&str> = others.map(|f| f.component()).collect();
    let mut kept = String::new();
    let mut inside = false;
    for line in baseline.lines() {
        let names = |attribute: &str| {
            others.iter().any(|name| line.contains(&format!("{attribute}=\"{name}\"")))
        };
        inside |= line.contains("<ssd:Component ") && names("name");
        let for_others = inside || names("endElement");
        inside &= !line.contains("</ssd:Component>");
        if for_others {
            continue;
        }
        let from_filter = line.contains("startElement=\"filter\"");
        match (steering, from_filter) {
            (Steering::Truth, true) if line.contains(".loss\"") => {}
            (Steering::Truth, true) => kept += &line.replacen("\"filter\"", "\"vehicle\"", 1),
            _ => kept += line,
        }
        kept.push('\n');
    }
    kept.replace("../target/fmus/", "../fmus/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_asked_for_is_kept_and_the_truth_steers() {
        let file = paths::root().join("examples/baseline.ssd");
        let baseline = std::fs::read_to_string(file).unwrap();
        let truth = text(&baseline, Steering::Truth, &[Filter::Dynamic]);
        for absent in ["\"filter\"", "\"inertial\"", "\"ekf_kinematic\"", "../target"] {
            assert!(!truth.contains(absent), "{absent}");
        }
        let steers = "startElement=\"vehicle\" startConnector=\"pose.x\" endElement=\"pursuit\"";
        assert!(truth.contains(steers));
        assert!(truth.contains("endElement=\"dynamic\" endConnector=\"dvl.velocity.u\""));
        let estimate = text(&baseline, Steering::Estimate, &Filter::ALL);
        assert_eq!(estimate, baseline.replace("../target/fmus/", "../fmus/"));
    }
}
