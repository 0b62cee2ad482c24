//! Systems for tests, run in this process or in groups.

use std::collections::BTreeMap;

use tempfile::TempDir;

use super::fmu::{Nature, fmu};
use crate::coordinator::Coordinator;
use crate::distribute::Distribution;
use crate::local::{Fault, Files, Local};
use crate::options::Options;
use cosim_core::{Algorithm, Overrides, Recording, Result, Run, Snapshot, Summary, System, Time};

/// A system.
pub(super) struct Sample {
    pub system: System,
}

/// Components (name, nature, step) and connections `a.y b.u`.
pub(super) fn sample(
    components: &[(&str, Nature, f64)],
    connections: &[&str],
    algorithm: Algorithm,
) -> Sample {
    let folder = TempDir::new().unwrap();
    let mut elements = String::new();
    for (name, nature, step) in components {
        let fmu = fmu(*nature);
        elements += &format!(
            "<ssd:Component name='{name}' type='application/x-fmu-sharedlibrary' source='{}'><ssd:Connectors>
<ssd:Connector name='u' kind='input'><ssc:Real/></ssd:Connector>
<ssd:Connector name='v' kind='input'><ssc:Real/></ssd:Connector>
<ssd:Connector name='y' kind='output'><ssc:Real/></ssd:Connector></ssd:Connectors>
<ssd:Annotations><ssc:Annotation type='cosim'><cosim:Component stepSize='{step}'/></ssc:Annotation></ssd:Annotations>
</ssd:Component>\n",
            fmu.display()
        );
    }
    let mut wires = String::new();
    for connection in connections {
        let (from, to) = connection.split_once(' ').unwrap();
        let ((a, y), (b, u)) = (from.split_once('.').unwrap(), to.split_once('.').unwrap());
        wires += &format!(
            "<ssd:Connection startElement='{a}' startConnector='{y}' endElement='{b}' endConnector='{u}'/>\n"
        );
    }
    let text = format!(
        "<?xml version='1.0' encoding='UTF-8'?>
<ssd:SystemStructureDescription version='1.0' name='test' xmlns:cosim='urn:cosim:1'
 xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription'
 xmlns:ssc='http://ssp-standard.org/SSP1/SystemStructureCommon'>
<ssd:System name='test'><ssd:Elements>
{elements}</ssd:Elements><ssd:Connections>
{wires}</ssd:Connections></ssd:System>
<ssd:DefaultExperiment startTime='0' stopTime='2'/>
</ssd:SystemStructureDescription>\n"
    );
    let file = folder.path().join("test.ssd");
    std::fs::write(&file, text).unwrap();
    let overrides = Overrides::new().algorithm(algorithm).output_variable("*.?");
    Sample { system: System::load(&file, &overrides).unwrap() }
}

/// A chain of feed-through components with several rates, model exchange and a feedback.
pub(super) fn chain(algorithm: Algorithm) -> Sample {
    use Nature::{Exchange, State, Through};
    sample(
        &[
            ("a", State, 0.1),
            ("b", Through, 0.1),
            ("c", Through, 0.2),
            ("d", Through, 0.05),
            ("e", Exchange, 0.1),
        ],
        &["a.y b.u", "b.y c.u", "c.y d.u", "d.y a.v", "a.y d.v", "c.y e.u", "e.y b.v"],
        algorithm,
    )
}

/// A solved loop of feed-through through b and c, with a source and a sink.
pub(super) fn solved() -> Sample {
    use Nature::{State, Through};
    sample(
        &[("a", State, 0.1), ("b", Through, 0.1), ("c", Through, 0.1), ("d", Through, 0.1)],
        &["c.y b.u", "b.y c.u", "a.y c.v", "b.y d.u", "d.y a.v"],
        Algorithm::Iterative,
    )
}

/// One FMU driven by recorded inputs.
pub(super) fn driven() -> Sample {
    let fmu = fmu(Nature::Through);
    let time: Vec<f64> = (0..20).map(|k| 0.1 * f64::from(k)).collect();
    let u = time.iter().map(|t| t * t - 0.3).collect();
    let inputs = Recording::from_columns(vec!["u".to_owned()], time, vec![u]);
    let overrides = Overrides::new().step("", 0.05).stop_time(2.0).output_variable("?");
    let system = System::single(&fmu, &overrides, Some(inputs.table())).unwrap();
    Sample { system }
}

/// The bits of everything that was recorded.
pub(super) type Bits = Vec<Vec<u64>>;

fn bits(recording: &Recording) -> Bits {
    let of = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect();
    let mut all: Bits = recording.columns().map(|(_, values)| of(values)).collect();
    all.push(of(recording.time()));
    all
}

/// An ordinary run.
pub(super) fn here(system: &System) -> (Bits, Summary) {
    let mut recording = Recording::new();
    let summary = Run::new(system).observe(&mut recording).go().unwrap();
    (bits(&recording), summary)
}

/// How to run a system in groups.
#[derive(Default)]
pub(super) struct Trial<'a> {
    pub faults: Vec<(u64, Fault)>,
    pub options: Options,
    pub resume: Option<&'a Snapshot>,
    /// A snapshot is taken at this instant.
    pub keep: Option<Time>,
}

/// The outcome.
pub(super) struct Outcome {
    pub bits: Bits,
    pub summary: Summary,
    pub kept: Option<Snapshot>,
    /// The messages that group 0 was sent.
    pub sent_to_first: Vec<Vec<u8>>,
    pub files: BTreeMap<String, std::path::PathBuf>,
}

/// Runs in the groups given by `places`.
pub(super) fn apart(system: &System, places: &[usize], trial: Trial<'_>) -> Result<Outcome> {
    let Distribution { plan, layout, setups, files } = Distribution::new(system, places)?;
    let files: BTreeMap<_, _> = files.into_iter().flatten().collect();
    let fabric = Local::new(Files(files.clone()), trial.faults);
    let sent_to_first = fabric.sent_to_first.clone();
    let fabric = Box::new(fabric);
    let mut driven = Coordinator::new(system, plan, layout, &setups, fabric, trial.options)?;
    let (mut recording, mut kept) = (Recording::new(), None);
    let mut keep = |snapshot| {
        kept = Some(snapshot);
        Ok(())
    };
    let at: Vec<Time> = trial.keep.into_iter().collect();
    let mut run = Run::new(system).observe(&mut recording).snapshots(None, &at, &mut keep);
    if let Some(snapshot) = trial.resume {
        run = run.resume(snapshot);
    }
    let summary = run.drive_all(&mut driven)?;
    let sent_to_first = sent_to_first.borrow().clone();
    Ok(Outcome { bits: bits(&recording), summary, kept, sent_to_first, files })
}

/// Every way to divide `count` components into groups, numbered by their first member.
pub(super) fn placements(count: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..count {
        let longer = all.iter().flat_map(|places| {
            let next = places.iter().max().map_or(0, |highest| highest + 1);
            (0..=next).map(|group| [&places[..], &[group]].concat())
        });
        all = longer.collect();
    }
    all
}

/// Random numbers that are the same in every test run.
pub(super) struct Dice(pub u64);

impl Dice {
    pub(super) fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 33) % limit
    }
}
