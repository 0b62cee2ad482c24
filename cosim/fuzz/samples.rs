//! Valid files for the readers of untrusted files: the seeds of the fuzz targets, and the files
//! that the test mutates.

use std::io::{Cursor, Write};
use std::path::Path;

use cosim::fmi::Message;
use cosim::fmi::calls::{Ask, Given, Outcome, Values};
use cosim::hosted::Hosted;
use cosim::proxy::frames::{self, Reply, Request};
use cosim::{Overrides, Result, Run, Snapshot, System, Time};

/// An FMU shaped like those in real systems, without a binary: nothing is run.
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

/// A system of two of them, with inline parameters and parameters from a file.
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

/// The recorded variables of it.
pub const LOG_CONFIG: &str = r#"<simulators xmlns="http://opensimulationplatform.com/LogConfig">
  <simulator name="a" decimationFactor="10"><variable name="y"/></simulator>
  <simulator name="b"/>
</simulators>
"#;

/// A mapping of the parameters.
pub const MAPPING: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<ssm:ParameterMapping version="1.0"
 xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
 xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
  <ssm:MappingEntry source="u" target="u"><ssc:LinearTransformation factor="2" offset="1"/></ssm:MappingEntry>
  <ssm:MappingEntry source="n" target="n">
    <ssc:IntegerMappingTransformation><ssc:MapEntry source="-7" target="1"/></ssc:IntegerMappingTransformation>
  </ssm:MappingEntry>
</ssm:ParameterMapping>
"#;

/// A signal dictionary.
pub const DICTIONARY: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<ssb:SignalDictionary version="1.0"
 xmlns:ssb="http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
 xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
  <ssb:DictionaryEntry name="level"><ssc:Real unit="m"/></ssb:DictionaryEntry>
  <ssb:DictionaryEntry name="on"><ssc:Boolean/></ssb:DictionaryEntry>
  <ssb:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit></ssb:Units>
</ssb:SignalDictionary>
"#;

/// A system of functions alone.
pub const SUM: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<OspSystemStructure version="0.1" xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure">
  <StartTime>0.0</StartTime>
  <EndTime>1.0</EndTime>
  <BaseStepSize>0.1</BaseStepSize>
  <Simulators/>
  <Functions><Sum name="s" inputCount="2"/><VectorSum name="v" inputCount="2" dimension="2"/></Functions>
</OspSystemStructure>
"#;

/// The variables of that system in an exported FMU (`interface.bin`, as `cosim export` writes it).
pub const INTERFACE: &[u8] = include_bytes!("sum.bin");

/// What a remote FMU says about itself.
pub const REMOTE: &str = r#"{
  "version": 1,
  "guid": "{2}",
  "fmu": "tank.fmu",
  "sha256": "00",
  "can_save": true,
  "derivative": false,
  "outputs": [1],
  "inputs": [[0], [0], [], []]
}
"#;

/// What an FMU of a Python class says about itself.
pub const CLASS: &str = r#"{
  "version": 1,
  "guid": "{3}",
  "class": "Tank",
  "python": "/usr/bin/python3",
  "rate": 10.0,
  "inputs": ["u"],
  "outputs": ["y"],
  "parameters": [{"name": "area", "type": "Real", "start": 1.5}]
}
"#;

/// Faults.
pub const FAULTS: &str = r#"[[fault]]
kind = "drop-out"
on = ["gps.position.x", "gps.stamp"]
from = 30
for = 30

[[fault]]
kind = "gauss-markov"
on = "dvl.velocity.?"
sigma = 0.01
tau = 20
"#;

/// Roles of variables.
pub const ROLES: &str = r#"axes = "enu"

[truth]
pose = "vehicle.pose"
velocity = "vehicle.velocity"

[estimates.navigation]
pose = { x = "filter.pose.x", y = "filter.pose.y", yaw = "filter.pose.yaw" }
sigma = { x = "filter.sigma.x", y = "filter.sigma.y", yaw = "filter.sigma.yaw" }
covariance = { x_y = "filter.covariance.x_y" }

[courses.leg]
position = "pursuit.target"

[sensors.log]
velocity = "dvl.velocity"
stamp = "dvl.stamp"
valid = "dvl.valid"
"#;

/// Recorded signals.
pub const TABLE: &str = "time,a.y,\"b[1,2]\"\n0.0,1,True\n1e-3, 2.5,false\n0.002,-1e300,0\n";

/// The three texts concatenated.
pub fn structure() -> Vec<u8> {
    [STRUCTURE, GROUPS, LOG_CONFIG].concat().into_bytes()
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

/// An archive of these files.
pub fn zip(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// The system of functions, described in a folder.
pub fn functions(folder: &Path) -> Result<System> {
    let file = folder.join("OspSystemStructure.xml");
    std::fs::write(&file, SUM).unwrap();
    System::load(&file, &Overrides::new())
}

const HALF: Time = Time::from_ns(500_000_000);

/// A snapshot of a run of it.
pub fn state_of_functions(folder: &Path) -> Vec<u8> {
    let file = folder.join("sum.snapshot");
    let mut keep = |snapshot: Snapshot| snapshot.write(&file);
    let system = functions(folder).unwrap();
    Run::new(&system).snapshots(None, &[HALF], &mut keep).go().unwrap();
    std::fs::read(&file).unwrap()
}

/// The same system as in an exported FMU with these variables, and this folder as its resources.
pub fn hosted(folder: &Path, interface: &[u8]) -> Result<Hosted> {
    functions(folder)?;
    std::fs::write(folder.join("interface.bin"), interface).unwrap();
    Hosted::open(folder, false)
}

/// Its first half second.
pub fn begin(system: &mut Hosted) -> Result<()> {
    system.enter(Time::ZERO, Time::NEVER, None)?;
    system.exit()?;
    system.advance(HALF)
}

/// The state after that.
pub fn state_of_hosted(folder: &Path) -> Vec<u8> {
    let mut system = hosted(folder, INTERFACE).unwrap();
    begin(&mut system).unwrap();
    postcard::to_stdvec(&system.save().unwrap()).unwrap()
}

/// What the library of a remote FMU asks, and the answers.
pub fn frames() -> Vec<Vec<u8>> {
    let make = Request::Make { resources: "/tmp/r".into(), name: "tank".to_owned(), debug: true };
    let set = Ask::Set(vec![0], Values::Real(vec![0.5]));
    let calls = Request::Calls(vec![set, Ask::Step(0.0, 0.1), Ask::Restore(vec![1, 2, 3])]);
    let given = vec![Given::Done, Given::Values(Values::Real(vec![1.5])), Given::State(vec![4])];
    let text = |text: &str| text.to_owned();
    let said =
        Message { instance: text("tank"), status: 1, category: text("logAll"), text: text("dry") };
    let done = Reply::Done(Outcome { given, trouble: None }, vec![said], vec![text("again")]);
    let mut both = [Vec::new(), Vec::new()];
    for request in [make, calls] {
        frames::write(&mut both[0], &request).unwrap();
    }
    for reply in [Reply::Working, done, Reply::Lost(text("gone"))] {
        frames::write(&mut both[1], &reply).unwrap();
    }
    both.into()
}

/// A message of a distributed run: a step with a part and values.
pub fn step() -> Vec<u8> {
    let head = [0xC5, 1, 6, 3, 1, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
    let values = [0.5_f64, -0.0, 1e300, f64::NAN].map(f64::to_le_bytes).concat();
    [&head[..], &[0; 16], &2_u32.to_le_bytes(), &values].concat()
}
