//! FMUs that crash, spin or give up: component, time and last call are named.

use super::*;

/// A chain in which the FMU of `b` was compiled with `defines` and its description changed.
fn with(folder: &Path, stop: f64, defines: &[&str], change: impl Fn(String) -> String) -> String {
    let ssd = Ssd::new()
        .add("clock", Model::Clock)
        .add("b", Model::Gain)
        .add("x", Model::Integrator)
        .connect("clock.y", "b.u")
        .connect("b.y", "x.u")
        .stop(stop);
    let clumsy = Model::Gain.variant(&folder.join("clumsy.fmu"), defines, change);
    let good = Model::Gain.fmu();
    let text = ssd.text().replace(good.to_str().unwrap(), clumsy.to_str().unwrap());
    let file = folder.join("test.ssd");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

fn run(defines: &[&str], more: &[&str]) -> (i32, String) {
    let folder = TempDir::new().unwrap();
    let system = with(folder.path(), 2.0, defines, |description| description);
    let arguments = [&["run", &system, "-o", "x.csv", "--workers", "2"], more].concat();
    let (code, stderr) = outcome(folder.path(), &arguments);
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
    (code, stderr)
}

#[test]
fn one_that_aborts_is_named_with_its_last_call() {
    for more in [&["--recoveries", "0"][..], &[]] {
        let (code, stderr) = run(&["ABORTS"], more);
        assert_eq!(code, 1, "{stderr}");
        for part in ["E502", "SIGABRT", "in fmi2DoStep of 'b' at t = 0.5 s"] {
            assert!(stderr.contains(part), "{part}: {stderr}");
        }
        assert_eq!(stderr.contains("its FMU is at fault"), more.is_empty(), "{stderr}");
    }
}

#[test]
fn one_that_spins_is_named_with_how_long_it_was_waited_for() {
    let (code, stderr) = run(&["SPINS"], &["--deadline", "1", "--recoveries", "0"]);
    assert_eq!(code, 1, "{stderr}");
    for part in ["no answer to the step to t = 0.6 s for ", "in fmi2DoStep of 'b' at t = 0.5 s"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
}

#[test]
fn one_that_is_fatal_ends_the_run_as_in_one_process() {
    let (code, stderr) = run(&["FATAL"], &[]);
    assert_eq!(code, 1, "{stderr}");
    for part in ["fmi2DoStep of 'b' failed at t = 0.5 s", "returned Fatal", "on worker worker-"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
}

#[test]
fn one_that_crashes_once_is_resumed() {
    let folder = TempDir::new().unwrap();
    let system = with(folder.path(), 500.0, &[], |description| description);
    let here = undisturbed(folder.path(), &system);
    let arguments = ["run", &system, "-o", "there.csv", "--workers", "2"];
    let run = cosim(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let groups = groups_below(&run, 2);
    std::thread::sleep(Duration::from_millis(150));
    signal(groups[0], "-ABRT");
    let output = run.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("SIGABRT") && stderr.contains("went on at"), "{stderr}");
    assert!(here == results(folder.path(), "there.csv"));
}

#[test]
fn one_that_cannot_be_saved_is_computed_again_unless_that_is_refused() {
    let folder = TempDir::new().unwrap();
    let mute = |description: String| description.replace("canSerializeFMUstate=\"true\"", "");
    let system = with(folder.path(), 300.0, &[], mute);
    let here = undisturbed(folder.path(), &system);
    for (more, code) in [(&[][..], 0), (&["--require-resume"], 1)] {
        let arguments = ["run", &system, "-o", "there.csv", "--workers", "1"];
        let arguments = [&arguments[..], more].concat();
        let run = cosim(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
        let groups = groups_below(&run, 1);
        std::thread::sleep(Duration::from_millis(150));
        signal(groups[0], "-KILL");
        let output = run.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{stderr}");
        match code {
            0 => assert!(here == results(folder.path(), "there.csv")),
            _ => assert!(stderr.contains("--require-resume"), "{stderr}"),
        }
    }
}
