//! The binary: exit codes, what goes to stdout and to stderr.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

use crate::formats::Folder;
use crate::models::Model;
use crate::ssd::Ssd;

pub(crate) fn cosim(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .unwrap()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Exit code and stderr.
fn outcome(arguments: &[&str]) -> (i32, String) {
    let folder = TempDir::new().unwrap();
    let output = cosim(folder.path(), arguments);
    (output.status.code().unwrap(), text(&output.stderr))
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_run_writes_its_results_and_nothing_to_stdout() {
    let ssd = Ssd::new().add("clock", Model::Clock).add("g", Model::Gain).connect("clock.y", "g.u");
    let (file, folder) = (ssd.write(), TempDir::new().unwrap());
    let output = cosim(
        folder.path(),
        &[
            "run",
            path(&file),
            "--start-value",
            "g.k=2",
            "--output-variable",
            "g.?",
            "--output-dir",
            "a/b",
            "--stop-time=0.2",
        ],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stdout.is_empty());
    assert!(text(&output.stderr).contains("results in a/b/test_out.csv"));
    let results = std::fs::read_to_string(folder.path().join("a/b/test_out.csv")).unwrap();
    assert_eq!(
        results,
        "time,g.u,g.k,g.y,g.m,g.n\n0.0,0.0,2.0,0.0,0,0\n0.1,0.1,2.0,0.2,0,0\n0.2,0.2,2.0,0.4,0,0\n"
    );
}

#[test]
fn results_on_stdout_when_asked_and_silence_when_quiet() {
    let fmu = Model::Clock.fmu();
    let folder = TempDir::new().unwrap();
    let arguments = ["simulate", path(&fmu), "-q", "-o", "-", "--output-interval", "0.5"];
    let output = cosim(folder.path(), &[&arguments[..], &["--output-variable", "y"]].concat());
    assert_eq!(text(&output.stdout), "time,y\n0.0,0.0\n0.5,0.5\n1.0,1.0\n");
    assert!(output.stderr.is_empty());
}

#[test]
fn one_fmu_with_inputs_of_a_file() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("in.csv"), "time,u\n0,0\n1,10\n").unwrap();
    let fmu = Model::Integrator.fmu();
    let arguments = [
        "simulate",
        path(&fmu),
        "--input-file",
        "in.csv",
        "--output-variable",
        "y",
        "--start-value",
        "second=1",
        "--stop-time",
        "0.3",
        "-o",
        "out.csv",
    ];
    let output = cosim(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let results = cosim::Recording::read_csv(folder.path().join("out.csv")).unwrap();
    crate::ssd::assert_near(results.column("y").unwrap(), &[1.0, 1.0, 1.1, 1.3]);
    std::fs::write(folder.path().join("in.csv"), "time,uu\n0,0\n").unwrap();
    let output = cosim(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("did you mean 'u'?"));
}

#[test]
fn inputs_of_a_file_may_be_in_quotes_and_are_numbers() {
    let folder = Folder::new();
    let heard = "<ScalarVariable name=\"heard\" valueReference=\"1\" causality=\"input\" \
                 variability=\"discrete\"><String start=\"\"/></ScalarVariable></ModelVariables>";
    let fmu = folder.fmu(Model::Gain, "gain", &[("</ModelVariables>", heard)]);
    let run = |input: &str| {
        folder.write("in.csv", input);
        let arguments = ["simulate", path(&fmu), "--input-file=in.csv", "-q", "-o", "out.csv"];
        let output = cosim(folder.0.path(), &arguments);
        (output.status.code().unwrap(), text(&output.stderr))
    };
    for quoted in ["\"time\",\"u\"\r\n\"0\",\"1.5\"\r\n", "time,u\n0,\"1.5\"\n1,\"1.5\"\n"] {
        let (code, reported) = run(quoted);
        assert_eq!(code, 0, "{reported}");
        let results = cosim::Recording::read_csv(folder.path("out.csv")).unwrap();
        assert_eq!(results.column("y").unwrap().last(), Some(&1.5), "{quoted}");
    }
    let (code, reported) = run("time,u\n0,\"1\"\n0.5,\"much\"\n");
    assert!(code == 3 && reported.contains("E204"), "{reported}");
    let why = "it has \"much\" at t = 0.5 (sample 2), which is not a number";
    assert!(reported.contains("column 'u'") && reported.contains(why), "{reported}");
    let (code, reported) = run("time,heard\n0,\"much\"\n");
    assert!(code == 3 && reported.contains("the input is a String"), "{reported}");
}

#[test]
fn exit_codes_show_what_kind_of_failure() {
    let good = Ssd::new().add("g", Model::Gain);
    let file = good.write();
    let failing = Ssd::new().add_with("g", Model::Failing, &[("second", 0.5)], None);
    let failing = failing.write();
    for (arguments, code, part) in [
        (&["run", "missing.ssd"][..], 3, "missing.ssd"),
        (&["run", path(&file), "--start-value", "g.k"], 2, "NAME=VALUE"),
        (&["run", path(&file), "--start-value", "g.kk=1"], 3, "did you mean 'k'?"),
        (&["run", path(&file), "--step", "g=0"], 3, "at least one nanosecond"),
        (&["run", path(&file), "--algorithm", "magic"], 2, "jacobi"),
        (&["run", path(&file), "--output-file", "no/such/folder.csv"], 1, "no/such/folder.csv"),
        (&["run", path(&file), "--output-file", "x.parq"], 2, "ends in .csv, .mcap or .parquet"),
        (&["run", path(&failing)], 1, "the results until then are in test_out.csv"),
        (&["simulate", path(&file)], 3, "ZIP"),
        (&["nonsense"], 2, "nonsense"),
        (&[], 2, "Usage"),
        (&["report", "missing.csv"], 3, "missing.csv"),
        (&["explain", "E999"], 2, "E999"),
    ] {
        let (found, stderr) = outcome(arguments);
        assert_eq!(found, code, "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    }
}

#[test]
fn a_failing_run_keeps_its_results() {
    let ssd = Ssd::new().add_with("g", Model::Failing, &[("second", 0.35)], None);
    let (file, folder) = (ssd.write(), TempDir::new().unwrap());
    let arguments = ["run", path(&file), "--output-variable", "g.y", "-o", "kept.csv"];
    assert_eq!(cosim(folder.path(), &arguments).status.code(), Some(1));
    let results = cosim::Recording::read_csv(folder.path().join("kept.csv")).unwrap();
    crate::ssd::assert_near(results.time(), &[0.0, 0.1, 0.2, 0.3]);
}

#[test]
fn info_is_readable_by_programs() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Gain.fmu();
    let output = cosim(folder.path(), &["info", path(&fmu), "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["variables"][0]["directFeedThrough"], true);
    assert_eq!(json["variables"][9]["items"][1][0], "Fast");
    let ssd = Ssd::new().add("g", Model::Gain).add("c", Model::Clock).connect("c.y", "g.u");
    let file = ssd.write();
    let output = cosim(folder.path(), &["info", path(&file), "--format=json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["connections"][0]["from"], "c.y");
    let output = cosim(folder.path(), &["info", path(&file)]);
    assert!(text(&output.stdout).contains("c.y -> g.u"));
}

#[test]
fn info_shows_platforms_and_what_can_be_done_with_states() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Gain.varied(folder.path(), "canSerializeFMUstate=\"true\"", "");
    let output = cosim(folder.path(), &["info", path(&fmu)]);
    let shown = text(&output.stdout);
    assert!(shown.contains("binaries for linux64\n"), "{shown}");
    assert!(shown.contains("co-simulation: its state can be saved, but not serialized"), "{shown}");
    let output = cosim(folder.path(), &["info", path(&fmu), "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["platforms"], serde_json::json!(["linux64"]));
    let capabilities = &json["capabilities"]["coSimulation"];
    assert_eq!(capabilities["canGetAndSetFMUstate"], true);
    assert_eq!(capabilities["canSerializeFMUstate"], false);
    assert!(json["capabilities"]["modelExchange"].is_null());
}

#[test]
fn inspect_shows_how_late_values_are_and_why() {
    let folder = TempDir::new().unwrap();
    let ssd = Ssd::new()
        .add("g", Model::Gain)
        .add_with("c", Model::Clock, &[], Some(0.3))
        .add("x", Model::Integrator)
        .add("l", Model::Gain)
        .connect("c.y", "g.u")
        .connect("g.y", "x.u")
        .connect("l.y", "l.u")
        .stop(0.6);
    let file = ssd.write();
    let inspect = |arguments: &[&str]| {
        let output = cosim(folder.path(), &[&["inspect", path(&file)], arguments].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let json: serde_json::Value = serde_json::from_str(&inspect(&["--format=json"])).unwrap();
    assert_eq!(json["order"][0]["name"], "c");
    let connections = &json["connections"];
    assert_eq!((&connections[0]["late"], &connections[0]["heldUpTo"]), (&0.0.into(), &0.2.into()));
    assert_eq!(connections[1]["late"], 0.1);
    for (position, reason) in [
        (0, "no delay: 'c' steps before 'g'; up to 0.2 s older because 'c' steps every 0.3 s"),
        (1, "because no output of 'x' depends on the input directly"),
        (2, "one step late (0.1 s) because 'l' feeds itself"),
    ] {
        let found = connections[position]["reason"].as_str().unwrap();
        assert!(found.contains(reason), "{found}");
    }
    let shown = inspect(&["--algorithm=jacobi"]);
    assert!(shown.contains("  c -> g: one step late (0.1 s) because Jacobi"), "{shown}");
    assert!(shown.contains("    y -> u"), "{shown}");
}

#[test]
fn every_code_is_explained() {
    let folder = TempDir::new().unwrap();
    let output = cosim(folder.path(), &["explain", "e203"]);
    assert!(text(&output.stdout).starts_with("E203  (exit code 3)"));
    for code in cosim::Code::ALL {
        let output = cosim(folder.path(), &["explain", code.as_str()]);
        let shown = text(&output.stdout);
        let (meaning, remedy) = shown.split_once('\n').unwrap();
        assert!(meaning.contains(code.explanation().trim()), "{shown}");
        assert_eq!(remedy.trim(), code.remedy());
    }
}

#[test]
fn a_report_of_a_run() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Clock.fmu();
    let simulate = cosim(folder.path(), &["simulate", path(&fmu), "-q", "-o", "r.csv"]);
    assert!(simulate.status.success());
    let report = cosim(folder.path(), &["report", "r.csv"]);
    assert!(report.status.success(), "{}", text(&report.stderr));
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(page.contains("id=\"data\"") && page.contains("</html>"));
}

#[test]
fn a_closed_pipe_ends_the_run_without_a_word() {
    use std::io::{BufRead, BufReader, Read};
    let fmu = Model::Clock.fmu();
    let mut child = Command::new(env!("CARGO_BIN_EXE_cosim"))
        .args(["simulate", path(&fmu), "-o", "-", "--stop-time", "1e6"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut header = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut header).unwrap();
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!((child.wait().unwrap().code(), stderr.as_str()), (Some(0), ""));
    assert!(header.starts_with("time,"));
}

#[test]
fn an_interrupted_run_keeps_its_results() {
    let (fmu, folder) = (Model::Clock.fmu(), TempDir::new().unwrap());
    // A shell makes background processes ignore SIGINT, and that is inherited.
    let mut child = Command::new("env")
        .args(["--default-signal=INT", env!("CARGO_BIN_EXE_cosim")])
        .args(["simulate", path(&fmu), "-o", "kept.csv", "--stop-time", "1e8"])
        .args(["--output-interval", "1000", "-q"])
        .current_dir(folder.path())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The file exists once the handler is installed, and grows when many rows are there.
    let file = folder.path().join("kept.csv");
    while std::fs::metadata(&file).map_or(0, |file| file.len()) < 1000 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let mut stderr = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut stderr).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{stderr}");
    assert!(stderr.contains("E303") && stderr.contains("kept.csv"), "{stderr}");
    assert!(cosim::Recording::read_csv(file).unwrap().time().len() > 1);
}

#[test]
fn validate_reports_all_problems_with_their_lines() {
    let folder = TempDir::new().unwrap();
    let ssd = Ssd::new().add("g", Model::Gain).add("c", Model::Clock).connect("c.y", "g.u");
    let file = ssd.write();
    let output = cosim(folder.path(), &["validate", path(&file)]);
    assert!(output.status.success() && text(&output.stdout).contains("is valid"));
    assert!(text(&output.stderr).contains("note: the input c.u is not connected"));
    assert!(!text(&output.stderr).contains("g.u is not connected"));
    let wrong = ssd.text().replace("startConnector='y'", "startConnector='yy'");
    let wrong = wrong.replace("stopTime='1'", "stopTime='0'");
    std::fs::write(folder.path().join("x.ssd"), wrong).unwrap();
    let output = cosim(folder.path(), &["validate", "x.ssd", "--format=json"]);
    assert_eq!(output.status.code(), Some(3));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["valid"], json["problems"].as_array().unwrap().len()), (&false.into(), 2));
    assert_eq!(
        (&json["problems"][0]["code"], &json["problems"][0]["line"]),
        (&"E202".into(), &33.into())
    );
    let output = cosim(folder.path(), &["validate", path(&Model::Lag.fmu())]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn what_is_wrong_with_a_run_is_reported_as_json_as_well() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Gain.fmu();
    let wrong = ["--start-value", "gian=1", "--start-value", "k=much", "--format=json"];
    let arguments = [&["simulate", path(&fmu)][..], &wrong].concat();
    let output = cosim(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(3));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let problems = json["problems"].as_array().unwrap();
    assert!(problems.iter().any(|problem| problem["code"] == "E202"), "{json}");
    assert_eq!(format!("error: {}\n", json["text"].as_str().unwrap()), text(&output.stderr));
}

#[test]
fn completion_and_manual_know_every_verb() {
    let folder = TempDir::new().unwrap();
    for arguments in [&["completion", "bash"][..], &["completion", "zsh"], &["man"]] {
        let output = cosim(folder.path(), arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        for verb in ["inspect", "validate", "simulate", "interface"] {
            assert!(text(&output.stdout).contains(verb), "{verb} in {arguments:?}");
        }
    }
}

#[test]
fn results_are_compared_within_tolerances() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("a.csv"), "time,m.x,m.y\n0,1,1\n1,2,5\n2,3,1\n").unwrap();
    std::fs::write(folder.path().join("b.csv"), "time,m.x,m.y\n0,1,1\n1,2.001,5.5\n").unwrap();
    let verify = |more: &[&str]| {
        let output = cosim(folder.path(), &[&["verify", "a.csv", "b.csv"], more].concat());
        (output.status.code().unwrap(), text(&output.stdout) + &text(&output.stderr))
    };
    let largest = "largest difference: m.y at t = 1: 5.0 and 5.5";
    let (code, reported) = verify(&[]);
    assert!(code == 1 && reported.contains(largest), "{reported}");
    let (code, reported) = verify(&["--abs", "0.01", "--abs", "m.y=1"]);
    assert!(code == 0 && reported.contains("near enough: 2 samples of 2 variables"), "{reported}");
    assert!(
        reported.contains(largest) && reported.contains("1 samples of a.csv have no partner"),
        "{reported}"
    );
    let (code, reported) = verify(&["--abs", "1", "--abs", "m.z=1"]);
    assert!(code == 3 && reported.contains("did you mean 'm.x'?"), "{reported}");
    let (code, reported) = verify(&["--rel", "0.05"]);
    assert!(code == 1 && reported.contains("1 of 2 variables are too far apart"), "{reported}");
    assert!(reported.contains("at 1 of 2 samples, first at t = 1: m.y"), "{reported}");
}

#[test]
fn results_are_interpolated_where_that_is_wanted() {
    let folder = Folder::new();
    folder.write("a.csv", "time,x\n0,0\n1,1\n2,2\n");
    folder.write("b.csv", "time,x\n0,0\n2,2.5\n");
    let verify = |more: &[&str]| {
        let output = cosim(folder.0.path(), &[&["verify", "a.csv", "b.csv"], more].concat());
        (output.status.code().unwrap(), text(&output.stdout))
    };
    let (code, reported) = verify(&["--abs=0.5"]);
    assert!(code == 0 && reported.contains("near enough: 2 samples"), "{reported}");
    let (code, reported) = verify(&["--abs=0.5", "--interpolate"]);
    assert!(code == 0 && reported.contains("near enough: 3 samples"), "{reported}");
    let (code, reported) = verify(&["--abs=0.2", "--interpolate"]);
    let first = "too far apart at 2 of 3 samples, first at t = 1: x at t = 2: 2.0 and 2.5";
    assert!(code == 1 && reported.contains(first), "{reported}");
}

#[test]
fn a_run_ends_when_its_condition_holds() {
    let folder = TempDir::new().unwrap();
    let fmu = Model::Clock.fmu();
    let run = |condition: &str| {
        let arguments = ["simulate", path(&fmu), "-o", "out.csv", "--stop-when", condition];
        let output = cosim(folder.path(), &arguments);
        (output.status.code().unwrap(), text(&output.stderr))
    };
    let (code, reported) = run("y >= 0.45");
    assert!(
        code == 0 && reported.contains("ended by --stop-when: y >= 0.45 at t = 0.5"),
        "{reported}"
    );
    let results = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert!(results.lines().last().unwrap().starts_with("0.5,"), "{results}");
    let (code, reported) = run("z = 1");
    assert!(code == 3 && reported.contains("'z' is not recorded"), "{reported}");
    let (code, reported) = run("y");
    assert!(code == 2 && reported.contains("has no comparison"), "{reported}");
}

#[test]
fn a_system_is_drawn() {
    let ssd = Ssd::new()
        .add("clock", Model::Clock)
        .add("g", Model::Gain)
        .add("x", Model::Integrator)
        .connect("clock.y", "g.u")
        .connect("g.y", "x.u")
        .connect("clock.n", "g.m");
    let (file, folder) = (ssd.write(), TempDir::new().unwrap());
    let draw = |format: &str| {
        let output = cosim(folder.path(), &["inspect", path(&file), "--format", format]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let dot = draw("dot");
    assert!(dot.contains("\"clock\" -> \"g\" [label=\"2 connections\""), "{dot}");
    assert!(dot.contains("\"g\" -> \"x\" [label=\"y \u{2192} u\"") && dot.contains("style=dashed"));
    let svg = draw("svg");
    cosim::xml::parse(&svg, Path::new("x.svg")).unwrap();
    assert_eq!(svg.matches("marker-end").count(), 2, "{svg}");
    assert_eq!(svg.matches(">every 0.1 s</text>").count(), 3, "{svg}");
}

#[test]
fn notes_on_sampled_loops_are_reported_where_loops_are_looked_at() {
    let folder = TempDir::new().unwrap();
    let y = "name=\"y\" valueReference=\"2\" causality=\"output\"";
    let sampled = Model::Gain.varied(folder.path(), y, &format!("{y} variability=\"discrete\""));
    let ssd = Ssd::new().add("a", Model::Gain).add("b", Model::Gain);
    let ssd = ssd.connect("b.y", "a.u").connect("a.y", "b.u");
    let (file, replace) = (ssd.write(), format!("b={}", sampled.display()));
    let reported = |command: &str| {
        text(&cosim(folder.path(), &[command, path(&file), "--replace", &replace]).stderr)
    };
    assert!(reported("inspect").contains("sampled loop through a, b"));
    assert!(!reported("run").contains("sampled loop"));
}
