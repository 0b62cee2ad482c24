//! Validation before a run: all problems at once, with file and line, also as JSON.

use std::process::Command;

use serde_json::Value;

use crate::formats::{Folder, component, connection, ssd, system};
use crate::models::Model;

fn validate(folder: &Folder, file: &str) -> (i32, Value) {
    let output = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["validate", file, "--format", "json"])
        .current_dir(folder.0.path())
        .output()
        .unwrap();
    (output.status.code().unwrap(), serde_json::from_slice(&output.stdout).unwrap())
}

fn bound(name: &str, kind: &str, value: &str) -> String {
    format!(
        "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>\n\
         <ssv:ParameterSet version='1.0' name='p'><ssv:Parameters>\n<ssv:Parameter name='{name}'>\
         <ssv:{kind} value='{value}'/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>\
         </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
    )
}

#[test]
fn all_kinds_of_problems_at_once_with_file_and_line() {
    let folder = Folder::new();
    let metre = folder.fmu_in(Model::Clock, "m", "m=\"1\"");
    let second = folder.fmu_in(Model::Gain, "s", "s=\"1\"");
    let gain = Model::Gain.fmu();
    let step = "<ssd:Annotations><ssc:Annotation type='cosim'>\
                <cosim:Component xmlns:cosim='urn:cosim:1' stepSize='0.0333331'/>\
                </ssc:Annotation></ssd:Annotations>";
    let ports = "u:input:Real y:output:Real m:input:Integer n:output:Integer";
    let elements = [
        component("clock", &metre, ports, ""),
        component("inSeconds", &second, ports, step),
        component("gain", &gain, ports, &bound("kk", "Real", "1")),
        component("unsettable", &gain, ports, &bound("y", "Real", "1")),
        component("unparsed", &gain, ports, &bound("k", "Real", "much")),
        component("untyped", &gain, ports, &bound("k", "String", "1")),
        component("absent", std::path::Path::new("absent.fmu"), ports, ""),
        component("asOutput", &gain, "u:output:Real", ""),
        component("web", std::path::Path::new("https://example.org/x.fmu"), "", ""),
        "<ssd:Componet name='typo'/>\n".to_owned(),
    ];
    let connections = [
        connection("clock.y", "inSeconds.u", ""),
        connection("clok.y", "gain.u", ""),
        connection("clock.yy", "gain.u", ""),
        connection("gain.y", "unsettable.u", ""),
        connection("inSeconds.y", "unsettable.u", ""),
        connection("gain.y", "unsettable.m", ""),
        connection("gain.y", "unparsed.y", ""),
    ];
    folder.write("x.ssd", &ssd(&system(&elements.concat(), &connections.concat()), ""));
    let (code, reported) = validate(&folder, "x.ssd");
    assert_eq!(code, 3);
    let problems = reported["problems"].as_array().unwrap();
    let text = serde_json::to_string_pretty(problems).unwrap();
    for (code, what, help) in [
        ("E209", "clock.y -> inSeconds.u: m meets s", "suppressUnitConversion"),
        ("E202", "no component 'clok'", "did you mean 'clock'?"),
        ("E202", "no variable 'yy'", "did you mean 'y'?"),
        ("E203", "'unsettable.u' has two drivers", "remove one"),
        ("E203", "gain.y -> unsettable.m", "Real connects to Real"),
        ("E203", "'unparsed.y' is not an input", "an output and an input"),
        ("E202", "'gain' has no variable 'kk'", "did you mean 'k'?"),
        ("E204", "'unsettable.y' cannot have a start value", "set a parameter"),
        ("E204", "the start value of 'unparsed.k'", ""),
        ("E204", "'untyped.k' is given as <ssv:String>", "<ssv:Real"),
        ("E101", "the FMU of 'absent' cannot be opened", "build or copy"),
        ("E203", "'asOutput.u' is listed as kind=\"output\"", "kind=\"input\""),
        ("E208", "\"https://example.org/x.fmu\" is refused", ""),
        ("E201", "<Componet>", "did you mean 'Component'?"),
    ] {
        let found = problems.iter().find(|p| {
            p["code"] == code && p["what"].as_str().is_some_and(|text| text.contains(what))
        });
        let found = found.unwrap_or_else(|| panic!("{code} {what} is not in {text}"));
        assert!(found["line"].as_u64().is_some_and(|line| line > 6), "{found}");
        assert_eq!(found["file"], "x.ssd", "{found}");
        assert!(found["help"].as_str().unwrap_or_default().contains(help), "{found}");
    }
    assert_eq!(problems.len(), 14, "{text}");
}

fn line_of(text: &str, part: &str) -> usize {
    1 + text.lines().position(|line| line.contains(part)).unwrap()
}

#[test]
fn times_loops_and_what_is_not_connected() {
    let folder = Folder::new();
    let gain = Model::Gain.fmu();
    let ports = "u:input:Real y:output:Real";
    let text = |stop: &str| {
        let elements = [
            component("a", &gain, ports, ""),
            component("b", &gain, ports, ""),
            component("c", &gain, ports, ""),
        ];
        let connections = [connection("a.y", "b.u", ""), connection("b.y", "a.u", "")];
        ssd(&system(&elements.concat(), &connections.concat()), "").replace("stopTime='1'", stop)
    };
    folder.write("x.ssd", &text("stopTime='-1'"));
    let (_, reported) = validate(&folder, "x.ssd");
    let problem = &reported["problems"][0];
    let line = line_of(&text(""), "<ssd:DefaultExperiment");
    assert_eq!((&problem["code"], &problem["line"]), (&"E205".into(), &line.into()), "{reported}");
    folder.write("x.ssd", &text("stopTime='1'"));
    let (code, reported) = validate(&folder, "x.ssd");
    assert_eq!((code, &reported["valid"]), (0, &true.into()), "{reported}");
    let warning = reported["warnings"][0].as_str().unwrap();
    assert!(warning.contains("algebraic loop through a, b"), "{reported}");
    let notes = reported["notes"].to_string();
    assert!(notes.contains("the input c.u is not connected"), "{reported}");
}

#[test]
fn what_is_missing_on_this_machine_does_not_make_a_file_invalid() {
    let folder = Folder::new();
    let foreign = folder.path("foreign.fmu");
    let described = Model::Gain.description().into_bytes();
    crate::models::pack(
        &foreign,
        &[("modelDescription.xml", described), ("binaries/win64/GAIN.dll", b"MZ".to_vec())],
    );
    let flag = "needsExecutionTool=\"true\" canGet";
    let tool = folder.fmu(Model::Gain, "tool", &[("canGet", flag)]);
    let both = [component("f", &foreign, "", ""), component("t", &tool, "", "")];
    folder.write("x.ssd", &ssd(&system(&both.concat(), ""), ""));
    let binary = "foreign.fmu: the FMU has no binary for this machine: export it";
    let needs = "needs a tool to be installed: if it is installed here, add --execution-tool";
    for (file, wanted) in
        [("foreign.fmu", &[binary][..]), ("tool.fmu", &[needs]), ("x.ssd", &[binary, needs])]
    {
        let (code, reported) = validate(&folder, file);
        assert_eq!((code, &reported["valid"]), (0, &true.into()), "{reported}");
        let notes: Vec<&str> =
            reported["notes"].as_array().unwrap().iter().filter_map(|n| n.as_str()).collect();
        let notes: Vec<&&str> =
            notes.iter().filter(|note| note.starts_with("to run it:")).collect();
        assert_eq!(notes.len(), wanted.len(), "{reported}");
        assert!(wanted.iter().zip(notes).all(|(part, note)| note.contains(part)), "{reported}");
    }
    for arguments in [["run", "x.ssd"], ["simulate", "foreign.fmu"], ["simulate", "tool.fmu"]] {
        let output = crate::command::cosim(folder.0.path(), &arguments);
        assert_eq!(output.status.code(), Some(3));
        assert!(crate::command::text(&output.stderr).contains("E105"));
    }
}
