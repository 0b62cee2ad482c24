//! Writes systems for tests.

use std::fmt::Write;
use std::path::PathBuf;

use cosim::{Error, Overrides, Recording, System};
use tempfile::TempDir;

use crate::models::Model;

/// A system description being written.
pub(crate) struct Ssd {
    folder: TempDir,
    components: String,
    connections: String,
    annotation: String,
    stop: f64,
}

/// Co-simulation and model exchange, events of all kinds, steps that differ, an algebraic loop.
pub(crate) fn zoo() -> Ssd {
    use Model::{
        Affine, Ball, Clock, Counter, Integrator, Lag, Mass, Oscillator, Sawtooth, Ticker,
    };
    Ssd::new()
        .add("clock", Clock)
        .add_with("slow", Integrator, &[("second", 0.3)], Some(0.3))
        .add("count", Counter)
        .add("lag", Lag)
        .add("ball", Ball)
        .add_with("ticks", Ticker, &[("k", 0.07)], None)
        .add("saw", Sawtooth)
        .add("swing", Oscillator)
        .add_with("p", Affine, &[("k", 0.3)], None)
        .add_with("q", Affine, &[("k", -0.4)], None)
        .add_with("mass", Mass, &[("k", 5.0), ("second", 1.0), ("m", 1.0)], None)
        .connect("clock.y", "slow.u")
        .connect("slow.y", "lag.u")
        .connect("count.n", "ticks.m")
        .connect("swing.y", "mass.u")
        .connect("p.y", "q.u")
        .connect("q.y", "p.u")
        .stop(1.5)
}

impl Ssd {
    pub(crate) fn new() -> Self {
        Self {
            folder: TempDir::new().unwrap(),
            components: String::new(),
            connections: String::new(),
            annotation: String::new(),
            stop: 1.0,
        }
    }

    pub(crate) fn add(self, name: &str, model: Model) -> Self {
        self.add_with(name, model, &[], None)
    }

    /// A component with values of Real parameters, and its step.
    pub(crate) fn add_with(
        mut self,
        name: &str,
        model: Model,
        values: &[(&str, f64)],
        step: Option<f64>,
    ) -> Self {
        let source = model.fmu();
        let parameters: String = values
            .iter()
            .map(|(n, v)| {
                let kind = if *n == "m" { "Integer" } else { "Real" };
                format!("<ssv:Parameter name='{n}'><ssv:{kind} value='{v}'/></ssv:Parameter>\n")
            })
            .collect();
        let step = step.map_or(String::new(), |s| {
            format!(
                "<ssd:Annotations><ssc:Annotation type='cosim'><cosim:Component stepSize='{s}'/>\
                 </ssc:Annotation></ssd:Annotations>"
            )
        });
        write!(
            self.components,
            "<ssd:Component name='{name}' type='application/x-fmu-sharedlibrary' source='{}'>
<ssd:Connectors>
<ssd:Connector name='u' kind='input'><ssc:Real/></ssd:Connector>
<ssd:Connector name='y' kind='output'><ssc:Real/></ssd:Connector>
<ssd:Connector name='m' kind='input'><ssc:Integer/></ssd:Connector>
<ssd:Connector name='n' kind='output'><ssc:Integer/></ssd:Connector>
<ssd:Connector name='odd' kind='input'><ssc:Boolean/></ssd:Connector>
<ssd:Connector name='even' kind='output'><ssc:Boolean/></ssd:Connector>
</ssd:Connectors>
<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version='1.0' name='p'><ssv:Parameters>
{parameters}</ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
{step}</ssd:Component>
",
            source.display()
        )
        .unwrap();
        self
    }

    /// Connects `a.y` to `b.u`.
    pub(crate) fn connect(mut self, from: &str, to: &str) -> Self {
        let (a, y) = from.split_once('.').unwrap();
        let (b, u) = to.split_once('.').unwrap();
        writeln!(
            self.connections,
            "<ssd:Connection startElement='{a}' startConnector='{y}' endElement='{b}' endConnector='{u}'/>"
        )
        .unwrap();
        self
    }

    pub(crate) fn master(mut self, attributes: &str) -> Self {
        self.annotation = format!(
            "<ssd:Annotations><ssc:Annotation type='cosim'><cosim:Master {attributes}/>\
             </ssc:Annotation></ssd:Annotations>"
        );
        self
    }

    pub(crate) fn stop(mut self, seconds: f64) -> Self {
        self.stop = seconds;
        self
    }

    pub(crate) fn text(&self) -> String {
        format!(
            "<?xml version='1.0' encoding='UTF-8'?>
<ssd:SystemStructureDescription version='1.0' name='test'
 xmlns:ssd='http://ssp-standard.org/SSP1/SystemStructureDescription'
 xmlns:ssc='http://ssp-standard.org/SSP1/SystemStructureCommon'
 xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues'
 xmlns:cosim='urn:cosim:1'>
<ssd:System name='test'><ssd:Elements>
{}</ssd:Elements><ssd:Connections>
{}</ssd:Connections></ssd:System>
<ssd:DefaultExperiment startTime='0' stopTime='{}'/>
{}</ssd:SystemStructureDescription>
",
            self.components, self.connections, self.stop, self.annotation
        )
    }

    /// Writes the file, which exists as long as `self`.
    pub(crate) fn write(&self) -> PathBuf {
        let file = self.folder.path().join("test.ssd");
        std::fs::write(&file, self.text()).unwrap();
        file
    }

    pub(crate) fn load(&self, overrides: &Overrides) -> Result<System, Error> {
        System::load(self.write(), overrides)
    }

    /// Runs it without changes.
    pub(crate) fn run(&self) -> Recording {
        run(&self.load(&Overrides::new()).unwrap())
    }
}

pub(crate) fn run(system: &System) -> Recording {
    let mut recording = Recording::new();
    system.run(&mut [&mut recording]).unwrap();
    recording
}

/// Compares columns of decimal numbers.
pub(crate) fn assert_near(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for (f, w) in found.iter().zip(wanted) {
        assert!((f - w).abs() < 1e-9, "{found:?} instead of {wanted:?}");
    }
}
