//! `<Simulator>`: an FMU with its step and initial values.

use super::Reader;
use crate::system::raw::{RawComponent, RawModel, RawParameter, Stage};
use cosim_base::error::{Code, Result};
use cosim_base::xml::Element;

const KINDS: [&str; 4] = ["Real", "Integer", "Boolean", "String"];

impl Reader {
    pub(super) fn simulators(&mut self, root: &Element, base_step: Option<f64>) {
        let Some(list) = root.child("Simulators") else {
            let problem = self.wrong(root, "there are no <Simulators>");
            self.gathered.problems.push(problem);
            return;
        };
        self.known(list, &["Simulator"], &[]);
        for element in list.children.iter().filter(|c| c.name == "Simulator") {
            let done = self.simulator(element, base_step);
            self.gathered.take(done);
        }
    }

    fn simulator(&mut self, element: &Element, base_step: Option<f64>) -> Result<()> {
        self.known(element, &["InitialValues"], &["name", "source", "stepSize"]);
        let name = element.require("name", &self.file, Code::Ssd)?.to_owned();
        let source = element.require("source", &self.file, Code::Ssd)?;
        let path = self.base.follow(source, &self.place(element));
        let path = self.gathered.take(path);
        let step = element.parse::<f64>("stepSize", &self.file, Code::Ssd);
        // 0 means the default, as in libcosim.
        let step = self.gathered.take(step).flatten().filter(|step| *step != 0.0);
        self.report_rounding(element, &name, step, base_step);
        if let (Some(path), true) = (&path, self.base.folder.is_some()) {
            self.read_groups(&name, path, element);
        }
        let values = element.grandchildren("InitialValues");
        let affordable = self.spend(values.len() * name.len(), element);
        for value in self.gathered.take(affordable).map_or(&[][..], |()| values) {
            let value = self.initial_value(&name, value);
            let value = self.gathered.take(value);
            self.parameters.extend(value);
        }
        let place = self.place(element);
        self.add(RawComponent {
            name,
            model: path.map_or(RawModel::Unknown, RawModel::Fmu),
            interface: None,
            step: step.or(base_step),
            worker: None,
            connectors: None,
            place,
        });
        Ok(())
    }

    /// libcosim steps by integer multiples of the base step.
    fn report_rounding(
        &mut self,
        element: &Element,
        name: &str,
        step: Option<f64>,
        base: Option<f64>,
    ) {
        let (Some(step), Some(base)) = (step, base) else {
            return;
        };
        let ratio = step / base;
        if ratio.is_finite() && (ratio - ratio.round()).abs() > 1e-9 * ratio {
            self.gathered.warnings.push(format!(
                "{}: the stepSize {step} of '{name}' is not a multiple of the BaseStepSize {base}; \
                 it is kept, libcosim would round it to {} base steps",
                self.place(element),
                ratio.round().max(1.0)
            ));
        }
    }

    fn initial_value(&mut self, simulator: &str, element: &Element) -> Result<RawParameter> {
        self.known(element, &KINDS, &["variable"]);
        let variable = element.require("variable", &self.file, Code::Ssd)?;
        let typed = element.children.iter().find(|c| KINDS.contains(&c.name.as_str()));
        let typed =
            typed.ok_or_else(|| self.wrong(element, format!("'{variable}' has no value")))?;
        Ok(RawParameter {
            name: format!("{simulator}.{variable}"),
            kind: typed.name.to_string(),
            value: typed.require("value", &self.file, Code::Ssd)?.to_owned(),
            unit: None,
            stages: vec![Stage::default()],
            required: true,
            place: self.place(element),
        })
    }
}
