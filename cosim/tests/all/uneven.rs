//! Steps that divide neither the second nor the run.

use cosim::observe::{Continued, CsvRecorder};
use cosim::{Code, Overrides, Recording, Run, Snapshot, System};
use tempfile::TempDir;

use crate::command::{cosim, text};
use crate::distributed::{outcome, results};
use crate::export::export;
use crate::models::Model::{Clock, Counter, Gain, Integrator, Lag, Ticker};
use crate::ssd::{Ssd, run};

const THIRTIETH: f64 = 1.0 / 30.0;
const FIXED: (&str, &str) = ("canHandleVariableCommunicationStepSize=\"true\"", "");

/// Thirtieths, sixtieths, hundredths and model exchange.
fn rates() -> Ssd {
    Ssd::new()
        .add_with("slow", Counter, &[], Some(THIRTIETH))
        .add_with("fast", Integrator, &[], Some(THIRTIETH / 2.0))
        .add_with("clock", Clock, &[], Some(0.01))
        .add_with("lag", Lag, &[], Some(THIRTIETH))
        .add_with("ticks", Ticker, &[("k", THIRTIETH)], Some(THIRTIETH))
        .connect("clock.y", "fast.u")
        .connect("slow.y", "lag.u")
        .master(&format!("outputInterval='{THIRTIETH}'"))
        .stop(2.0)
}

#[test]
fn steps_of_a_thirtieth_neither_drift_nor_part() {
    let folder = TempDir::new().unwrap();
    let fmu = Gain.variant(&folder.path().join("g.fmu"), &["THIRTIETHS"], |text| {
        text.replace(
            "stopTime=\"1\" stepSize=\"0.1\"",
            "stopTime=\"1000\" stepSize=\"0.03333333333333333\"",
        )
    });
    let system = System::single(&fmu, &Overrides::new(), None).unwrap();
    let mut recording = Recording::new();
    let summary = system.run(&mut [&mut recording]).unwrap();
    assert_eq!((summary.steps, recording.time().len()), (30_000, 30_001));
    assert_eq!((recording.time()[1], recording.time()[3000]), (0.033_333_333, 100.0));
    // An event of model exchange at each instant is seen at that instant.
    let recording = run(&rates().load(&Overrides::new()).unwrap());
    let last = |name: &str| *recording.column(name).unwrap().last().unwrap();
    assert_eq!((last("slow.y"), last("ticks.n")), (60.0, 61.0));
    assert_eq!(recording.time().len(), 61);
}

#[test]
fn the_last_step_is_shorter() {
    let folder = TempDir::new().unwrap();
    let arguments =
        ["simulate", Clock.fmu().to_str().unwrap(), "--step-size", "0.007", "--stop-time", "10"]
            .map(str::to_owned);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let output = cosim(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let found = Recording::read_csv(folder.path().join("CLOCK_out.csv")).unwrap();
    let (time, y) = (found.time(), found.column("y").unwrap());
    assert_eq!((time.len(), &time[1427..]), (1430, &[9.989, 9.996, 10.0][..]));
    assert!((y[1429] - 10.0).abs() < 1e-12 && (y[1428] - 9.996).abs() < 1e-9, "{:?}", &y[1427..]);
    // So do several together, and the inputs they hold are those at the start of the shorter step.
    let ssd =
        Ssd::new().add("clock", Clock).add("x", Integrator).connect("clock.y", "x.u").stop(0.25);
    let results = ssd.run();
    assert_eq!(results.time(), [0.0, 0.1, 0.2, 0.25]);
    let x = results.column("x.y").unwrap();
    assert!((x[3] - (0.1 * 0.1 + 0.2 * 0.05)).abs() < 1e-12, "{x:?}");
}

#[test]
fn a_component_that_cannot_make_a_shorter_step_is_named_and_keeps_its_values() {
    let folder = TempDir::new().unwrap();
    let fixed = Clock.varied(folder.path(), FIXED.0, FIXED.1);
    let ssd = Ssd::new().add("a", Clock).add("b", Clock).stop(0.25);
    let system = ssd.load(&Overrides::new().replace("b", &fixed)).unwrap();
    assert!(
        system.warnings()[0].contains("the last step of 'b' ends at 0.2 s"),
        "{:?}",
        system.warnings()
    );
    let results = run(&system);
    let last = |name: &str| *results.column(name).unwrap().last().unwrap();
    assert!((last("a.y") - 0.25).abs() < 1e-12 && (last("b.y") - 0.2).abs() < 1e-12);
    // If no component can, the run ends earlier.
    let stop = |seconds| Overrides::new().stop_time(seconds);
    let alone = System::single(&fixed, &stop(0.25), None).unwrap();
    assert!(alone.warnings()[0].contains("the run ends at 0.2 s"), "{:?}", alone.warnings());
    assert_eq!(run(&alone).time(), [0.0, 0.1, 0.2]);
    let error = System::single(&fixed, &stop(0.05), None).err().unwrap();
    assert_eq!(error.code(), Code::Timing);
    assert!(error.to_string().contains("--stop-time 0.1"), "{error}");
}

#[test]
fn however_it_is_run_the_bytes_are_the_same() {
    for stop in [2.0, 1.99] {
        let (ssd, folder) = (rates().stop(stop), TempDir::new().unwrap());
        let (file, at) = (ssd.write(), folder.path());
        let path = file.to_str().unwrap();
        let (code, stderr) = outcome(at, &["run", path, "-q", "-o", "here.csv"]);
        assert_eq!(code, 0, "{stderr}");
        let here = results(at, "here.csv");
        let arguments = ["run", path, "-q", "-o", "there.csv", "--workers", "3"];
        let (code, stderr) = outcome(at, &arguments);
        assert_eq!(code, 0, "{stderr}");
        assert!(here == results(at, "there.csv"), "{stop}: distributed");
        let system = ssd.load(&Overrides::new()).unwrap();
        let mut taken: Vec<Snapshot> = Vec::new();
        let mut keep = |snapshot: Snapshot| {
            taken.push(snapshot);
            Ok(())
        };
        let every = cosim::Time::from_seconds(0.5);
        Run::new(&system).snapshots(Some(every), &[], &mut keep).go().unwrap();
        assert!(taken.len() > 2);
        for snapshot in taken.iter().filter(|taken| taken.time() < system.stop_time()) {
            let old = Recording::read_csv(at.join("here.csv")).unwrap();
            let recorder = Box::new(CsvRecorder::create(at.join("resumed.csv")).unwrap());
            let mut continued = Continued::new(recorder, old);
            Run::new(&system).observe(&mut continued).resume(snapshot).go().unwrap();
            assert!(here == results(at, "resumed.csv"), "{stop}: from {}", snapshot.time());
        }
    }
    // As one FMU, at instants of its own and of its host.
    let ssd = rates();
    let wanted = run(&ssd.load(&Overrides::new()).unwrap());
    let exported = export(&ssd.write(), &[]);
    for step in [THIRTIETH, 0.1, 0.5] {
        let found =
            run(&System::single(&exported.fmu, &Overrides::new().step("", step), None).unwrap());
        for (sample, time) in found.time().iter().enumerate() {
            let place = wanted.time().iter().position(|t| t == time).unwrap();
            for (name, values) in found.columns() {
                let other = wanted.column(name).unwrap()[place];
                assert_eq!(values[sample].to_bits(), other.to_bits(), "{name} at {time}");
            }
        }
    }
}

#[test]
fn a_step_for_all_components_and_patterns_of_names() {
    let ssd = Ssd::new().add("a1", Counter).add("a2", Counter).add("b", Counter);
    let steps = |overrides: Overrides| -> Vec<f64> {
        let system = ssd.load(&overrides).unwrap();
        system.components().iter().map(|component| component.step.seconds()).collect()
    };
    let all = Overrides::new().step("", 0.05);
    assert_eq!(steps(all.clone()), [0.05, 0.05, 0.05]);
    assert_eq!(steps(all.clone().step("a*", 0.2)), [0.2, 0.2, 0.05]);
    assert_eq!(steps(Overrides::new().step("a1", 0.5).step("*", 0.25)), [0.5, 0.25, 0.25]);
    let error = ssd.load(&Overrides::new().step("c*", 0.1)).err().unwrap();
    assert_eq!(error.code(), Code::UnknownName);
    let folder = TempDir::new().unwrap();
    let file = ssd.write();
    let arguments = ["run", file.to_str().unwrap(), "--step-size=0.3", "--step=*2=0.1", "-q"];
    let output = cosim(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn an_interval_of_the_file_gives_way_to_other_steps() {
    let ssd = Ssd::new().add("a", Counter).master("outputInterval='0.1'");
    let system = ssd.load(&Overrides::new().step("", 0.03)).unwrap();
    assert_eq!(system.output_interval().seconds(), 0.12);
    assert!(system.notes()[0].contains("recorded every 0.12 s instead of 0.1 s"));
    let asked = Overrides::new().step("", 0.03).output_interval(0.1);
    assert_eq!(ssd.load(&asked).err().unwrap().code(), Code::Timing);
    // For a single FMU the step is only a suggestion.
    let finer = Overrides::new().output_interval(0.25);
    let system = System::single(&Clock.fmu(), &finer, None).unwrap();
    assert_eq!(system.components()[0].step.seconds(), 0.25 / 3.0);
}

#[test]
fn steps_need_no_common_base() {
    let odd = 0.033_333_3;
    let ssd = Ssd::new()
        .add("clock", Clock)
        .add_with("odd", Counter, &[], Some(odd))
        .add_with("x", Integrator, &[], Some(odd))
        .connect("clock.y", "x.u");
    let system = ssd.load(&Overrides::new()).unwrap();
    assert_eq!(system.output_interval().seconds(), odd);
    let found = run(&system);
    // Each makes its own steps, with the values that the others had at their starts.
    let last = |name: &str| *found.column(name).unwrap().last().unwrap();
    assert_eq!((found.time().len(), last("odd.y")), (31, 30.0));
    let sum: f64 = (0..30).map(|k| (f64::from(k) * odd * 10.0 + 1e-9).floor() * 0.1 * odd).sum();
    assert!((last("x.y") - sum).abs() < 1e-12, "{} {sum}", last("x.y"));
    let asked = ssd.load(&Overrides::new().output_interval(0.25)).unwrap();
    assert_eq!(run(&asked).time(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    let (file, folder) = (ssd.write(), TempDir::new().unwrap());
    let outcome = |more: &[&str]| {
        outcome(folder.path(), &[&["run", file.to_str().unwrap(), "-q"], more].concat())
    };
    assert_eq!(outcome(&["-o", "here.csv"]).0, 0);
    assert_eq!(outcome(&["-o", "there.csv", "--workers=3"]).0, 0);
    assert!(results(folder.path(), "here.csv") == results(folder.path(), "there.csv"));
}

#[test]
fn where_no_step_ends_the_last_ones_are_shorter() {
    let folder = TempDir::new().unwrap();
    let rates = Ssd::new()
        .add_with("a", Clock, &[], Some(0.2))
        .add_with("b", Clock, &[], Some(0.3))
        .add_with("x", Integrator, &[], Some(0.3))
        .connect("a.y", "x.u")
        .stop(0.7);
    for interval in [0.1, 0.2] {
        let system = rates.load(&Overrides::new().output_interval(interval)).unwrap();
        assert!(system.ends_by_shorter_steps());
        let found = run(&system);
        let last = |name: &str| *found.column(name).unwrap().last().unwrap();
        let times = found.time();
        assert_eq!(times.last(), Some(&0.7));
        assert!(times[times.len() - 2] < 0.7, "{times:?}");
        for clock in ["a.y", "b.y"] {
            assert!((last(clock) - 0.7).abs() < 1e-12, "{clock}: {}", last(clock));
        }
        // Its inputs at 0, 0.3 and 0.6 s.
        let x = 0.3 * 0.2 + 0.1 * 0.6;
        assert!((last("x.y") - x).abs() < 1e-12, "{} {x}", last("x.y"));
        let file = rates.write();
        let interval = format!("--output-interval={interval}");
        for (name, more) in [("here.csv", &[][..]), ("there.csv", &["--workers=3"])] {
            let arguments = ["run", file.to_str().unwrap(), "-q", "-o", name, &interval];
            let (code, stderr) = outcome(folder.path(), &[&arguments[..], more].concat());
            assert_eq!(code, 0, "{stderr}");
        }
        assert!(results(folder.path(), "here.csv") == results(folder.path(), "there.csv"));
    }
    let fixed = Clock.varied(folder.path(), FIXED.0, FIXED.1);
    let fixed = Overrides::new().replace("a", &fixed).replace("b", &fixed).without("x");
    let system = rates.load(&fixed).unwrap();
    assert!(system.warnings()[0].contains("the run ends at 0.6 s"), "{:?}", system.warnings());
    // A step that ends there leaves the others as they are.
    assert!(!rates.load(&Overrides::new().stop_time(0.8)).unwrap().ends_by_shorter_steps());
}
