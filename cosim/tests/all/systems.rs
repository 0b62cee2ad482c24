//! System descriptions: reported problems, and the effect of overrides.

use cosim::{Overrides, System};

use crate::command;
use crate::models::{Model, pack};
use crate::ssd::{Ssd, assert_near, run};

fn two() -> Ssd {
    Ssd::new().add("clock", Model::Clock).add("gain", Model::Gain).connect("clock.y", "gain.u")
}

fn error_of(text: &str, overrides: &Overrides) -> String {
    let folder = tempfile::TempDir::new().unwrap();
    let file = folder.path().join("test.ssd");
    std::fs::write(&file, text).unwrap();
    System::load(&file, overrides).err().map_or("none".to_owned(), |e| e.to_string())
}

#[track_caller]
fn assert_parts(error: &str, parts: &[&str]) {
    for part in parts {
        assert!(error.contains(part), "'{part}' is not in:\n{error}");
    }
}

#[test]
fn wrong_files_are_reported_with_line_and_remedy() {
    let text = two().text();
    let none = Overrides::new();
    for (from, to, parts) in [
        ("startConnector='y'", "startConnector='yy'", &["test.ssd:33", "'yy'", "'y'?"][..]),
        ("startElement='clock'", "startElement='clok'", &["test.ssd:33", "'clock'?"]),
        ("startConnector='y'", "startConnector='u'", &["'clock.u' is not an output"]),
        ("endConnector='u'", "endConnector='y'", &["'gain.y' is not an input"]),
        (
            "endConnector='u'",
            "endConnector='k'",
            &["lists no connector 'k'", "<ssd:Connector name=\"k\""],
        ),
        ("endConnector='u'", "endConnector='m'", &["joins Real and Integer"]),
        ("name='u' kind='input'", "name='u' kind='output'", &[":10", "write kind=\"input\""]),
        (
            "name='u' kind='input'><ssc:Real/>",
            "name='u' kind='input'><ssc:Integer/>",
            &["write <ssc:Real/>"],
        ),
        ("CLOCK.fmu", "missing.fmu", &["E101", "FMU of 'clock'", "missing.fmu"]),
        ("version='1.0' name='test'", "version='7' name='test'", &["'7'"]),
        ("stopTime='1'", "stopTime='0'", &["E205", "from 0 s to 0 s"]),
        ("stopTime='1'", "stopTime='soon'", &["stopTime=\"soon\""]),
        ("<ssd:Connections>", "<ssd:Connections><ssd:Wire/>", &["<Wire> among connections"]),
        (
            "</ssd:Elements>",
            "<ssd:SignalDictionaryReference name='d' dictionary='x'/></ssd:Elements>",
            &["E202", "no signal dictionary 'x'"],
        ),
        (
            "endConnector='u'/>",
            "endConnector='u'><ssc:LinearTransformation factor='two'/></ssd:Connection>",
            &[":33", "factor=\"two\""],
        ),
        (
            "<ssd:Connections>",
            "<ssd:Extra/><ssd:Connections>",
            &["E201", ":32", "<Extra> in <System>"],
        ),
        ("</ssd:System>", "", &["E103"]),
        ("SSP1/SystemStructureDescription'", "elsewhere'", &["root element"]),
    ] {
        assert!(text.contains(from), "{from}");
        assert_parts(&error_of(&text.replacen(from, to, 1), &none), parts);
    }
}

#[test]
fn all_problems_are_reported_at_once() {
    let ssd = two().connect("clock.y", "gain.u").connect("gain.y", "clock.uu").add_with(
        "gain",
        Model::Gain,
        &[("kk", 1.0), ("y", 1.0)],
        None,
    );
    let error = ssd.load(&Overrides::new()).err().unwrap();
    assert_eq!(error.problems().count(), 5, "{error}");
    assert_parts(
        &error.to_string(),
        &[
            "two drivers",
            "on line",
            "two components are named 'gain'",
            "'uu'",
            "'kk'",
            "computes it",
        ],
    );
}

#[test]
fn overrides_are_checked_like_the_file() {
    let text = two().text();
    for (overrides, parts) in [
        (Overrides::new().start_value("gain.kk", 1), &["'kk'", "did you mean 'k'?"][..]),
        (Overrides::new().start_value("gian.k", 1), &["no component 'gian'", "'gain'?"]),
        (Overrides::new().start_value("k", 1), &["component.variable"]),
        (Overrides::new().start_value("gain.k", "much"), &["'much' is not a finite Real"]),
        (Overrides::new().start_value("gain.y", 1), &["causality is output"]),
        (Overrides::new().start_value("gain.mode", "Fats"), &["'Fast'?"]),
        (Overrides::new().step("gain", 0.0), &["step of 'gain' is 0 s"]),
        (Overrides::new().step("gian", 0.1), &["'gain'?"]),
        (Overrides::new().replace("gian", "x.fmu"), &["'gain'?"]),
        (Overrides::new().replace("gain", "x.fmu"), &["E101", "x.fmu"]),
        (Overrides::new().output_interval(0.05), &["use 0.1 s or a multiple"]),
        (Overrides::new().output_interval(-1.0), &["at least one nanosecond"]),
        (Overrides::new().output_variable("gain.z*"), &["matches no variable"]),
        (Overrides::new().stop_time(f64::NAN), &["NaN"]),
    ] {
        assert_parts(&error_of(&text, &overrides), parts);
    }
}

#[test]
fn overrides_take_effect() {
    let overrides = Overrides::new()
        .start_value("gain.k", 2.5)
        .start_value("gain.mode", "Fast")
        .step("clock", 0.2)
        .stop_time(0.4)
        .output_interval(0.2)
        .output_variables(["gain.y", "gain.mode", "gain.y"]);
    let results = run(&two().load(&overrides).unwrap());
    assert_eq!(results.names(), ["gain.y", "gain.mode"]);
    assert_near(results.column("gain.y").unwrap(), &[0.0, 0.5, 1.0]);
    assert_near(results.column("gain.mode").unwrap(), &[4.0; 3]);
}

#[test]
fn an_unknown_attribute_is_a_warning() {
    let text = two().text().replacen(
        "<ssd:Component name='gain'",
        "<ssd:Component sorce='x' name='gain'",
        1,
    );
    let folder = tempfile::TempDir::new().unwrap();
    let file = folder.path().join("test.ssd");
    std::fs::write(&file, text).unwrap();
    let system = System::load(&file, &Overrides::new()).unwrap();
    assert_parts(&system.warnings().join("\n"), &["'sorce'", "did you mean 'source'?"]);
}

#[test]
fn a_replacement_without_an_input_loses_the_connection_with_a_warning() {
    let folder = tempfile::TempDir::new().unwrap();
    let description = Model::Gain.description();
    let without = |name: &str| {
        let path = folder.path().join(format!("no-{name}.fmu"));
        let changed = description.replace(&format!("name=\"{name}\""), "name=\"other\"");
        let library = std::fs::read(crate::models::compile(Model::Gain)).unwrap();
        pack(
            &path,
            &[
                ("modelDescription.xml", changed.into_bytes()),
                ("binaries/linux64/GAIN.so", library),
            ],
        );
        path
    };
    let ssd = two().add("last", Model::Gain).connect("gain.y", "last.u");
    let system = ssd.load(&Overrides::new().replace("gain", without("u"))).unwrap();
    assert_parts(&system.warnings()[0], &["clock.y -> gain.u is dropped"]);
    assert_eq!(system.connections().len(), 1);
    let error = ssd.load(&Overrides::new().replace("gain", without("y"))).err().unwrap();
    assert_parts(&error.to_string(), &["E206", "no output 'y'", "last.u"]);
}

#[test]
fn a_package_runs_like_the_file() {
    let folder = tempfile::TempDir::new().unwrap();
    let file = folder.path().join("x.ssp");
    let ssd = two();
    let fmu = |model: Model| std::fs::read(model.fmu()).unwrap();
    let text = ssd
        .text()
        .replace(&Model::Clock.fmu().display().to_string(), "resources/clock.fmu")
        .replace(&Model::Gain.fmu().display().to_string(), "resources/gain.fmu");
    pack(
        &file,
        &[
            ("SystemStructure.ssd", text.into_bytes()),
            ("resources/clock.fmu", fmu(Model::Clock)),
            ("resources/gain.fmu", fmu(Model::Gain)),
        ],
    );
    let system = System::load(&file, &Overrides::new()).unwrap();
    assert_eq!(run(&system), ssd.run());
}

#[test]
fn parameters_of_the_system_and_of_files() {
    let folder = tempfile::TempDir::new().unwrap();
    std::fs::write(
        folder.path().join("values.ssv"),
        "<ssv:ParameterSet xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues' \
         version='1.0' name='v'><ssv:Parameters><ssv:Parameter name='k'><ssv:Integer value='3'/>\
         </ssv:Parameter></ssv:Parameters></ssv:ParameterSet>",
    )
    .unwrap();
    let text = two().text().replacen(
        "<ssd:System name='test'>",
        "<ssd:System name='test'><ssd:ParameterBindings>\
         <ssd:ParameterBinding source='values.ssv' prefix='gain.'/></ssd:ParameterBindings>",
        1,
    );
    let file = folder.path().join("test.ssd");
    std::fs::write(&file, &text).unwrap();
    let results = run(&System::load(&file, &Overrides::new()).unwrap());
    assert_near(&results.column("gain.y").unwrap()[9..], &[2.7, 3.0]);
}

#[test]
fn fmus_and_interfaces_are_chosen_by_patterns() {
    let folder = tempfile::TempDir::new().unwrap();
    let double = Model::Gain.varied(folder.path(), "<Real start=\"1\"/>", "<Real start=\"2\"/>");
    let ssd = Ssd::new().add("g1", Model::Gain).add("g2", Model::Gain).add("clock", Model::Clock);
    let models = |overrides: &Overrides| {
        let system = ssd.load(overrides).unwrap();
        let paths = system.components().iter().map(|c| c.fmu().unwrap().path().to_owned());
        paths.collect::<Vec<_>>()
    };
    let overrides = Overrides::new().replace("g*", &double);
    assert_eq!(models(&overrides), [double.clone(), double.clone(), Model::Clock.fmu()]);
    // A name takes precedence over a pattern.
    let overrides = Overrides::new().replace("g1", Model::Gain.fmu()).replace("g*", &double);
    assert_eq!(models(&overrides), [Model::Gain.fmu(), double.clone(), Model::Clock.fmu()]);
    let error = ssd.load(&Overrides::new().replace("x*", &double)).err().unwrap();
    assert_eq!(error.code(), cosim::Code::UnknownName);
    let file = ssd.write();
    let run = |kind: &str| {
        let arguments = ["run", file.to_str().unwrap(), "-q", "--interface-type", kind];
        command::text(&command::cosim(folder.path(), &arguments).stderr)
    };
    assert!(run("g*=me").contains("has no model exchange part"));
    assert_eq!(run("?*=cs"), "");
}
