//! Invalid requests are reported in one error, and leave nothing behind.

use super::*;

#[test]
fn what_cannot_be_is_reported_before_anything_runs() {
    let (file, folder) = (chain(1.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let busy = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp/{}", busy.local_addr().unwrap());
    for (more, code, part) in [
        (&["--workers", "2", "--place", "gg=worker-1"][..], 2, "did you mean 'g'?"),
        (&["--workers", "2", "--place", "g=worker-7", "--wait", "2"], 2, "did you mean 'worker-"),
        (&["--distributed", "--listen", "tcp/0.0.0.0:0"], 1, "--insecure"),
        (&["--distributed", "--listen", "tls/127.0.0.1:0"], 1, "--credentials"),
        (&["--distributed", "--listen", &endpoint], 1, "E504"),
    ] {
        let arguments = [&["run", path, "-q"], more].concat();
        let (found, stderr) = outcome(folder.path(), &arguments);
        assert_eq!(found, code, "{more:?}: {stderr}");
        assert!(stderr.contains(part), "{more:?}: {stderr}");
        assert_eq!(stderr.matches("error:").count(), 1, "{more:?}: {stderr}");
    }
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn a_full_disk_ends_the_run_and_all_its_processes() {
    let (file, folder) = (chain(1000.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let arguments = ["run", path, "-q", "-o", "/dev/full", "--workers", "2"];
    let run = cosim(folder.path(), &arguments).stderr(Stdio::piped()).spawn().unwrap();
    groups_below(&run, 2);
    let started = below(run.id());
    let output = run.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("the results cannot be written") && stderr.contains("No space"));
    assert!(remaining(&started).is_empty());
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn two_workers_of_one_name_are_one_too_many() {
    let (file, folder) = (chain(1e6), TempDir::new().unwrap());
    let file = file.write();
    let place = endpoint();
    let arguments =
        ["run", file.to_str().unwrap(), "-q", "-o", "x.csv", "--distributed", "--listen", &place];
    let run = Kept(cosim(folder.path(), &arguments).stderr(Stdio::null()).spawn().unwrap());
    let left = Kept::worker(folder.path(), "left", &place);
    assert!(!groups_of(&[left.id()], 1).is_empty());
    let (code, stderr) = outcome(folder.path(), &["worker", "--name", "left", "--connect", &place]);
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("'left' is already connected"), "{stderr}");
    drop(run);
}
