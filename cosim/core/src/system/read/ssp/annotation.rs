//! Settings that SSP does not define: step sizes, the algorithm, what is recorded.
//!
//! The annotations of this master, all of them optional, which other tools ignore:
//!
//! ```xml
//! <ssd:Annotations xmlns:cosim="urn:cosim:1">
//!   <ssc:Annotation type="cosim">
//!     <cosim:Master algorithm="gauss-seidel" stepSize="0.01" outputInterval="0.1">
//!       <cosim:Record variable="plant.*"/>
//!     </cosim:Master>
//!   </ssc:Annotation>
//! </ssd:Annotations>
//! ```
//! in the SystemStructureDescription, its System or its DefaultExperiment, and `<cosim:Component
//! stepSize="0.1" worker="left"/>` in a Component, where `worker` is the worker that computes it in
//! a distributed run. Without them a component steps by the stepSize of its FMU's
//! DefaultExperiment. The annotations of the Open Simulation Platform are read if ours are missing:
//! `<osp:FixedStepAlgorithm baseStepSize="0.01"/>` in `<osp:Algorithm>` of the DefaultExperiment
//! and `<osp:StepSizeHint value="0.1"/>` of a Component. So is `<oms:FixedStepMaster
//! stepSize="0.1"/>` of the system from OMSimulator.

use super::Reader;
use crate::system::Algorithm;
use crate::system::raw::RawMaster;
use cosim_base::error::{Code, Result};
use cosim_base::xml::Element;

/// Namespace of our annotations.
const COSIM: &str = "urn:cosim:1";

/// Namespace of annotations of the Open Simulation Platform.
const OSP: &str = "http://opensimulationplatform.com/SSP/OSPAnnotations";

/// Namespace of annotations of OMSimulator.
const OMS: &str =
    "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";

impl Reader<'_> {
    pub(super) fn master(
        &mut self,
        owner: &Element,
        master: &mut RawMaster,
        recorded: &mut Vec<String>,
    ) {
        for element in self.ours(owner, "Master") {
            self.known(element, &["Record"], &["algorithm", "stepSize", "outputInterval"]);
            if let Some(text) = element.get("algorithm") {
                let algorithm = text.parse().map_err(|e: String| self.wrong(element, e));
                master.algorithm = self.gathered.take(algorithm).or(master.algorithm);
            }
            master.step = self.duration(element, "stepSize").or(master.step);
            let interval = self.duration(element, "outputInterval");
            master.output_interval = interval.or(master.output_interval);
            for record in element.children.iter().filter(|c| c.name == "Record") {
                let variable = record.require("variable", &self.file, Code::Ssd);
                recorded.extend(self.gathered.take(variable).map(str::to_owned));
            }
        }
    }

    /// The base step for all components from the annotation of the Open Simulation Platform; a file
    /// with it is meant for Jacobi.
    pub(super) fn base_step(&mut self, root: &Element, master: &mut RawMaster) -> Option<f64> {
        let algorithms = inside(root.child("DefaultExperiment")?, OSP, "Algorithm");
        let mut children = algorithms.flat_map(|algorithm| &algorithm.children);
        let fixed = children.find(|element| element.name == "FixedStepAlgorithm")?;
        master.algorithm = Some(Algorithm::Jacobi);
        self.duration(fixed, "baseStepSize")
    }

    /// The step for all components from the annotation of OMSimulator.
    pub(super) fn step_of_omsimulator(&mut self, system: &Element) -> Option<f64> {
        let mut settings = inside(system, OMS, "Annotations")
            .flat_map(|annotations| annotations.grandchildren("SimulationInformation"));
        let master = settings.find(|element| element.name == "FixedStepMaster")?;
        self.duration(master, "stepSize").filter(|step| *step > 0.0)
    }

    /// The step of a component.
    pub(super) fn step(&mut self, owner: &Element) -> Option<f64> {
        let mut step = None;
        for element in inside(owner, OSP, "StepSizeHint") {
            step = self.duration(element, "value").or(step);
        }
        for element in self.ours(owner, "Component") {
            self.known(element, &[], &["stepSize", "worker"]);
            step = self.duration(element, "stepSize").or(step);
        }
        step
    }

    /// The worker of a component in a distributed run.
    pub(super) fn worker(&mut self, owner: &Element) -> Option<String> {
        let own = self.ours(owner, "Component");
        own.iter().rev().find_map(|element| element.get("worker").map(str::to_owned))
    }

    /// A step or an interval; 0 means none.
    fn duration(&mut self, element: &Element, name: &str) -> Option<f64> {
        let number: Result<Option<f64>> = element.parse(name, &self.file, Code::Ssd);
        self.gathered.take(number).flatten().filter(|seconds| *seconds != 0.0)
    }

    /// The elements of our namespace in the annotations of `owner`; others than `name` are
    /// reported.
    fn ours<'e>(&mut self, owner: &'e Element, name: &str) -> Vec<&'e Element> {
        let mut found = Vec::new();
        let annotations = owner.grandchildren("Annotations").iter();
        for element in annotations.flat_map(|a| &a.children).filter(|e| e.namespace == COSIM) {
            if element.name == name {
                found.push(element);
            } else {
                let problem = self
                    .wrong(element, format!("<{}> of {COSIM} is unknown here", element.name))
                    .help(format!("did you mean '{name}'?"));
                self.gathered.problems.push(problem);
            }
        }
        found
    }
}

fn inside<'e>(
    owner: &'e Element,
    namespace: &'static str,
    name: &'static str,
) -> impl Iterator<Item = &'e Element> {
    let annotations = owner.grandchildren("Annotations").iter().flat_map(|a| &a.children);
    annotations.filter(move |e| e.namespace == namespace && e.name == name)
}
