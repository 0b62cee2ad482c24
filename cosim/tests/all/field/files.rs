//! Archives and descriptions as written by other tools.

use std::path::Path;

use cosim::{Overrides, Recording, System};
use tempfile::TempDir;

use super::{described, run};
use crate::command::{cosim, text};
use crate::formats::{Folder, component, connection, ssd, system};
use crate::models::Model::{self, Clock, Gain, Lag, Ticker};
use crate::models::{compile, pack};

fn record(fmu: &Path, overrides: &Overrides) -> Recording {
    let system = System::single(fmu, overrides, None).unwrap();
    let mut recording = Recording::new();
    system.run(&mut [&mut recording]).unwrap();
    recording
}

#[test]
fn backslashes_separate_the_folders_of_an_archive() {
    let folder = Folder::new();
    let library = std::fs::read(compile(Gain)).unwrap();
    let entries = [
        ("binaries/", Vec::new()),
        ("binaries\\linux64\\", Vec::new()),
        ("binaries\\linux64\\GAIN.so", library),
        ("modelDescription.xml", Gain.description().into_bytes()),
    ];
    pack(&folder.path("packed.fmu"), &entries);
    assert_eq!(record(&folder.path("packed.fmu"), &Overrides::new()).time().len(), 11);
}

#[test]
fn a_library_with_another_name_is_named() {
    let folder = Folder::new();
    let library = std::fs::read(compile(Gain)).unwrap();
    let description = Gain.description().into_bytes();
    let entries = [("modelDescription.xml", description), ("binaries/linux64/renamed.so", library)];
    pack(&folder.path("renamed.fmu"), &entries);
    let output = cosim(folder.0.path(), &["simulate", "renamed.fmu"]);
    let reported = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{reported}");
    for part in ["E105", "binaries/linux64/renamed.so", "rename it", "binaries/linux64/GAIN.so"] {
        assert!(reported.contains(part), "{reported}");
    }
}

#[test]
fn an_empty_folder_of_binaries_is_none() {
    let folder = Folder::new();
    let reported = |entries: &[&str]| {
        let description = ("modelDescription.xml", Gain.description().into_bytes());
        let entries = entries.iter().map(|entry| (*entry, Vec::new()));
        pack(
            &folder.path("empty.fmu"),
            &[description].into_iter().chain(entries).collect::<Vec<_>>(),
        );
        let output = cosim(folder.0.path(), &["simulate", "empty.fmu"]);
        assert_eq!(output.status.code(), Some(3));
        text(&output.stderr)
    };
    let none = reported(&["binaries/", "binaries/linux64/", "binaries/win64/"]);
    assert!(none.contains("it has no binaries at all"), "{none}");
    let one = reported(&["binaries/linux64/", "binaries/win32/", "binaries/win64/Gain.dll"]);
    assert!(one.contains("it has binaries for: win64\n"), "{one}");
}

#[test]
fn a_description_may_be_in_latin_1() {
    let folder = Folder::new();
    let description = Gain
        .description()
        .replace("UTF-8", "iso-8859-1")
        .replace("name=\"y\"", "name=\"H\u{f6}he\"");
    let latin_1: Vec<u8> = description.chars().map(|c| u32::from(c) as u8).collect();
    let library = std::fs::read(compile(Gain)).unwrap();
    let entries = [("modelDescription.xml", latin_1), ("binaries/linux64/GAIN.so", library)];
    pack(&folder.path("old.fmu"), &entries);
    let recording = record(&folder.path("old.fmu"), &Overrides::new().start_value("u", 2));
    assert_eq!(recording.column("H\u{f6}he").unwrap()[10], 2.0);
}

#[test]
fn what_depends_on_what_may_be_left_out() {
    let structure = |text: &str, new: &str| {
        let (before, rest) = text.split_once("<ModelStructure>").unwrap();
        let (_, after) = rest.split_once("</ModelStructure>").unwrap();
        format!("{before}{new}{after}")
    };
    let folder = Folder::new();
    for new in [
        "",
        "<ModelStructure/>",
        "<ModelStructure><Outputs><Unknown index=\"3\"/></Outputs></ModelStructure>",
    ] {
        let fmu = Gain.variant(&folder.path("g.fmu"), &[], |text| structure(&text, new));
        let ports = "u:input:Real y:output:Real";
        let clock = component("c", &Clock.fmu(), ports, "");
        let elements = [component("g", &fmu, ports, ""), clock];
        let text = ssd(&system(&elements.concat(), &connection("c.y", "g.u", "")), "");
        let mut recording = Recording::new();
        folder.load(&text).unwrap().run(&mut [&mut recording]).unwrap();
        // It is assumed to depend on all inputs, so they are fresh.
        assert_eq!(recording.column("g.y").unwrap(), recording.column("c.y").unwrap(), "{new}");
    }
}

#[test]
fn the_independent_variable_may_be_among_the_variables() {
    let folder = TempDir::new().unwrap();
    let time = "<ScalarVariable name=\"time\" valueReference=\"3\" causality=\"independent\">\
                <Real/></ScalarVariable></ModelVariables>";
    let fmu = described(&folder, "INDEPENDENT", &[("</ModelVariables>", time)]);
    let output = cosim(folder.path(), &["simulate", fmu.to_str().unwrap(), "-o", "out.csv"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let written = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert!(written.starts_with("time,y,n,even\n0.0,"), "{written}");
}

#[test]
fn an_fmu_may_have_no_variable_at_all() {
    let folder = TempDir::new().unwrap();
    let fmu = Gain.variant(&folder.path().join("empty.fmu"), &[], |text| {
        let (before, rest) = text.split_once("<ModelVariables>").unwrap();
        let (_, after) = rest.split_once("</ModelStructure>").unwrap();
        format!("{before}<ModelVariables/><ModelStructure/>{after}")
    });
    let recording = record(&fmu, &Overrides::new());
    assert_eq!((recording.time().len(), recording.names().len()), (11, 0));
}

#[test]
fn items_of_enumerations_need_not_be_one_two_three() {
    let folder = TempDir::new().unwrap();
    let items = "<Item name=\"Slow\" value=\"1\"/><Item name=\"Fast\" value=\"4\"/>";
    let odd = "<Item name=\"Back\" value=\"-1\"/><Item name=\"None\" value=\"0\"/>\
               <Item name=\"Fast\" value=\"7\"/>";
    let start = ("declaredType=\"Mode\" start=\"1\"", "declaredType=\"Mode\" start=\"0\"");
    let fmu = described(&folder, "ITEMS", &[(items, odd), start]);
    for (given, wanted) in [("Back", -1.0), ("Fast", 7.0), ("0", 0.0)] {
        let overrides = Overrides::new().start_value("mode", given).output_variable("mode");
        assert_eq!(record(&fmu, &overrides).column("mode").unwrap()[0], wanted);
    }
    let overrides = Overrides::new().start_value("mode", "Fats");
    let error = System::single(&fmu, &overrides, None).err().unwrap().to_string();
    assert!(error.contains("did you mean 'Fast'"), "{error}");
    // A number that is not an item, or without a type, is left to the FMU.
    let changes = [
        ("declaredType=\"Mode\" start=\"1\"", "declaredType=\"Mode\" start=\"3\""),
        ("declaredType=\"Mode\" start=\"1\"", "start=\"3\""),
    ];
    for change in changes {
        let fmu = described(&folder, "ITEMS", &[change]);
        assert_eq!(record(&fmu, &Overrides::new()).time().len(), 11);
    }
}

#[test]
fn a_start_value_may_lie_out_of_its_bounds_or_be_infinite() {
    let folder = TempDir::new().unwrap();
    let k = "variability=\"fixed\"><Real start=\"1\"";
    for new in
        ["start=\"9\" min=\"0\" max=\"1\"", "start=\"9\" min=\"-INF\" max=\"INF\"", "start=\"INF\""]
    {
        let new = format!("variability=\"fixed\"><Real {new}");
        let fmu = described(&folder, "BOUNDS", &[(k, &new)]);
        let (recording, warnings) = run(&fmu, &Overrides::new().start_value("u", 2));
        // The description contains the FMU's value; nothing is set.
        assert_eq!(recording.column("y").unwrap()[0], 2.0, "{new}");
        assert!(warnings.is_empty(), "{warnings:?}");
    }
}

#[test]
fn names_differ_by_case_and_hold_blanks_and_quotes() {
    let folder = TempDir::new().unwrap();
    let changes =
        [("name=\"u\"", "name=\"Y\""), ("name=\"k\"", "name=\"the 'k' of &quot;y&quot;\"")];
    let fmu = described(&folder, "NAMES", &changes);
    let overrides = Overrides::new().start_value("Y", 2).start_value("the 'k' of \"y\"", 3);
    let recording = record(&fmu, &overrides.output_variables(["y", "Y", "the 'k' of \"y\""]));
    let first = |name: &str| recording.column(name).unwrap()[0];
    assert_eq!((first("y"), first("Y"), first("the 'k' of \"y\"")), (6.0, 2.0, 3.0));
}

#[test]
fn a_run_begins_where_the_experiment_does() {
    let folder = TempDir::new().unwrap();
    let later = "startTime=\"5\" stopTime=\"6\"";
    for model in [Clock, Lag, Ticker] {
        let fmu = model.varied(folder.path(), "startTime=\"0\" stopTime=\"1\"", later);
        let recording = record(&fmu, &Overrides::new());
        assert_eq!((recording.time()[0], recording.time()[10]), (5.0, 6.0));
    }
    let clock = Clock.varied(folder.path(), "startTime=\"0\" stopTime=\"1\"", later);
    assert_eq!(record(&clock, &Overrides::new()).column("y").unwrap()[10], 6.0);
}

#[test]
fn each_interface_has_its_own_library() {
    let folder = TempDir::new().unwrap();
    let exchange = "<ModelExchange modelIdentifier=\"LAG\"/><CoSimulation";
    let description = Gain.description().replace("<CoSimulation", exchange);
    let library = |model: Model| std::fs::read(compile(model)).unwrap();
    let entries = [
        ("modelDescription.xml", description.into_bytes()),
        ("binaries/linux64/GAIN.so", library(Gain)),
        ("binaries/linux64/LAG.so", library(Lag)),
    ];
    let fmu = folder.path().join("both.fmu");
    pack(&fmu, &entries);
    for (kind, y) in [("cs", 2.0), ("me", 0.0)] {
        let arguments = ["simulate", fmu.to_str().unwrap(), "--interface-type", kind];
        let more = ["--start-value", "u=2", "--output-variable", "y", "-o", "out.csv"];
        let output = cosim(folder.path(), &[&arguments[..], &more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        let read = Recording::read_csv(folder.path().join("out.csv")).unwrap();
        assert_eq!(read.column("y").unwrap()[0], y, "{kind}");
    }
}

#[test]
fn outputs_and_local_variables_with_an_exact_start_can_be_set() {
    let overrides = Overrides::new().start_value("x", 2.5);
    assert_eq!(record(&Model::Ball.fmu(), &overrides).column("y").unwrap()[0], 2.5);
}

#[test]
fn a_variable_may_be_set_by_any_of_its_names() {
    let folder = TempDir::new().unwrap();
    let parameter = "<ScalarVariable name=\"gain\" valueReference=\"1\" causality=\"parameter\" \
                     variability=\"fixed\"><Real start=\"1\"/></ScalarVariable>\
                     <ScalarVariable name=\"v\" valueReference=\"0\" causality=\"local\"><Real/>\
                     </ScalarVariable></ModelVariables>";
    let fmu = described(&folder, "ALIASES", &[("</ModelVariables>", parameter)]);
    for (given, y) in [(&[("gain", 3.0)][..], 6.0), (&[("k", 5.0), ("gain", 4.0)], 8.0)] {
        let overrides = given.iter().fold(Overrides::new(), |all, (n, v)| all.start_value(*n, *v));
        let overrides = overrides.start_value("u", 2).output_variables(["y", "k", "gain", "v"]);
        let recording = record(&fmu, &overrides);
        let first = |name: &str| recording.column(name).unwrap()[0];
        assert_eq!((first("y"), first("v")), (y, 2.0));
        assert_eq!(first("k"), first("gain"));
    }
}

#[test]
fn connectors_of_parameters_that_an_fmu_does_not_have_are_left_out() {
    let folder = Folder::new();
    let ports = "u:input:Real y:output:Real k:parameter:Binary fmi_rTol:parameter:Binary";
    let text = ssd(&system(&component("g", &Gain.fmu(), ports, ""), ""), "");
    let loaded = folder.load(&text).unwrap();
    let wanted = "'g' lists parameters that its FMU does not have: fmi_rTol; they are left out";
    assert_eq!(loaded.warnings(), [wanted]);
    // An input that does not exist, or has another type, would be reported.
    for ports in ["v:input:Real", "u:input:Integer"] {
        let text = ssd(&system(&component("g", &Gain.fmu(), ports, ""), ""), "");
        assert!(!folder.error(&text).is_empty());
    }
}

#[test]
fn the_file_that_is_meant_is_named() {
    let folder = Folder::new();
    std::fs::copy(Gain.fmu(), folder.path("AframeSetPoint.fmu")).unwrap();
    let text = ssd(&system(&component("g", Path::new("AFrameSetpoint.fmu"), "", ""), ""), "");
    let error = folder.error(&text);
    assert!(error.contains("[E101]"), "{error}");
    assert!(error.contains("did you mean 'AframeSetPoint.fmu'? If not, build"), "{error}");
}

#[test]
fn a_step_in_omsimulators_annotation_is_that_of_all_components() {
    let folder = Folder::new();
    let namespace =
        "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
    let annotation = format!(
        "<ssd:Annotations><ssc:Annotation type='org.openmodelica'><oms:Annotations xmlns:oms='{namespace}'>\
         <oms:SimulationInformation><oms:FixedStepMaster description='oms-ma' stepSize='0.250000' \
         relativeTolerance='0.0001'/></oms:SimulationInformation></oms:Annotations></ssc:Annotation>\
         </ssd:Annotations>"
    );
    let inside = system(&component("g", &Gain.fmu(), "", ""), "");
    let loaded = folder.load(&ssd(&format!("{inside}{annotation}"), "")).unwrap();
    assert_eq!(loaded.components()[0].step.seconds(), 0.25);
    // 0 is written where a variable-step solver chooses.
    let none = annotation.replace("0.250000", "0.000000");
    let loaded = folder.load(&ssd(&format!("{inside}{none}"), "")).unwrap();
    assert_eq!(loaded.components()[0].step.seconds(), 0.1);
}
