//! Strings between components and in results.

use cosim::observe::{Continued, CsvRecorder, McapRecorder};
use cosim::{Algorithm, Observer, Overrides, Recording, Run, Snapshot, System};

use crate::command::{cosim, text};
use crate::formats::{Folder, component, connection, ssd, system};
use crate::models::Model::{Gain, Lag};

/// What `said` sends to `heard`, which passes it on, with the length as k.
pub(crate) fn talk(folder: &Folder) -> std::path::PathBuf {
    let last = "</ModelVariables>";
    let ports = "<ScalarVariable name=\"heard\" valueReference=\"1\" causality=\"input\" \
                 variability=\"discrete\"><String start=\"\"/></ScalarVariable><ScalarVariable \
                 name=\"said\" valueReference=\"2\" causality=\"output\" variability=\"discrete\">\
                 <String/></ScalarVariable></ModelVariables>";
    let with = |name: &str, define: &[&str]| {
        Gain.variant(&folder.path(name), define, |text| text.replace(last, ports))
    };
    let (teller, listener) = (with("teller.fmu", &["TELLS_TIME"]), with("listener.fmu", &[]));
    let ports = "heard:input:String said:output:String";
    let elements = [component("a", &teller, ports, ""), component("b", &listener, ports, "")];
    let wire = connection("a.said", "b.heard", "");
    folder.write("talk.ssd", &ssd(&system(&elements.concat(), &wire), ""))
}

fn recorded() -> Overrides {
    Overrides::new().output_variables(["b.said", "b.k", "a.said"]).start_value("a.text", "begin")
}

fn last(recording: &Recording, name: &str) -> String {
    recording.text(name).unwrap().last().unwrap().to_string()
}

#[test]
fn strings_pass_as_other_values_do() {
    let folder = Folder::new();
    let file = talk(&folder);
    for (algorithm, heard) in [(Algorithm::GaussSeidel, "1.0 s"), (Algorithm::Jacobi, "0.9 s")] {
        let system = System::load(&file, &recorded().algorithm(algorithm)).unwrap();
        let mut recording = Recording::new();
        system.run(&mut [&mut recording]).unwrap();
        assert_eq!(&*recording.text("a.said").unwrap()[0], "begin");
        assert_eq!(&*recording.text("b.said").unwrap()[0], "begin");
        assert_eq!(last(&recording, "a.said"), "1.0 s, \"said\"");
        assert_eq!(last(&recording, "b.said"), format!("{heard}, \"said\""));
        assert_eq!(*recording.column("b.k").unwrap().last().unwrap(), 13.0);
    }
    // Also by a pattern; unless requested, no String is recorded.
    let names = |overrides: &Overrides| {
        let system = System::load(&file, overrides).unwrap();
        system.columns().iter().map(|c| c.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(names(&Overrides::new().output_variable("?.said")), ["a.said", "b.said"]);
    assert!(!names(&Overrides::new()).contains(&"a.said".to_owned()));
}

#[test]
fn files_hold_strings_and_their_digest_is_one() {
    let folder = Folder::new();
    let system = System::load(talk(&folder), &recorded()).unwrap();
    let mut recording = Recording::new();
    let (csv, mcap) = (folder.path("x.csv"), folder.path("x.mcap"));
    let mut to_csv = CsvRecorder::create(&csv).unwrap();
    let mut to_mcap = McapRecorder::create(&mcap).unwrap();
    system.run(&mut [&mut recording, &mut to_csv, &mut to_mcap]).unwrap();
    let written = std::fs::read_to_string(&csv).unwrap();
    assert!(written.contains("\n0.0,\"begin\",5.0,\"begin\"\n"), "{written}");
    assert!(written.contains("0.1,\"0.1 s, \"\"said\"\"\",13.0,"), "{written}");
    for file in [&csv, &mcap] {
        let read = cosim::observe::read(file).unwrap();
        assert_eq!(read.text("b.said").unwrap(), recording.text("b.said").unwrap());
        assert_eq!(read.digest().unwrap().text(), recording.digest().unwrap().text());
    }
    std::fs::write(folder.path("y.csv"), written.replace("begin", "start")).unwrap();
    let output = cosim(folder.0.path(), &["verify", "x.csv", "y.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let reported = text(&output.stdout);
    assert!(reported.contains("b.said: \"begin\" and \"start\""), "{reported}");
    assert!(cosim(folder.0.path(), &["verify", "x.csv", "x.mcap"]).status.success());
    assert!(cosim(folder.0.path(), &["report", "x.csv"]).status.success());
}

#[test]
fn a_run_with_strings_goes_on_from_its_snapshots() {
    let folder = Folder::new();
    let system = System::load(talk(&folder), &recorded()).unwrap();
    let (whole, resumed) = (folder.path("whole.csv"), folder.path("resumed.csv"));
    let mut recorder = CsvRecorder::create(&whole).unwrap();
    let mut kept = None;
    let mut keep = |snapshot: Snapshot| {
        kept = Some(snapshot);
        Ok(())
    };
    let at = cosim::Time::from_seconds(0.5);
    Run::new(&system).observe(&mut recorder).snapshots(None, &[at], &mut keep).go().unwrap();
    let file = folder.path("x.snapshot");
    kept.unwrap().write(&file).unwrap();
    // Another process has other numbers: this one has assigned more since then.
    cosim::texts::number("a text that was not used before");
    let old = Recording::read_csv(&whole).unwrap();
    let recorder: Box<dyn Observer> = Box::new(CsvRecorder::create(&resumed).unwrap());
    let mut continued = Continued::new(recorder, old);
    let snapshot = Snapshot::read(&file).unwrap();
    Run::new(&system).observe(&mut continued).resume(&snapshot).go().unwrap();
    assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(&resumed).unwrap());
    // In a process of its own.
    let arguments = ["run", "talk.ssd", "-q", "-o", "other.csv", "--start-value", "a.text=begin"];
    let columns = ["--output-variable=b.said", "--output-variable=b.k", "--output-variable=a.said"];
    let more = ["--resume", "x.snapshot"];
    std::fs::copy(&whole, folder.path("other.csv")).unwrap();
    let output = cosim(folder.0.path(), &[&arguments[..], &columns, &more].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(folder.path("other.csv")).unwrap());
}

/// The bytes of a run of the command line.
fn run(folder: &Folder, name: &str, more: &[&str]) -> Vec<u8> {
    let file = ["run", "talk.ssd", "-q", "-o", name, "--start-value", "a.text=begin"];
    let columns = ["--output-variable=b.said", "--output-variable=b.k", "--output-variable=a.said"];
    let output = cosim(folder.0.path(), &[&file[..], &columns, more].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    std::fs::read(folder.path(name)).unwrap()
}

#[test]
fn strings_pass_between_processes() {
    let folder = Folder::new();
    talk(&folder);
    for algorithm in ["gauss-seidel", "jacobi"] {
        let algorithm = ["--algorithm", algorithm];
        let here = run(&folder, "here.csv", &algorithm);
        assert!(String::from_utf8(here.clone()).unwrap().contains("said"));
        assert_eq!(here, run(&folder, "there.csv", &[&algorithm[..], &["--workers=2"]].concat()));
    }
    // A snapshot of several processes continues in one, and the other way round.
    let whole = run(&folder, "whole.csv", &[]);
    for (saved, resumed) in [(&["--workers=2"][..], &[][..]), (&[], &["--workers=2"])] {
        let snapshot = ["--snapshot-every=0.4", "--snapshot-file=s.snapshot"];
        assert_eq!(whole, run(&folder, "resumed.csv", &[saved, &snapshot].concat()));
        assert_eq!(
            whole,
            run(&folder, "resumed.csv", &[resumed, &["--resume=s.snapshot"]].concat())
        );
    }
}

#[test]
fn conditions_and_figures_are_about_numbers() {
    let folder = Folder::new();
    let file = talk(&folder);
    let refused = |arguments: &[&str]| {
        let output = cosim(folder.0.path(), arguments);
        let reported = text(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{reported}");
        assert!(reported.contains("E204") && reported.contains("'b.said'"), "{reported}");
    };
    let system = ["run", file.to_str().unwrap(), "-q", "--output-variable=b.said"];
    refused(&[&system[..], &["--stop-when=b.said > 1"]].concat());
    folder.write("f.toml", "[[fault]]\nkind = \"stuck\"\non = \"b.u\"\nwhen = \"b.said > 1\"\n");
    refused(&[&system[..], &["--scenario=f.toml"]].concat());
    let figure = "[figures]\nlast = { kind = \"final\", of = \"b.said\" }\n";
    let head = "seeds = 2\n[systems]\ntalk = \"talk.ssd\"\n";
    folder.write("c.toml", &format!("{head}{figure}"));
    refused(&["campaign", "c.toml", "-q"]);
    let other = "[figures]\nlast = { kind = \"final\", of = \"b.k\" }\n";
    folder.write("c.toml", &format!("stop-when = \"b.said > 1\"\n{head}{other}"));
    refused(&["campaign", "c.toml", "-q"]);
    folder.write("r.csv", "time,b.said\n0,\"on\"\n");
    folder.write("figures.toml", figure);
    refused(&["score", "--figures=figures.toml", "r.csv"]);
    folder.write("r.csv", "\"time\",\"b.said\"\n\"0\",\"2.5\"\n");
    let output = cosim(folder.0.path(), &["score", "--figures=figures.toml", "r.csv"]);
    assert!(text(&output.stdout).contains("2.500000"), "{}", text(&output.stdout));
}

#[test]
fn a_text_of_model_exchange_is_the_same_one_in_another_process() {
    let folder = Folder::new();
    let last = "</ModelVariables>";
    let said = "<ScalarVariable name=\"said\" valueReference=\"2\" causality=\"output\" \
                variability=\"discrete\"><String/></ScalarVariable></ModelVariables>";
    let teller = Gain.variant(&folder.path("teller.fmu"), &[], |text| text.replace(last, said));
    let heard = "<ScalarVariable name=\"heard\" valueReference=\"1\" causality=\"input\" \
                 variability=\"discrete\"><String start=\"\"/></ScalarVariable><ScalarVariable \
                 name=\"count\" valueReference=\"2\" causality=\"output\" variability=\"discrete\">\
                 <Integer/></ScalarVariable></ModelVariables>";
    let listener = folder.path("listener.fmu");
    let listener = Lag.variant(&listener, &["COUNTS_TEXTS"], |text| text.replace(last, heard));
    let elements = [
        component("a", &teller, "said:output:String", ""),
        component("b", &listener, "heard:input:String count:output:Integer", ""),
    ];
    let wire = connection("a.said", "b.heard", "");
    folder.write("talk.ssd", &ssd(&system(&elements.concat(), &wire), ""));
    let run = |more: &[&str]| {
        let fixed = ["run", "talk.ssd", "-q", "-o", "out.csv", "--output-variable=b.count"];
        let output = cosim(folder.0.path(), &[&fixed[..], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        std::fs::read_to_string(folder.path("out.csv")).unwrap()
    };
    let text = "--start-value=a.text=on";
    let whole = run(&[text, "--snapshot-every=0.4", "--snapshot-file=s.snapshot"]);
    // It is set before the run, and stays the same.
    assert!(whole.ends_with("1.0,0\n"), "{whole}");
    let snapshot = Snapshot::read(folder.path("s.snapshot")).unwrap();
    // Here, other texts have the first numbers.
    cosim::texts::number("a text that only this process has");
    let overrides = Overrides::new().start_value("a.text", "on").output_variable("b.count");
    let system = System::load(folder.path("talk.ssd"), &overrides).unwrap();
    let old = Recording::read_csv(folder.path("out.csv")).unwrap();
    let recorder: Box<dyn Observer> =
        Box::new(CsvRecorder::create(folder.path("resumed.csv")).unwrap());
    let mut continued = Continued::new(recorder, old);
    Run::new(&system).observe(&mut continued).resume(&snapshot).go().unwrap();
    assert_eq!(std::fs::read_to_string(folder.path("resumed.csv")).unwrap(), whole);
}
