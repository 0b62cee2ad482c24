//! The run itself is killed: nothing continues without it, and it is resumed to the same bytes.

use super::*;

#[test]
fn a_killed_run_is_resumed_to_the_bytes_of_an_undisturbed_one() {
    let (file, folder) = (chain(1000.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let here = undisturbed(folder.path(), path);
    let digest = outcome(folder.path(), &["run", path, "-o", "again.csv"]).1;
    let digest = digest.lines().find(|line| line.starts_with("digest ")).unwrap().to_owned();
    let mut dice = Dice(21);
    for round in 0..3 {
        let common = ["run", path, "-o", "there.csv", "--workers", "2"];
        let saved = ["--snapshot-every", "5", "--snapshot-file", "s"];
        let _ = std::fs::remove_file(folder.path().join("s"));
        let mut arguments = [&common[..], &saved].concat();
        // Killed twice: the second time while it continues from what the first one left.
        for _ in 0..2 {
            let mut run = cosim(folder.path(), &arguments).stderr(Stdio::null()).spawn().unwrap();
            groups_below(&run, 2);
            let begun = Instant::now();
            while !folder.path().join("s").exists() && begun.elapsed() < Duration::from_secs(20) {
                std::thread::sleep(Duration::from_millis(2));
            }
            std::thread::sleep(Duration::from_millis(dice.below(150)));
            let started = below(run.id());
            signal(run.id(), "-KILL");
            run.wait().unwrap();
            assert!(remaining(&started).is_empty());
            arguments = [&common[..], &saved, &["--resume", "s"]].concat();
        }
        let (code, stderr) = outcome(folder.path(), &[&common[..], &["--resume", "s"]].concat());
        assert_eq!(code, 0, "round {round}: {stderr}");
        assert!(here == results(folder.path(), "there.csv"), "round {round}");
        assert!(stderr.contains(&digest), "{digest} {stderr}");
        let _ = std::fs::remove_file(folder.path().join("there.csv"));
    }
}

#[test]
fn workers_end_what_they_do_for_a_run_that_is_killed_and_serve_the_next() {
    let (file, folder) = (chain(1e6), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let place = endpoint();
    let run = |stop: &str| {
        let arguments = ["run", path, "-q", "-o", "x.csv", "--distributed", "--listen", &place];
        let more = ["--wait", "20", "--stop-time", stop];
        cosim(folder.path(), &[&arguments[..], &more].concat()).spawn().unwrap()
    };
    let mut first = run("1e6");
    let left = Kept::worker(folder.path(), "left", &place);
    let groups = groups_of(&[left.id()], 1);
    assert_eq!(groups.len(), 1);
    signal(first.id(), "-KILL");
    first.wait().unwrap();
    assert!(remaining(&groups).is_empty());
    assert!(run("5").wait().unwrap().success());
}

#[test]
fn what_a_killed_run_left_in_the_temporary_folder_is_swept_by_the_next() {
    let (file, folder) = (chain(1e6), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let arguments = ["run", path, "-q", "-o", "x.csv", "--workers", "2"];
    let mut run = cosim(folder.path(), &arguments).stderr(Stdio::null()).spawn().unwrap();
    groups_below(&run, 2);
    signal(run.id(), "-KILL");
    run.wait().unwrap();
    let left = leftovers(folder.path());
    assert!(!left.is_empty());
    // As if they were some minutes old.
    let old = std::time::SystemTime::now() - Duration::from_secs(600);
    for folder in &left {
        if let Ok(lock) = std::fs::File::options().write(true).open(folder.join("lock")) {
            lock.set_modified(old).unwrap();
        }
    }
    let next = ["run", path, "-q", "-o", "x.csv", "--workers", "2", "--stop-time", "1"];
    let (code, stderr) = outcome(folder.path(), &next);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
}
