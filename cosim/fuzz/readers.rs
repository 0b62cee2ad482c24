//! The readers of strangers' files as functions of bytes: they may refuse, and must neither panic
//! nor take long nor write elsewhere. Shared by the fuzz targets and by the test that mutates good
//! files (`cosim/tests/all/mutations.rs`).

use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use cosim::fmi::{Fmu, archive, description};
use cosim::signals::{Signal, Signals};
use cosim::{Overrides, Recording, Snapshot, System};
use tempfile::TempDir;

/// An FMU in the shape of those that real systems use, without a binary: nothing is run.
pub const DESCRIPTION: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="tank" guid="{1}" numberOfEventIndicators="1">
  <ModelExchange modelIdentifier="tank" completedIntegratorStepNotNeeded="true"/>
  <CoSimulation modelIdentifier="tank" canGetAndSetFMUstate="true" maxOutputDerivativeOrder="1"/>
  <UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Mode"><Enumeration><Item name="Off" value="0"/><Item name="On" value="1"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <LogCategories><Category name="logAll"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.1" tolerance="1e-6"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0" unit="m"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real unit="m"/></ScalarVariable>
    <ScalarVariable name="der(y)" valueReference="2"><Real derivative="2"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="0" causality="input" variability="discrete"><Integer start="3"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="0" causality="parameter" variability="fixed"><Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="1" causality="parameter" variability="fixed"><Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="file" valueReference="0" causality="parameter" variability="fixed"><String start="a&lt;b"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies="1 4" dependenciesKind="dependent dependent"/></Outputs>
    <Derivatives><Unknown index="3"/></Derivatives>
  </ModelStructure>
</fmiModelDescription>
"#;

/// A system of two of them, with parameters of its own and of a file.
pub const SYSTEM: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="tanks"
 xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
 xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
 xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
  <ssd:System name="tanks">
    <ssd:Elements>
      <ssd:Component name="a" type="application/x-fmu-sharedlibrary" source="tank.fmu">
        <ssd:Connectors>
          <ssd:Connector name="u" kind="input"><ssc:Real unit="m"/></ssd:Connector>
          <ssd:Connector name="y" kind="output"><ssc:Real unit="m"/></ssd:Connector>
        </ssd:Connectors>
        <ssd:ParameterBindings>
          <ssd:ParameterBinding source="tank.ssv"/>
          <ssd:ParameterBinding><ssd:ParameterValues>
            <ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>
              <ssv:Parameter name="on"><ssv:Boolean value="false"/></ssv:Parameter>
              <ssv:Parameter name="mode"><ssv:Enumeration value="On"/></ssv:Parameter>
            </ssv:Parameters></ssv:ParameterSet>
          </ssd:ParameterValues></ssd:ParameterBinding>
        </ssd:ParameterBindings>
      </ssd:Component>
      <ssd:Component name="b" type="application/x-fmu-sharedlibrary" source="tank.fmu">
        <ssd:Connectors><ssd:Connector name="u" kind="input"><ssc:Real/></ssd:Connector></ssd:Connectors>
      </ssd:Component>
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startElement="a" startConnector="y" endElement="b" endConnector="u"/>
    </ssd:Connections>
  </ssd:System>
  <ssd:DefaultExperiment startTime="0" stopTime="1"/>
</ssd:SystemStructureDescription>
"#;

/// The parameters of that file.
pub const PARAMETERS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet version="1.0" name="tank"
 xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">
  <ssv:Parameters>
    <ssv:Parameter name="u"><ssv:Real value="1e-3"/></ssv:Parameter>
    <ssv:Parameter name="n"><ssv:Integer value="-7"/></ssv:Parameter>
    <ssv:Parameter name="file"><ssv:String value="x.csv"/></ssv:Parameter>
  </ssv:Parameters>
</ssv:ParameterSet>
"#;

/// The same system for OSP, with functions and groups of variables.
pub const STRUCTURE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<OspSystemStructure version="0.1" xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure">
  <StartTime>0.0</StartTime>
  <EndTime>1.0</EndTime>
  <BaseStepSize>0.1</BaseStepSize>
  <Algorithm>fixedStep</Algorithm>
  <Simulators>
    <Simulator name="a" source="tank.fmu" stepSize="0.2">
      <InitialValues>
        <InitialValue variable="n"><Integer value="-7"/></InitialValue>
        <InitialValue variable="on"><Boolean value="false"/></InitialValue>
        <InitialValue variable="file"><String value="x.csv"/></InitialValue>
      </InitialValues>
    </Simulator>
    <Simulator name="b" source="tank.fmu"/>
    <Simulator name="c" source="tank.fmu"/>
  </Simulators>
  <Functions>
    <LinearTransformation name="l" factor="2.0" offset="-1.0"/>
    <VectorSum name="v" inputCount="2" dimension="1"/>
  </Functions>
  <Connections>
    <VariableConnection><Variable simulator="a" name="y"/><Variable simulator="b" name="u"/></VariableConnection>
    <SignalConnection><Variable simulator="a" name="y"/><Signal function="l" name="in"/></SignalConnection>
    <SignalConnection><Variable simulator="a" name="u"/><Signal function="l" name="out"/></SignalConnection>
    <SignalGroupConnection><VariableGroup simulator="a" name="port"/><SignalGroup function="v" name="in[0]"/></SignalGroupConnection>
    <SignalGroupConnection><VariableGroup simulator="b" name="port"/><SignalGroup function="v" name="in[1]"/></SignalGroupConnection>
    <SignalConnection><Variable simulator="c" name="u"/><Signal function="v" name="out[0]"/></SignalConnection>
  </Connections>
</OspSystemStructure>
"#;

/// The groups of its variables.
pub const GROUPS: &str = r#"<OspModelDescription version="1.0"
 xmlns="https://open-simulation-platform.com/OspModelDescription/1.0.0">
  <VariableGroups>
    <Generic name="port"><Force name="out"><Variable ref="y"/></Force></Generic>
  </VariableGroups>
</OspModelDescription>
"#;

/// What is recorded of it.
pub const LOG_CONFIG: &str = r#"<simulators xmlns="http://opensimulationplatform.com/LogConfig">
  <simulator name="a" decimationFactor="10"><variable name="y"/></simulator>
  <simulator name="b"/>
</simulators>
"#;

/// Recorded signals.
pub const TABLE: &str = "time,a.y,\"b[1,2]\"\n0.0,1,True\n1e-3, 2.5,false\n0.002,-1e300,0\n";

/// Archives are unpacked, and what was unpacked is looked at.
pub fn archive(bytes: &[u8]) {
    let Ok(unpacked) = archive::unpack_from(Cursor::new(bytes), Path::new("x.fmu")) else {
        return;
    };
    inside(unpacked.path(), 0);
}

/// Only plain files and folders.
fn inside(folder: &Path, depth: usize) {
    assert!(depth <= 32);
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let kind = entry.file_type().unwrap();
        assert!(kind.is_dir() || kind.is_file(), "{}", entry.path().display());
        if kind.is_dir() {
            inside(&entry.path(), depth + 1);
        }
    }
}

/// Descriptions are read, and what was read is asked.
pub fn description(bytes: &[u8]) {
    let Ok(read) = description::parse(bytes, Path::new("x.fmu/modelDescription.xml")) else {
        return;
    };
    for (position, variable) in read.variables.iter().enumerate() {
        assert_eq!(read.position(&variable.name), Some(position));
        if read.variables.len() < 1000 {
            read.feeds_through(position);
        }
    }
    for output in &read.outputs {
        let named = output.dependencies.iter().flatten().chain([&output.variable]);
        assert!(named.clone().all(|&position| position < read.variables.len()));
    }
}

const GROUPS_FILE: &str = "tank_OspModelDescription.xml";

/// A folder with an FMU, used again and again; the FMU stays open, so it is unpacked once.
fn folder() -> &'static TempDir {
    static FOLDER: OnceLock<(TempDir, Arc<Fmu>)> = OnceLock::new();
    let (folder, _) = FOLDER.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let file = folder.path().join("tank.fmu");
        std::fs::write(&file, fmu()).unwrap();
        std::fs::write(folder.path().join("tank.ssv"), PARAMETERS).unwrap();
        std::fs::write(folder.path().join(GROUPS_FILE), GROUPS).unwrap();
        (folder, Fmu::open(&file).unwrap())
    });
    folder
}

/// The FMU.
pub fn fmu() -> Vec<u8> {
    zip(&[("modelDescription.xml", DESCRIPTION.as_bytes()), ("resources/x.csv", b"1")])
}

/// A package of the system.
pub fn package() -> Vec<u8> {
    zip(&[
        ("SystemStructure.ssd", SYSTEM.as_bytes()),
        ("tank.fmu", &fmu()),
        ("tank.ssv", PARAMETERS.as_bytes()),
    ])
}

fn zip(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn load(name: &str, bytes: &[u8]) {
    let file = folder().path().join(name);
    std::fs::write(&file, bytes).unwrap();
    if let Ok(system) = System::load(&file, &Overrides::new()) {
        assert!(system.components().iter().all(|component| !component.name.is_empty()));
    }
}

/// Systems are read and checked.
pub fn ssd(bytes: &[u8]) {
    load("fuzzed.ssd", bytes);
}

/// OSP structures with the files that belong to them: the three texts follow one another, each
/// from its root element on.
pub fn osp(bytes: &[u8]) {
    let (structure, rest) = split(bytes, b"<OspModelDescription");
    let (groups, log_config) = split(rest, b"<simulators");
    let own = folder().path().join("osp");
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(own.join(GROUPS_FILE), groups).unwrap();
    std::fs::write(own.join("LogConfig.xml"), log_config).unwrap();
    let _ = std::fs::hard_link(folder().path().join("tank.fmu"), own.join("tank.fmu"));
    load("osp/OspSystemStructure.xml", structure);
}

/// The three texts as one.
pub fn structure() -> Vec<u8> {
    [STRUCTURE, GROUPS, LOG_CONFIG].concat().into_bytes()
}

fn split<'a>(bytes: &'a [u8], at: &[u8]) -> (&'a [u8], &'a [u8]) {
    let found = bytes.windows(at.len()).position(|window| window == at);
    bytes.split_at(found.unwrap_or(bytes.len()))
}

/// Packages are unpacked, read and checked.
pub fn ssp(bytes: &[u8]) {
    load("fuzzed.ssp", bytes);
}

/// Parameters are read by a good system.
pub fn ssv(bytes: &[u8]) {
    std::fs::write(folder().path().join("fuzzed.ssv"), bytes).unwrap();
    load("good.ssd", SYSTEM.replace("tank.ssv", "fuzzed.ssv").as_bytes());
}

/// Tables are read, written, read again the same, and used as signals.
pub fn csv(bytes: &[u8]) {
    let (file, again) = (folder().path().join("fuzzed.csv"), folder().path().join("again.csv"));
    std::fs::write(&file, bytes).unwrap();
    let Ok(read) = Recording::read_csv(&file) else { return };
    read.write_csv(&again).unwrap();
    let twice = Recording::read_csv(&again).expect("what was written can be read");
    assert_eq!(twice.time().len(), read.time().len());
    let signals = read.columns().map(|(name, values)| Signal {
        name: name.to_owned(),
        kind: cosim::fmi::Kind::Real,
        continuous: true,
        values: values.to_vec(),
    });
    drop(Signals::new(read.time(), signals.collect()));
}

/// Results as MCAP.
pub fn mcap(bytes: &[u8]) {
    let file = folder().path().join("fuzzed.mcap");
    std::fs::write(&file, bytes).unwrap();
    if let Ok(read) = Recording::read(&file) {
        assert!(read.columns().all(|(_, column)| column.len() == read.time().len()));
    }
}

/// A message of a distributed run: a step with a part and values.
pub fn step() -> Vec<u8> {
    let head = [0xC5, 1, 6, 3, 1, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
    let values = [0.5_f64, -0.0, 1e300, f64::NAN].map(f64::to_le_bytes).concat();
    [&head[..], &[0; 16], &2_u32.to_le_bytes(), &values].concat()
}

/// Messages between the processes of a distributed run.
pub fn message(bytes: &[u8]) {
    cosim::distributed::decode(bytes);
}

/// Snapshots of runs.
pub fn snapshot(bytes: &[u8]) {
    let file = folder().path().join("fuzzed.snapshot");
    std::fs::write(&file, bytes).unwrap();
    drop(Snapshot::read(&file).map(|snapshot| snapshot.time()));
}
