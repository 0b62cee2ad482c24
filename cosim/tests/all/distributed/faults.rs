//! FMUs that crash, hang or fail: component, time and last call are named.

use super::*;

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
fn one_that_is_fatal_each_time_ends_the_run_that_was_to_be_resumed() {
    let (code, stderr) = run(&["FATAL"], &["--on-fatal", "resume"]);
    assert_eq!(code, 1, "{stderr}");
    for part in ["E502", "fmi2DoStep of 'b' failed at t = 0.5 s", "its FMU is at fault"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
}

#[test]
fn one_that_is_fatal_once_is_resumed_where_that_is_wanted() {
    let folder = TempDir::new().unwrap();
    let system =
        with(folder.path(), 2.0, &["FIRST_INCARNATION=return 4"], |description| description);
    let here = undisturbed(folder.path(), &system);
    for (more, code) in [(&["--on-fatal", "resume"][..], 0), (&["--on-fatal", "end"], 1)] {
        let arguments = ["run", &system, "-o", "there.csv", "--workers", "2"];
        let (found, stderr) = outcome(folder.path(), &[&arguments[..], more].concat());
        assert_eq!(found, code, "{stderr}");
        assert!(stderr.contains("fmi2DoStep of 'b' failed at t = 0.5 s"), "{stderr}");
        assert_eq!(stderr.contains("went on at worker"), code == 0, "{stderr}");
        assert_eq!(here == results(folder.path(), "there.csv"), code == 0);
    }
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn one_for_another_machine_is_reported_once_and_leaves_nothing() {
    use crate::models::pack;
    let folder = TempDir::new().unwrap();
    let system = with(folder.path(), 2.0, &[], |description| description);
    let description = Model::Gain.description().into_bytes();
    let mut arm = std::fs::read(folder.path().join("clumsy.so")).unwrap();
    arm[18..20].copy_from_slice(&183_u16.to_le_bytes());
    for (binary, bytes, why) in [
        ("binaries/linux64/GAIN.so", arm.clone(), "built for aarch64"),
        ("binaries/aarch64-linux/GAIN.so", arm, "it has binaries for: aarch64-linux"),
        ("binaries/win64/GAIN.dll", b"MZ".to_vec(), "it has binaries for: win64"),
    ] {
        let entries = [("modelDescription.xml", description.clone()), (binary, bytes)];
        pack(&folder.path().join("clumsy.fmu"), &entries);
        let arguments = ["run", &system, "-o", "x.csv", "--workers", "2"];
        let (code, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(code, 3, "{stderr}");
        for part in [why, "on worker worker-", "clumsy.fmu"] {
            assert!(stderr.contains(part), "{part}: {stderr}");
        }
        assert_eq!(stderr.matches("error:").count(), 1, "{stderr}");
        assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
    }
}

#[test]
fn a_component_is_where_its_file_says_and_rather_where_the_command_line_says() {
    let folder = TempDir::new().unwrap();
    let system = with(folder.path(), 2.0, &["FATAL"], |description| description);
    let text = std::fs::read_to_string(&system).unwrap();
    // Its failure reports where it was.
    let annotation = "<ssd:Annotations><ssc:Annotation type='cosim'><cosim:Component worker='far'/>\
                      </ssc:Annotation></ssd:Annotations>";
    let after = text.find("name='b'").unwrap();
    let end = after + text[after..].find("</ssd:Component>").unwrap();
    std::fs::write(&system, [&text[..end], annotation, &text[end..]].concat()).unwrap();
    for (more, place) in [
        (&[][..], "on worker far)"),
        (&["--place", "b=worker-1"], "on worker worker-1)"),
        (&["--place", "clock=far", "--place", "x=worker-1"], "on worker far)"),
    ] {
        let arguments = ["run", &system, "-q", "-o", "x.csv", "--workers", "2"];
        let (code, stderr) = outcome(folder.path(), &[&arguments[..], more].concat());
        assert_eq!(code, 1, "{stderr}");
        assert!(stderr.contains(place), "{more:?}: {stderr}");
    }
    // No other worker may replace one that was requested by name.
    let arguments = ["run", &system, "-q", "-o", "x.csv", "--workers", "2", "--place", "b=fat"];
    let (code, stderr) = outcome(folder.path(), &[&arguments[..], &["--wait", "1"]].concat());
    assert_eq!(code, 2, "{stderr}");
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn one_that_crashes_once_is_resumed() {
    let folder = TempDir::new().unwrap();
    let system =
        with(folder.path(), 2.0, &["FIRST_INCARNATION=abort()"], |description| description);
    let here = undisturbed(folder.path(), &system);
    let arguments = ["run", &system, "-o", "there.csv", "--workers", "2"];
    let (code, stderr) = outcome(folder.path(), &arguments);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("SIGABRT") && stderr.contains("went on at"), "{stderr}");
    assert!(here == results(folder.path(), "there.csv"));
}

#[test]
fn one_that_cannot_be_saved_is_computed_again_unless_that_is_refused() {
    let folder = TempDir::new().unwrap();
    let mute = |description: String| description.replace("canSerializeFMUstate=\"true\"", "");
    let system = with(folder.path(), 2.0, &["FIRST_INCARNATION=abort()"], mute);
    let here = undisturbed(folder.path(), &system);
    for (more, code) in [(&[][..], 0), (&["--require-resume"], 1)] {
        let arguments = ["run", &system, "-o", "there.csv", "--workers", "1"];
        let (found, stderr) = outcome(folder.path(), &[&arguments[..], more].concat());
        assert_eq!(found, code, "{stderr}");
        assert!(stderr.contains("SIGABRT"), "{stderr}");
        match code {
            0 => assert!(here == results(folder.path(), "there.csv")),
            _ => assert!(stderr.contains("--require-resume"), "{stderr}"),
        }
    }
}

#[test]
fn one_that_logs_much_is_heard_to_the_end_and_not_taken_for_lost() {
    for _ in 0..5 {
        let (code, stderr) = run(&["PRINTF"], &[]);
        assert_eq!(code, 0, "{stderr}");
        assert!(stderr.len() > 16_000 && !stderr.contains("lost"), "{stderr}");
    }
}
