//! FMUs written in C (model.c: co-simulation, exchange.c: model exchange), compiled by `cc` and packed on the fly.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A model: its name and whether y depends on u without delay.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Model {
    /// y = k u, feed-through.
    Gain,
    /// y += u h, y(0) = second; no feed-through.
    Integrator,
    /// y = time; u is ignored.
    Clock,
    /// y = number of steps; Integer n = steps + m, Boolean even = !odd.
    Counter,
    /// y = k u + time, feed-through.
    Affine,
    /// y = time - k u^3, feed-through.
    Cubic,
    /// A gain that fails in the first step that ends after `second`.
    Failing,
    /// A gain that in its first step writes to $HOME, connects to 127.0.0.1 at the port k and
    /// writes to its temporary folder, and logs the results.
    Nosy,
    /// A gain that logs in three formats and dies in its third step.
    Logging,
    /// y'' = second u - k y, y(0) = m; no feed-through; interpolates u and gives y'.
    Mass,
    /// x'' = u - k x, x(0) = second; y = x'', feed-through; interpolates u and gives y'.
    Inertia,
    /// An integrator that discards steps longer than second, of which it completes a half, or with
    /// m = 1 nothing; with m = 2 it ends the run at second.
    Picky,
    /// Model exchange: height y, falls from 1 m, keeps k of its speed; n bounces.
    Ball,
    /// Model exchange: n time events, every k seconds from the start on; even = (m is not 0).
    Ticker,
    /// Model exchange: x'' = -400 x from 1, and s' = -500 (s - sin t) + cos t from 0.
    Oscillator,
    /// Model exchange: x' = 1, set back by 1 by a step event; n of them. Ends the run
    /// after m, if that is not 0.
    Sawtooth,
    /// Model exchange: x' = u - k x; n counts its events, the indicator is u - 0.5.
    Lag,
}

impl Model {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Model::Gain => "GAIN",
            Model::Integrator => "INTEGRATOR",
            Model::Clock => "CLOCK",
            Model::Counter => "COUNTER",
            Model::Affine => "AFFINE",
            Model::Cubic => "CUBIC",
            Model::Failing => "FAILING",
            Model::Nosy => "NOSY",
            Model::Logging => "LOGGING",
            Model::Mass => "MASS",
            Model::Inertia => "INERTIA",
            Model::Picky => "PICKY",
            Model::Ball => "BALL",
            Model::Ticker => "TICKER",
            Model::Oscillator => "OSCILLATOR",
            Model::Sawtooth => "SAWTOOTH",
            Model::Lag => "LAG",
        }
    }

    fn feeds_through(self) -> bool {
        use Model::{Affine, Cubic, Failing, Gain, Inertia, Logging, Nosy};
        matches!(self, Gain | Affine | Cubic | Inertia | Failing | Nosy | Logging)
    }

    /// States and event indicators, for model exchange.
    fn exchange(self) -> Option<(usize, usize)> {
        match self {
            Model::Ball => Some((2, 1)),
            Model::Ticker => Some((0, 0)),
            Model::Oscillator => Some((3, 0)),
            Model::Sawtooth => Some((1, 0)),
            Model::Lag => Some((1, 1)),
            _ => None,
        }
    }

    pub(crate) fn description(self) -> String {
        match self.exchange() {
            Some((states, indicators)) => self.of_exchange(states, indicators),
            None => self.of_co_simulation(),
        }
    }

    fn of_exchange(self, states: usize, indicators: usize) -> String {
        let name = self.name();
        let unknowns = (0..states).map(|s| format!("<Unknown index=\"{}\"/>", 5 + 2 * s));
        let unknowns = match states {
            0 => String::new(),
            _ => format!("<Derivatives>{}</Derivatives>", unknowns.collect::<String>()),
        };
        let derivative = |state: usize, of: u32| match state < states {
            true => format!("><Real derivative=\"{of}\""),
            false => "><Real".to_owned(),
        };
        let start = self.start_of_x();
        let real = |name: &str, reference: u32, inside: &str| {
            format!(
                "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\" {inside}/>\
                 </ScalarVariable>\n"
            )
        };
        let variables = [
            real("u", 0, "causality=\"input\"><Real start=\"0\""),
            real("k", 1, "causality=\"parameter\" variability=\"fixed\"><Real start=\"0.5\""),
            real("y", 2, "causality=\"output\"><Real"),
            real("x", 3, &format!("initial=\"exact\"><Real start=\"{start}\"")),
            real("der(x)", 4, &derivative(0, 4)),
            real("v", 5, "initial=\"exact\"><Real start=\"0\""),
            real("der(v)", 6, &derivative(1, 6)),
            real("s", 7, "initial=\"exact\"><Real start=\"0\""),
            real("der(s)", 8, &derivative(2, 8)),
            real("m", 0, "causality=\"input\" variability=\"discrete\"><Integer start=\"0\""),
            real("n", 1, "causality=\"output\" variability=\"discrete\"><Integer"),
            real("odd", 0, "causality=\"input\" variability=\"discrete\"><Boolean start=\"false\""),
            real("even", 1, "causality=\"output\" variability=\"discrete\"><Boolean"),
        ];
        format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{{test}}" numberOfEventIndicators="{indicators}">
  <ModelExchange modelIdentifier="{name}" canGetAndSetFMUstate="true" canSerializeFMUstate="true"/>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/>
  <ModelVariables>
{}  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="3" dependencies="4"/><Unknown index="11" dependencies=""/><Unknown index="13" dependencies=""/></Outputs>
    {unknowns}
  </ModelStructure>
</fmiModelDescription>
"#,
            variables.concat()
        )
    }

    /// x at the start.
    fn start_of_x(self) -> u8 {
        u8::from(matches!(self, Model::Ball | Model::Oscillator))
    }

    fn of_co_simulation(self) -> String {
        let name = self.name();
        let interpolates = " canInterpolateInputs=\"true\" maxOutputDerivativeOrder=\"1\"";
        let abilities = match self {
            Model::Mass | Model::Inertia => interpolates,
            _ => "",
        };
        let dependencies = if self.feeds_through() { "1" } else { "" };
        format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{{test}}" generationTool="cc">
  <CoSimulation modelIdentifier="{name}" canGetAndSetFMUstate="true" canSerializeFMUstate="true" canHandleVariableCommunicationStepSize="true"{abilities}/>
  <TypeDefinitions>
    <SimpleType name="Mode"><Enumeration><Item name="Slow" value="1"/><Item name="Fast" value="4"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0" unit="m"/></ScalarVariable>
    <ScalarVariable name="k" valueReference="1" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real unit="m"/></ScalarVariable>
    <ScalarVariable name="second" valueReference="3" causality="parameter" variability="fixed"><Real start="1e9"/></ScalarVariable>
    <ScalarVariable name="m" valueReference="0" causality="input" variability="discrete"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="odd" valueReference="0" causality="input" variability="discrete"><Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="even" valueReference="1" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="text" valueReference="0" causality="parameter" variability="fixed"><String start=""/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="2" causality="parameter" variability="fixed"><Enumeration declaredType="Mode" start="1"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="3" dependencies="{dependencies}"/>
      <Unknown index="6" dependencies="5"/>
      <Unknown index="8" dependencies="7"/>
    </Outputs>
  </ModelStructure>
</fmiModelDescription>
"#
        )
    }

    /// An FMU of this model compiled with `defines`, its description changed by `change`.
    pub(crate) fn variant(
        self,
        archive: &Path,
        defines: &[&str],
        change: impl Fn(String) -> String,
    ) -> PathBuf {
        let library = archive.with_extension("so");
        compile_into(self, &library, defines, &[]);
        let binary = format!("binaries/linux64/{}.so", self.name());
        let description = change(self.description()).into_bytes();
        let library = std::fs::read(library).unwrap();
        pack(archive, &[("modelDescription.xml", description), (&binary, library)]);
        archive.to_owned()
    }

    /// Another FMU of this model: with a part of its description replaced.
    pub(crate) fn varied(self, folder: &Path, from: &str, to: &str) -> PathBuf {
        let archive = folder.join(format!("varied_{}.fmu", self.name()));
        self.variant(&archive, &[], |description| {
            assert!(description.contains(from), "{from}");
            description.replace(from, to)
        })
    }

    /// The packed FMU, made once per test process.
    pub(crate) fn fmu(self) -> PathBuf {
        static MADE: Mutex<BTreeMap<Model, PathBuf>> = Mutex::new(BTreeMap::new());
        let mut made = MADE.lock().unwrap();
        made.entry(self)
            .or_insert_with(|| {
                let path = folder().join(format!("{}.fmu", self.name()));
                let unfinished = folder().join(format!("{}.{}", self.name(), std::process::id()));
                let library = std::fs::read(compile(self)).unwrap();
                let binary = format!("binaries/linux64/{}.so", self.name());
                let entries =
                    [("modelDescription.xml", self.description().into_bytes()), (&binary, library)];
                pack(&unfinished, &entries);
                std::fs::rename(&unfinished, &path).unwrap();
                path
            })
            .clone()
    }
}

fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("models");
        std::fs::create_dir_all(&folder).unwrap();
        folder
    })
}

/// Compiles a model into a shared library, once per test process.
pub(crate) fn compile(model: Model) -> PathBuf {
    static MADE: Mutex<BTreeMap<Model, PathBuf>> = Mutex::new(BTreeMap::new());
    let mut made = MADE.lock().unwrap();
    made.entry(model).or_insert_with(|| compile_now(model)).clone()
}

fn compile_now(model: Model) -> PathBuf {
    let library = folder().join(format!("{}.so", model.name()));
    // Another test process may be reading the library: it is replaced as a whole.
    let unfinished = folder().join(format!("{}.so.{}", model.name(), std::process::id()));
    compile_into(model, &unfinished, &[], &[]);
    std::fs::rename(&unfinished, &library).unwrap();
    library
}

/// Compiles a model, linked with `more`.
pub(crate) fn compile_into(model: Model, library: &Path, defines: &[&str], more: &[&str]) {
    let source = if model.exchange().is_some() { "exchange.c" } else { "model.c" };
    let done = Command::new("cc")
        .args(["-O2", "-shared", "-fPIC", "-w", "-o"])
        .arg(library)
        .arg(format!("-DMODEL_{}", model.name()))
        .arg(format!("-DX0={}", model.start_of_x()))
        .args(defines.iter().map(|define| format!("-D{define}")))
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all").join(source))
        .args(more)
        .args(["-lm", "-lpthread"])
        .status()
        .expect("a C compiler named cc");
    assert!(done.success());
}

/// Writes an archive whose bytes follow from its entries alone: another test process may replace an
/// FMU while a run delivers it.
pub(crate) fn pack(archive: &Path, entries: &[(&str, Vec<u8>)]) {
    let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
    let mut zip = ZipWriter::new(std::fs::File::create(archive).unwrap());
    for (name, bytes) in entries {
        zip.start_file(*name, options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}
