//! The same bytes as in one process, however the run is distributed and disturbed.

use std::io::{BufRead, BufReader};

use super::*;

#[test]
fn any_number_of_workers_gives_the_same_bytes() {
    let (file, folder) = (chain(5.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let here = undisturbed(folder.path(), path);
    for workers in ["1", "2", "3", "5"] {
        let tcp = endpoint();
        for listen in [&[][..], &["--listen", &tcp]] {
            let arguments = ["run", path, "-q", "-o", "there.csv", "--workers", workers];
            let (code, stderr) = outcome(folder.path(), &[&arguments, listen].concat());
            assert_eq!(code, 0, "{stderr}");
            assert!(here == results(folder.path(), "there.csv"), "{workers} {listen:?}");
        }
    }
    assert_eq!(leftovers(folder.path()), Vec::<PathBuf>::new());
}

#[test]
fn load_and_delays_change_no_byte() {
    let (file, folder) = (chain(300.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let here = undisturbed(folder.path(), path);
    let burn = || Command::new("sh").args(["-c", "while :; do :; done"]).spawn().unwrap();
    let _load: Vec<Kept> = (0..3).map(|_| Kept(burn())).collect();
    let arguments = ["run", path, "-q", "-o", "there.csv", "--workers", "3"];
    let mut run = cosim(folder.path(), &arguments).spawn().unwrap();
    let groups = groups_below(&run, 3);
    let mut dice = Dice(9);
    while run.try_wait().unwrap().is_none() {
        let Some(&group) = groups.get(dice.below(groups.len() as u64) as usize) else { break };
        signal(group, "-STOP");
        std::thread::sleep(Duration::from_millis(dice.below(30)));
        signal(group, "-CONT");
        std::thread::sleep(Duration::from_millis(dice.below(20)));
    }
    assert!(run.wait().unwrap().success());
    assert!(here == results(folder.path(), "there.csv"));
}

#[test]
fn workers_that_were_there_before_serve_several_runs() {
    let (file, folder) = (chain(5.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let here = undisturbed(folder.path(), path);
    let place = endpoint();
    let _left = Kept::worker(folder.path(), "left", &place);
    let _right = Kept::worker(folder.path(), "right", &place);
    for placement in ["x=left", "x=right"] {
        let arguments = ["run", path, "-q", "-o", "there.csv", "--distributed", "--listen", &place];
        let more = ["--min-workers", "2", "--place", placement, "--wait", "20"];
        let (code, stderr) = outcome(folder.path(), &[&arguments[..], &more].concat());
        assert_eq!(code, 0, "{stderr}");
        assert!(here == results(folder.path(), "there.csv"));
    }
}

#[test]
fn an_endpoint_of_another_program_does_not_end_the_service_of_others() {
    let (file, folder) = (chain(2.0), TempDir::new().unwrap());
    let file = file.write();
    let path = file.to_str().unwrap();
    let here = undisturbed(folder.path(), path);
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let place = endpoint();
    let listener_address = listener.local_addr().unwrap().to_string();
    let both = format!("tcp/{listener_address},{place}");
    // It answers every call by closing the connection.
    std::thread::spawn(move || listener.incoming().for_each(drop));
    let arguments = ["worker", "--name", "left", "--connect", &both, "--allow-upload"];
    let process = cosim(folder.path(), &arguments).stderr(Stdio::piped()).spawn();
    let mut worker = Kept(process.unwrap());
    // It says so, and goes on.
    let mut said = BufReader::new(worker.0.stderr.take().unwrap()).lines().map(Result::unwrap);
    let warning = said.find(|line| line.contains("is not served")).unwrap();
    assert!(warning.contains(&listener_address), "{warning}");
    for _ in 0..2 {
        let arguments = ["run", path, "-q", "-o", "there.csv", "--distributed", "--listen", &place];
        let more = ["--min-workers", "1", "--wait", "20"];
        let (code, stderr) = outcome(folder.path(), &[&arguments[..], &more].concat());
        assert_eq!(code, 0, "{stderr}");
        assert!(here == results(folder.path(), "there.csv"));
    }
}
