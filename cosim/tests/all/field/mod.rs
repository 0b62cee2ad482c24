//! Traits of FMUs in the field, each tested on an FMU made for it.

mod exchange;
mod files;
mod modes;
mod process;
mod table;

use cosim::fmi::Fmu;
use cosim::{Overrides, Recording, System};
use tempfile::TempDir;

use crate::command::{cosim, text};
use crate::export::export;
use crate::formats::{Folder, component, ssd, system};
use crate::models::Model::{self, Clock, Gain, Lag};
use crate::models::pack;
use crate::rawzip::{self, Entry};

/// A model that is compiled with `define`.
fn with(folder: &TempDir, model: Model, define: &str) -> std::path::PathBuf {
    model.variant(&folder.path().join(format!("{define}.fmu")), &[define], |text| text)
}

/// Runs an FMU alone; returns the recording and the warnings.
fn run(fmu: &std::path::Path, overrides: &Overrides) -> (Recording, Vec<String>) {
    let overrides = overrides.clone().output_variables(["y", "k", "second"]);
    let system = System::single(fmu, &overrides, None).unwrap();
    let mut recording = Recording::new();
    let summary = system.run(&mut [&mut recording]).unwrap();
    (recording, summary.warnings)
}

#[test]
fn start_values_reach_fmus_that_forget_them() {
    let folder = TempDir::new().unwrap();
    for define in ["FORGETS_IN_SETUP", "FORGETS_IN_ENTER", "FORGETS_NOTHING"] {
        let overrides = Overrides::new().start_value("k", 3.0).start_value("u", 2.0);
        let (recording, warnings) = run(&with(&folder, Gain, define), &overrides);
        assert_eq!(recording.column("y").unwrap()[0], 6.0, "{define}");
        assert!(warnings.is_empty(), "{define}: {warnings:?}");
    }
    let overrides = Overrides::new().start_value("text", "four");
    let (recording, _) = run(&with(&folder, Gain, "FORGETS_IN_SETUP"), &overrides);
    assert_eq!(recording.column("k").unwrap()[0], 4.0);
}

#[test]
fn parameters_that_are_lost_at_the_end_of_initialization_are_named() {
    let folder = TempDir::new().unwrap();
    for (model, had) in [(Gain, "1.0"), (Lag, "0.5")] {
        let overrides = Overrides::new().start_value("k", 3.0).start_value("u", 2.0);
        let overrides = overrides.output_variables(["y"]);
        let fmu = with(&folder, model, "FORGETS_IN_EXIT");
        let system = System::single(&fmu, &overrides, None).unwrap();
        let warnings = system.run(&mut []).unwrap().warnings;
        let wanted = format!("at the end of its initialization: k = 3.0 (it has {had})");
        assert!(warnings.len() == 1 && warnings[0].ends_with(&wanted), "{warnings:?}");
    }
}

#[test]
fn a_start_value_that_is_not_taken_is_named_once() {
    let folder = TempDir::new().unwrap();
    for model in [Gain, Model::Mass] {
        let overrides = Overrides::new().start_value("k", 3.0).start_value("second", 4.0);
        let (_, warnings) = run(&with(&folder, model, "IGNORES_K"), &overrides);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        let wanted = "does not accept start values: k = 3.0 (it has 1.0)";
        assert!(warnings[0].ends_with(wanted), "{warnings:?}");
    }
}

#[test]
fn messages_of_fmus_with_an_environment_of_their_own_are_reported() {
    let folder = TempDir::new().unwrap();
    for define in ["ENVIRONMENT_IS_COMPONENT", "ENVIRONMENT_IS_ONE"] {
        let fmu = with(&folder, Gain, define);
        let overrides = Overrides::new().debug_logging(true);
        let system = System::single(&fmu, &overrides, None).unwrap();
        let summary = system.run(&mut []).unwrap();
        let last = summary.messages.last();
        assert_eq!(last.unwrap(), "GAIN: OK (logAll): step to 1 s", "{define}");
    }
}

#[test]
fn an_fmu_gets_the_tolerance_that_it_suggests() {
    let folder = TempDir::new().unwrap();
    for (suggested, wanted) in [(" tolerance=\"1e-4\"", 1e-4), ("", -1.0)] {
        let fmu = Gain.variant(&folder.path().join("t.fmu"), &["TELLS_TOLERANCE"], |text| {
            text.replace("<DefaultExperiment", &format!("<DefaultExperiment{suggested}"))
        });
        let second = |overrides: &Overrides| run(&fmu, overrides).0.column("second").unwrap()[0];
        assert_eq!(second(&Overrides::new()), wanted);
        assert_eq!(second(&Overrides::new().tolerance(1e-3)), 1e-3);
        // So does one in an exported system, from the option of its export or from its host.
        let file = Folder::new();
        let text = ssd(&system(&component("g", &fmu, "y:output:Real", ""), ""), "");
        let file = file.write("x.ssd", &text);
        for (option, host, wanted) in [
            (&[][..], None, wanted),
            (&["--tolerance=1e-3"], None, 1e-3),
            (&["--tolerance=1e-3"], Some(1e-5), 1e-5),
        ] {
            let exported = export(&file, option);
            let recorded = Overrides::new().output_variable("g.second");
            let overrides = host.iter().fold(recorded, |all, host| all.tolerance(*host));
            let recording =
                crate::ssd::run(&System::single(&exported.fmu, &overrides, None).unwrap());
            assert_eq!(recording.column("g.second").unwrap()[0], wanted, "{option:?}");
        }
    }
}

#[test]
fn model_exchange_without_listed_derivatives_is_refused_and_co_simulation_is_not() {
    let folder = TempDir::new().unwrap();
    let list = "<Derivatives><Unknown index=\"5\"/></Derivatives>";
    let fmu = Lag.varied(folder.path(), list, "");
    let path = fmu.to_str().unwrap();
    for command in ["validate", "simulate"] {
        let output = cosim(folder.path(), &[command, path]);
        let reported = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{reported}");
        assert!(
            reported.contains("[E107] 'der(x)' is a derivative") && reported.contains(".xml:"),
            "{reported}"
        );
    }
    // An empty list is not valid, and would leave the states constant all the same.
    let empty = Lag.varied(folder.path(), list, "<Derivatives></Derivatives>");
    let error = System::single(&empty, &Overrides::new(), None).err().unwrap();
    assert_eq!(error.code(), cosim::Code::States);
    // A partial list may mean that the other variables are no states.
    let two = Model::Oscillator.varied(folder.path(), "<Unknown index=\"9\"/>", "");
    assert_eq!(Fmu::open(&two).unwrap().description().states, 2);
}

#[test]
fn elements_named_by_an_empty_text_are_the_system_itself() {
    let folder = Folder::new();
    let gain = component("g", &Gain.fmu(), "u:input:Real y:output:Real", "");
    let ports = "<ssd:Connectors><ssd:Connector name='x' kind='input'><ssc:Real/></ssd:Connector></ssd:Connectors>";
    let wire =
        "<ssd:Connection startElement='' startConnector='x' endElement='g' endConnector='u'/>";
    let text = ssd(&format!("{ports}{}", system(&gain, wire)), "");
    let loaded = folder.load(&text).unwrap();
    assert_eq!(loaded.ports()[0].ends.len(), 1);
    let out = ports.replace("'x' kind='input'", "'x' kind='output'");
    let wire =
        "<ssd:Connection startElement='g' startConnector='y' endElement='' endConnector='x'/>";
    let loaded = folder.load(&ssd(&format!("{out}{}", system(&gain, wire)), "")).unwrap();
    assert_eq!(loaded.port_name(loaded.ports()[0].ends[0].0), "g.y");
}

#[test]
fn customary_prefixes_need_no_declaration() {
    let folder = Folder::new();
    let gain = Gain.fmu();
    let text = ssd(&system(&component("g", &gain, "", ""), ""), "");
    let declared = "\n xmlns:ssv='http://ssp-standard.org/SSP1/SystemStructureParameterValues'";
    assert!(text.contains(declared));
    let values = "<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>\
                  <ssv:ParameterSet version='1.0' name='p'><ssv:Parameters><ssv:Parameter name='k'>\
                  <ssv:Real value='7'/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>\
                  </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>\
                  <ssd:Annotations><ssc:Annotation type='com.opensimulationplatform'>\
                  <osp:StepSizeHint value='0.25'/></ssc:Annotation></ssd:Annotations>";
    let given = text
        .replace("</ssd:Connectors>", &format!("</ssd:Connectors>{values}"))
        .replace(declared, "");
    let loaded = folder.load(&given).unwrap();
    assert_eq!(loaded.components()[0].start_values.len(), 1);
    assert_eq!(loaded.components()[0].step.seconds(), 0.25);
    let ours = "<cosim:Component stepSize='0.5'/>";
    let ours = given.replace("<osp:StepSizeHint value='0.25'/>", ours);
    assert_eq!(folder.load(&ours).unwrap().components()[0].step.seconds(), 0.5);
    // Any other only among annotations, which may be those of another tool.
    let other = given.replace("osp:", "opsp:");
    assert_eq!(folder.load(&other).unwrap().components()[0].step.seconds(), 0.1);
    let outside = given.replace("<ssd:Elements>", "<opsp:Elements>");
    let outside = outside.replace("</ssd:Elements>", "</opsp:Elements>");
    assert!(folder.error(&outside).contains("'opsp:' is not declared"));
}

#[test]
fn a_step_of_zero_is_no_step() {
    let folder = Folder::new();
    let simulator = crate::osp::simulator("g", &Gain.fmu(), "");
    let simulator = simulator.replace("<Simulator ", "<Simulator stepSize='0.0' ");
    let text = crate::osp::structure(&format!("<Simulators>{simulator}</Simulators>"));
    let file = folder.write("OspSystemStructure.xml", &text);
    let loaded = System::load(&file, &Overrides::new()).unwrap();
    assert_eq!(loaded.components()[0].step.seconds(), 0.1);
    let zero = folder.fmu(Gain, "zero", &[("stepSize=\"0.1\"", "stepSize=\"0.0\"")]);
    let backwards = Overrides::new().stop_time(-1.0);
    let error = System::single(&zero, &backwards, None).err().unwrap().to_string();
    assert!(error.contains("the run would go from 0 s to -1 s"), "{error}");
    let alone = System::single(&zero, &Overrides::new(), None).unwrap();
    assert_eq!(alone.components()[0].step.seconds(), 0.002);
    let without = text.replace(" stepSize='0.0'", "");
    let base = without.replace("<Simulators>", "<BaseStepSize>0</BaseStepSize><Simulators>");
    let file = folder.write("OspSystemStructure.xml", &base);
    let step = |file| System::load(file, &Overrides::new()).unwrap().components()[0].step.seconds();
    assert_eq!(step(file), 0.1);
    let hint = |inside: &str| {
        format!(
            "<ssd:Annotations xmlns:cosim='urn:cosim:1'><ssc:Annotation type='x'>{inside}\
             </ssc:Annotation></ssd:Annotations>"
        )
    };
    let experiment = "<ssd:DefaultExperiment startTime='0' stopTime='1'/>";
    for own in ["<osp:StepSizeHint value='0'/>", "<cosim:Component stepSize='0'/>"] {
        let gain = component("g", &Gain.fmu(), "", &hint(own));
        assert_eq!(step(folder.write("x.ssd", &ssd(&system(&gain, ""), ""))), 0.1, "{own}");
    }
    for whole in [
        "<osp:Algorithm><osp:FixedStepAlgorithm baseStepSize='0'/></osp:Algorithm>",
        "<cosim:Master stepSize='0' outputInterval='0'/>",
    ] {
        let gain = component("g", &Gain.fmu(), "", "");
        let inside = experiment.replace("/>", &format!(">{}</ssd:DefaultExperiment>", hint(whole)));
        let text = ssd(&system(&gain, ""), "").replace(experiment, &inside);
        assert_eq!(step(folder.write("x.ssd", &text)), 0.1, "{whole}");
    }
}

#[test]
fn an_archive_may_hold_its_own_folder() {
    let folder = Folder::new();
    let library = std::fs::read(crate::models::compile(Gain)).unwrap();
    let entries = [
        ("./", Vec::new()),
        ("./modelDescription.xml", Gain.description().into_bytes()),
        ("./binaries/linux64/GAIN.so", library),
    ];
    let path = folder.path("dot.fmu");
    pack(&path, &entries);
    assert!(System::single(&path, &Overrides::new(), None).is_ok());
}

#[test]
fn an_archive_may_list_a_folder_twice() {
    let folder = Folder::new();
    let library = std::fs::read(crate::models::compile(Gain)).unwrap();
    let description = Gain.description().into_bytes();
    let entries = [
        Entry::new("binaries/", b""),
        Entry::new("modelDescription.xml", &description),
        Entry::new("binaries/linux64/GAIN.so", &library),
        Entry::new("binaries/", b""),
    ];
    let path = folder.write("twice.fmu", "");
    std::fs::write(&path, rawzip::archive(&entries)).unwrap();
    assert!(System::single(&path, &Overrides::new(), None).is_ok());
}

#[test]
fn what_is_missing_to_run_a_system_does_not_make_it_invalid() {
    let folder = Folder::new();
    let step = "stepSize=\"0.1\"";
    let fmu = folder.fmu(Clock, "stepless", &[(step, ""), ("stopTime=\"1\"", "")]);
    let text = ssd(&system(&component("c", &fmu, "", ""), ""), "");
    let experiment = "<ssd:DefaultExperiment startTime='0' stopTime='1'/>";
    assert!(text.contains(experiment));
    folder.write("x.ssd", &text.replace(experiment, ""));
    let at = folder.0.path();
    let output = cosim(at, &["validate", "x.ssd"]);
    let reported = crate::command::text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{reported}");
    assert!(
        reported.contains("no stop time") && reported.contains("no component has a step"),
        "{reported}"
    );
    for command in [&["run", "x.ssd"][..], &["convert", "x.ssd", "y.ssd"]] {
        let output = cosim(at, command);
        let reported = crate::command::text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{reported}");
        assert!(reported.contains("--stop-time") && reported.contains("--step-size"), "{reported}");
    }
    assert!(cosim(at, &["info", "x.ssd"]).status.success());
    // Nor does it report an empty system.
    folder.write("empty.ssd", &ssd(&system("", ""), ""));
    assert!(cosim(at, &["validate", "empty.ssd"]).status.success());
    let reported = crate::command::text(&cosim(at, &["run", "empty.ssd"]).stderr);
    assert!(reported.contains("[E201] the system has no components"), "{reported}");
    let given = ["run", "x.ssd", "--stop-time=1", "--step-size=0.5", "-q"];
    assert!(cosim(at, &given).status.success());
}

#[test]
fn a_proxied_source_says_what_to_do() {
    let folder = Folder::new();
    let source = std::path::Path::new("proxyfmu://localhost?file=x.fmu");
    let error = folder.error(&ssd(&system(&component("p", source, "", ""), ""), ""));
    assert!(error.contains("E208") && error.contains("source=\"x.fmu\""), "{error}");
}

/// A gain with another description.
fn described(folder: &TempDir, define: &str, changes: &[(&str, &str)]) -> std::path::PathBuf {
    Gain.variant(&folder.path().join("described.fmu"), &[define], |text| {
        changes.iter().fold(text, |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        })
    })
}

#[test]
fn value_references_may_be_as_great_as_there_are() {
    let folder = TempDir::new().unwrap();
    let changes = [
        ("name=\"u\" valueReference=\"0\"", "name=\"u\" valueReference=\"4294967292\""),
        ("name=\"k\" valueReference=\"1\"", "name=\"k\" valueReference=\"2147483649\""),
        ("name=\"y\" valueReference=\"2\"", "name=\"y\" valueReference=\"4294967294\""),
        ("name=\"second\" valueReference=\"3\"", "name=\"second\" valueReference=\"2147483651\""),
    ];
    let fmu = described(&folder, "HIGH_REFERENCES", &changes);
    let overrides = Overrides::new().start_value("u", 2).start_value("k", 5);
    assert_eq!(run(&fmu, &overrides).0.column("y").unwrap()[0], 10.0);
}

#[test]
fn names_need_not_be_ascii_and_one_variable_may_have_several() {
    let folder = TempDir::new().unwrap();
    let alias = "<ScalarVariable name=\"\u{6c34}\u{6df1}\" valueReference=\"2\" causality=\"local\"><Real/>\
                 </ScalarVariable></ModelVariables>";
    let changes = [("name=\"y\"", "name=\"H\u{f6}he[1,2]\""), ("</ModelVariables>", alias)];
    let fmu = described(&folder, "NAMED", &changes);
    let overrides = Overrides::new()
        .start_value("u", 3)
        .output_variables(["H\u{f6}he[1,2]", "\u{6c34}\u{6df1}"]);
    let system = System::single(&fmu, &overrides, None).unwrap();
    let results = folder.path().join("out.csv");
    let mut csv = cosim::observe::CsvRecorder::create(&results).unwrap();
    system.run(&mut [&mut csv]).unwrap();
    let read = Recording::read_csv(&results).unwrap();
    assert_eq!(read.names(), ["H\u{f6}he[1,2]", "\u{6c34}\u{6df1}"]);
    assert_eq!(read.column("\u{6c34}\u{6df1}").unwrap()[10], 3.0);
    assert_eq!(read.column("H\u{f6}he[1,2]").unwrap(), read.column("\u{6c34}\u{6df1}").unwrap());
}

#[test]
fn negative_zero_and_values_that_are_none_yet_are_kept_as_they_are() {
    let folder = TempDir::new().unwrap();
    let (recording, _) = run(&Gain.fmu(), &Overrides::new().start_value("u", "-0.0"));
    assert!(recording.column("y").unwrap().iter().all(|y| y.to_bits() == (-0.0_f64).to_bits()));
    let fmu = with(&folder, Gain, "UNDEFINED_AT_FIRST");
    let (recording, warnings) = run(&fmu, &Overrides::new().start_value("u", 1));
    let y = recording.column("y").unwrap();
    assert!(y[0].is_nan() && y[1..].iter().all(|y| *y == 1.0), "{y:?} {warnings:?}");
}

#[test]
fn what_has_no_start_value_and_no_input_is_not_asked_for() {
    let folder = TempDir::new().unwrap();
    let changes = [("<Real start=\"0\" unit=\"m\"/>", "<Real unit=\"m\"/>")];
    let fmu = described(&folder, "REFUSES_NOTHING", &changes);
    let (recording, warnings) = run(&fmu, &Overrides::new());
    assert_eq!(recording.column("y").unwrap().len(), 11);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn what_cannot_be_read_back_is_taken_as_given() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "HIDES_STRINGS");
    let (recording, warnings) = run(&fmu, &Overrides::new().start_value("text", "three"));
    assert_eq!(recording.column("k").unwrap()[10], 5.0);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn an_fmu_may_log_in_every_call() {
    let folder = TempDir::new().unwrap();
    let fmu = with(&folder, Gain, "CHATTERS");
    let output = cosim(folder.path(), &["simulate", fmu.to_str().unwrap(), "--start-value=k=2"]);
    let reported = text(&output.stderr);
    assert!(output.status.success(), "{reported}");
    assert!(
        reported.contains("earlier messages are not kept") && reported.contains("get Real"),
        "{reported}"
    );
}

#[test]
fn a_nominal_value_of_zero_says_nothing() {
    let folder = TempDir::new().unwrap();
    let ball = Model::Ball;
    let zero = ball.varied(
        folder.path(),
        "initial=\"exact\"><Real start=\"1\"",
        "initial=\"exact\"><Real nominal=\"0.0\" start=\"1\"",
    );
    let heights = |fmu: &std::path::Path| {
        let system = System::single(fmu, &Overrides::new(), None).unwrap();
        let mut recording = Recording::new();
        system.run(&mut [&mut recording]).unwrap();
        recording.column("y").unwrap().to_vec()
    };
    assert_eq!(heights(&zero), heights(&ball.fmu()));
}

#[test]
fn a_run_without_outputs_warns_that_only_the_time_is_recorded() {
    let folder = TempDir::new().unwrap();
    let fmu = described(&folder, "NOTHING", &[("causality=\"output\"", "causality=\"local\"")]);
    let warnings =
        |overrides: &Overrides| System::single(&fmu, overrides, None).unwrap().warnings().to_vec();
    let [warning] = &warnings(&Overrides::new())[..] else { panic!() };
    assert!(warning.contains("--output-variable"), "{warning}");
    assert!(warnings(&Overrides::new().output_variables(["y"])).is_empty());
}
