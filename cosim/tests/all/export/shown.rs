//! The variables of an exported FMU, and the files in its archive.

use std::collections::BTreeMap;
use std::io::Read;

use cosim::fmi::{Causality, Fmu, Value};
use tempfile::TempDir;

use super::{command, export, seconds};
use crate::models::Model::{Clock, Counter, Gain};
use crate::ssd::Ssd;

fn two() -> Ssd {
    Ssd::new()
        .add("clock", Clock)
        .add_with("g", Gain, &[("k", 2.5)], None)
        .connect("clock.y", "g.u")
        .stop(3.0)
}

#[test]
fn outputs_parameters_and_free_inputs_are_shown() {
    let exported = export(&two().write(), &[]);
    let fmu = Fmu::open(&exported.fmu).unwrap();
    let description = fmu.description();
    let of = |wanted| -> Vec<&str> {
        let variables = description.variables.iter().filter(|v| v.causality == wanted);
        variables.map(|v| v.name.as_str()).collect()
    };
    assert_eq!(of(Causality::Input), ["clock.u", "clock.m", "clock.odd", "g.m", "g.odd"]);
    let parameters = ["k", "second", "text", "mode"];
    let parameters = ["clock", "g"].map(|c| parameters.map(|p| format!("{c}.{p}"))).concat();
    assert_eq!(of(Causality::Parameter), parameters);
    let outputs = ["y", "n", "even"];
    let outputs = ["clock", "g"].map(|c| outputs.map(|p| format!("{c}.{p}"))).concat();
    assert_eq!(of(Causality::Output), outputs);
    let experiment = description.experiment;
    assert_eq!((experiment.stop, experiment.step), (Some(3.0), Some(0.1)));
    let k = description.variable("g.k").unwrap();
    assert_eq!(k.start, Some(Value::Real(2.5)));
    let own = exported.description();
    for part in [
        "<Real unit=\"m\" start=\"0.0\"/>",
        "<Enumeration declaredType=\"Mode\" start=\"1\"/>",
        "<Item name=\"Fast\" value=\"4\"/>",
        "<String start=\"\"/>",
        "variability=\"discrete\"",
    ] {
        assert!(own.contains(part), "{part} in {own}");
    }
    // Once, though two components have it.
    assert_eq!(own.matches("<SimpleType").count(), 1);
    assert!(description.warnings.is_empty(), "{:?}", description.warnings);
}

#[test]
fn the_documentation_says_what_is_inside_and_on_which_terms() {
    let exported = export(&two().write(), &[]);
    let folder = cosim::fmi::archive::unpack(&exported.fmu).unwrap();
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let page = text("documentation/index.html");
    for part in ["<td>GAIN</td>", "clock.y</th><td>g.u</td>", "g.k</th><td>parameter</td>"] {
        assert!(page.contains(part), "{part} in {page}");
    }
    let licenses = text("documentation/licenses/license.txt");
    for part in ["MIT or Apache-2.0", "The FMUs inside", ": does not say"] {
        assert!(licenses.contains(part), "{part} in {licenses}");
    }
    assert!(text("documentation/licenses/LICENSE-MIT").contains("Permission is hereby granted"));
    let icon = std::fs::read(folder.path().join("model.png")).unwrap();
    assert!(icon.starts_with(b"\x89PNG"));
}

#[test]
fn patterns_choose() {
    let names = |arguments: &[&str]| {
        let exported = export(&two().write(), arguments);
        let fmu = Fmu::open(&exported.fmu).unwrap();
        fmu.description().names().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(names(&["--expose", "g.?", "--hide", "g.m"]), ["g.u", "g.k", "g.y", "g.n"]);
    assert_eq!(names(&["--hide", "clock.*", "--hide", "g.*e*", "--hide", "g.o*"]).len(), 4);
}

#[test]
fn variables_of_all_types_reach_their_component() {
    let exported = export(&Ssd::new().add("c", Counter).add("g", Gain).write(), &[]);
    let mut instance = exported.instance();
    let fmu = instance.fmu().clone();
    let named = |name: &str| fmu.description().variable(name).unwrap();
    let give = |instance: &mut cosim::fmi::Instance, name: &str, value: Value| {
        instance.set_value(named(name), &value).unwrap();
    };
    give(&mut instance, "g.text", Value::String("three".to_owned()));
    give(&mut instance, "g.mode", Value::Integer(4));
    instance.enter_initialization(seconds(0.0), seconds(1.0)).unwrap();
    give(&mut instance, "c.m", Value::Integer(40));
    give(&mut instance, "c.odd", Value::Boolean(true));
    give(&mut instance, "g.u", Value::Real(2.0));
    instance.exit_initialization().unwrap();
    instance.do_step(seconds(0.0), seconds(0.2)).unwrap();
    let found = ["c.n", "c.even", "g.mode", "g.text", "g.y", "c.m"];
    let found = found.map(|name| instance.get_value(named(name)).unwrap());
    let wanted = [
        Value::Integer(42),
        Value::Boolean(false),
        Value::Integer(4),
        Value::String("three".to_owned()),
        // The gain is the length of the text.
        Value::Real(10.0),
        Value::Integer(40),
    ];
    assert_eq!(found, wanted);
}

#[test]
fn what_is_calculated_or_fixed_is_refused_with_its_name() {
    let exported = export(&two().write(), &[]);
    let mut instance = exported.started();
    for (name, part) in [("g.y", "g.y cannot be set: it is calculated"), ("g.k", "it is fixed")] {
        let reference = super::variable(&instance, name).value_reference;
        let error = instance.set_real(&[reference], &[1.0]).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
        instance = exported.started();
    }
}

fn entries(file: &std::path::Path) -> BTreeMap<String, Vec<u8>> {
    let mut zip = zip::ZipArchive::new(std::fs::File::open(file).unwrap()).unwrap();
    let names: Vec<String> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
    let read = |name: String| {
        let mut bytes = Vec::new();
        zip.by_name(&name).unwrap().read_to_end(&mut bytes).unwrap();
        (name, bytes)
    };
    names.into_iter().map(read).collect()
}

#[test]
fn the_same_system_gives_the_same_bytes_and_each_fmu_once() {
    let system = Ssd::new().add("a", Gain).add("b", Gain).add("c", Clock).connect("c.y", "a.u");
    let file = system.write();
    let (first, second) = (export(&file, &[]), export(&file, &[]));
    let read = |exported: &super::Exported| std::fs::read(&exported.fmu).unwrap();
    assert_eq!(read(&first), read(&second));
    let inside = entries(&first.fmu);
    let names: Vec<&str> = inside.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "binaries/linux64/test.so",
            "documentation/index.html",
            "documentation/licenses/LICENSE-APACHE",
            "documentation/licenses/LICENSE-MIT",
            "documentation/licenses/license.txt",
            "model.png",
            "modelDescription.xml",
            "resources/SystemStructure.ssd",
            "resources/fmus/CLOCK.fmu/binaries/linux64/CLOCK.so",
            "resources/fmus/CLOCK.fmu/modelDescription.xml",
            "resources/fmus/GAIN.fmu/binaries/linux64/GAIN.so",
            "resources/fmus/GAIN.fmu/modelDescription.xml",
            "resources/interface.bin",
        ]
    );
    let own = file.parent().unwrap().to_str().unwrap();
    for name in
        ["modelDescription.xml", "resources/SystemStructure.ssd", "documentation/index.html"]
    {
        let text = String::from_utf8_lossy(&inside[name]);
        assert!(!text.contains(own) && !text.contains("source=\"/"), "{name}: {text}");
    }
    for (name, content) in entries(&Gain.fmu()) {
        assert_eq!(inside[&format!("resources/fmus/GAIN.fmu/{name}")], content, "{name}");
    }
}

#[test]
fn an_fmu_that_is_there_is_replaced_as_a_whole() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("Loop.fmu");
    std::fs::write(&file, "old").unwrap();
    assert_eq!(command(folder.path(), &two().write(), &[]).0, 0);
    assert!(Fmu::open(&file).is_ok());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
