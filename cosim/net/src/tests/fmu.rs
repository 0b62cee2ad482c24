//! FMUs that share one library but have different descriptions, compiled and packed on the fly.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// How the FMU behaves and what it declares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Nature {
    /// No output depends directly on an input.
    State,
    /// y = x + k u.
    Through,
    /// Model exchange.
    Exchange,
    /// As `State`, but its state cannot be serialized.
    Mute,
    /// As `State`, but not deterministic.
    Chaos,
}

/// The packed FMU, made once per process: equal FMUs are opened once and keep their first path.
pub(super) fn fmu(nature: Nature) -> PathBuf {
    static MADE: Mutex<Option<TempDir>> = Mutex::new(None);
    let mut made = MADE.lock().unwrap();
    let folder = made.get_or_insert_with(|| {
        let folder = TempDir::new().unwrap();
        compile(folder.path());
        folder
    });
    let path = folder.path().join(format!("{nature:?}.fmu"));
    if !path.exists() {
        pack(folder.path(), nature);
    }
    path
}

/// Packs an FMU into `folder`, which contains its library as `m.so`.
fn pack(folder: &Path, nature: Nature) {
    let path = folder.join(format!("{nature:?}.fmu"));
    let mut zip = ZipWriter::new(std::fs::File::create(&path).unwrap());
    let library = std::fs::read(folder.join("m.so")).unwrap();
    let entries = [
        ("modelDescription.xml", description(nature).into_bytes()),
        ("binaries/linux64/m.so", library),
    ];
    for (name, bytes) in entries {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap();
}

/// Compiles the library into `folder`.
fn compile(folder: &Path) {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/src/tests/fmu.c");
    let done = Command::new("cc")
        .args(["-O2", "-ffp-contract=off", "-shared", "-fPIC", "-w", "-o"])
        .arg(folder.join("m.so"))
        .arg(source)
        .status()
        .expect("a C compiler named cc");
    assert!(done.success());
}

fn description(nature: Nature) -> String {
    let through = u8::from(nature == Nature::Through);
    let chaos = u8::from(nature == Nature::Chaos);
    let direct = if through == 1 { "1" } else { "" };
    let states = "canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"";
    let kind = match nature {
        Nature::Exchange => format!("<ModelExchange modelIdentifier=\"m\" {states}/>"),
        Nature::Mute => "<CoSimulation modelIdentifier=\"m\"/>".to_owned(),
        _ => format!("<CoSimulation modelIdentifier=\"m\" {states}/>"),
    };
    let derivatives = match nature {
        Nature::Exchange => "<Derivatives><Unknown index=\"7\"/></Derivatives>",
        _ => "",
    };
    let fixed = "causality=\"parameter\" variability=\"fixed\"";
    let variables = [
        ("u", "causality=\"input\"", "start=\"0\"".to_owned()),
        ("v", "causality=\"input\"", "start=\"0\"".to_owned()),
        ("y", "causality=\"output\"", String::new()),
        ("k", fixed, "start=\"0.4\"".to_owned()),
        ("through", fixed, format!("start=\"{through}\"")),
        ("x", "initial=\"exact\"", "start=\"0.1\"".to_owned()),
        ("der(x)", "", "derivative=\"6\"".to_owned()),
        ("chaos", fixed, format!("start=\"{chaos}\"")),
    ];
    let variables: String = variables
        .iter()
        .enumerate()
        .map(|(reference, (name, of, real))| {
            format!(
                "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\" {of}>\
                 <Real {real}/></ScalarVariable>\n"
            )
        })
        .collect();
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="m" guid="{nature:?}" numberOfEventIndicators="0">
{kind}
<DefaultExperiment startTime="0" stopTime="1" stepSize="0.1"/>
<ModelVariables>
{variables}</ModelVariables>
<ModelStructure><Outputs><Unknown index="3" dependencies="{direct}"/></Outputs>{derivatives}</ModelStructure>
</fmiModelDescription>
"#
    )
}
