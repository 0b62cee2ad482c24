//! Three machines, as network namespaces with their own addresses, joined by cables that can be
//! cut. Needs permission to create namespaces; without it the test says so and is skipped.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use tempfile::TempDir;

use crate::distributed::{chain, children, outcome, results, signal};
use crate::locked::Running;

/// The machine of the run, with a switch, and two others.
struct Network(String);

impl Network {
    fn name(&self, machine: &str) -> String {
        format!("{}-{machine}", self.0)
    }

    /// Connects the cables: 10.77.0.1 for the run, .2 and .3 for the workers. `None` if that is not
    /// permitted.
    fn lay() -> Result<Self, String> {
        let network = Self(format!("cosim-{}", std::process::id()));
        let [hub, left, right] = ["hub", "left", "right"].map(|machine| network.name(machine));
        for machine in [&hub, &left, &right] {
            ip(&["netns", "add", machine])?;
        }
        let ip = |arguments: &[&str]| ip(arguments).unwrap();
        ip(&["-n", &hub, "link", "add", "name", "switch", "type", "bridge"]);
        ip(&["-n", &hub, "addr", "add", "10.77.0.1/24", "dev", "switch"]);
        ip(&["-n", &hub, "link", "set", "switch", "up"]);
        for (machine, cable, address) in
            [(&left, "to-left", "10.77.0.2/24"), (&right, "to-right", "10.77.0.3/24")]
        {
            let pair = ["type", "veth", "peer", "name", "cable", "netns", machine.as_str()];
            ip(&[&["-n", &hub, "link", "add", "name", cable], &pair[..]].concat());
            ip(&["-n", &hub, "link", "set", cable, "master", "switch", "up"]);
            ip(&["-n", machine, "addr", "add", address, "dev", "cable"]);
            ip(&["-n", machine, "link", "set", "cable", "up"]);
        }
        Ok(network)
    }

    /// Cuts or reconnects the cable to a worker's machine.
    fn cable(&self, cable: &str, state: &str) {
        ip(&["-n", &self.name("hub"), "link", "set", cable, state]).unwrap();
    }

    /// The command line on a machine.
    fn on(&self, machine: &str, folder: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.name(machine), env!("CARGO_BIN_EXE_cosim")]);
        command.args(arguments).current_dir(folder).env("NO_COLOR", "1").env("TMPDIR", folder);
        command.stdout(Stdio::null());
        command
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        for machine in ["hub", "left", "right"] {
            let _ = ip(&["netns", "delete", &self.name(machine)]);
        }
    }
}

fn ip(arguments: &[&str]) -> Result<(), String> {
    let output = Command::new("ip").args(arguments).output().map_err(|why| why.to_string())?;
    match output.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
    }
}

#[test]
fn machines_that_are_cut_off_and_killed_change_no_byte() {
    let network = match Network::lay() {
        Ok(network) => network,
        Err(why) => {
            eprintln!("skipped: no network namespaces here: {why}");
            return;
        }
    };
    let (folder, file) = (TempDir::new().unwrap(), chain(24.0));
    let (at, file) = (folder.path(), file.write());
    let path = file.to_str().unwrap();
    let (code, stderr) = outcome(at, &["run", path, "-q", "-o", "here.csv"]);
    assert_eq!(code, 0, "{stderr}");
    let keys = ["keys", "keys", "--worker", "left", "--worker", "right", "--host", "10.77.0.1"];
    let (code, stderr) = outcome(at, &keys);
    assert_eq!(code, 0, "{stderr}");

    let run = ["run", path, "-o", "there.csv", "--distributed", "--min-workers", "2"];
    let listen = ["--listen", "tls/10.77.0.1:7447", "--credentials", "keys/orchestrator"];
    let more = ["--real-time=2", "--place", "g=left", "--place", "x=right", "--wait", "30"];
    let run = [&run[..], &listen, &more].concat();
    let run = network.on("hub", at, &run).stderr(Stdio::piped()).spawn().unwrap();
    let worker = |name: &str| {
        let credentials = format!("keys/{name}");
        let arguments = ["worker", "--name", name, "--connect", "tls/10.77.0.1:7447"];
        let more = ["--credentials", &credentials, "--allow-upload"];
        let mut command = network.on(name, at, &[&arguments[..], &more].concat());
        Running(command.stderr(Stdio::null()).spawn().unwrap())
    };
    let (left, _right) = (worker("left"), worker("right"));
    let pause = |seconds| std::thread::sleep(Duration::from_secs_f64(seconds));
    // A worker has a process for its group as soon as the run begins.
    for _ in 0..600 {
        if !children(left.0.id()).is_empty() {
            break;
        }
        pause(0.05);
    }
    pause(1.0);
    network.cable("to-right", "down");
    pause(3.0);
    network.cable("to-right", "up");
    pause(3.0);
    signal(left.0.id(), "-KILL");
    let output = run.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("went on at worker left"), "{stderr}");
    assert!(stderr.contains("went on at worker right"), "{stderr}");
    assert_eq!(results(at, "here.csv"), results(at, "there.csv"));
}
