//! Trajectories of a campaign that are kept.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use cosim::campaign::{self, Bench, Folder, Status};
use cosim::confine::Supervised;
use cosim::{Code, Error, Result};

use super::pool::read_until;
use crate::cli::{interrupt, messages, this_program};

/// How many times as long a replay, which records everything, may take as a run of the campaign.
const SLOWER: f64 = 2.0;

/// Repeats the runs whose trajectories are wanted, each in its own process: a run that crashed
/// crashes again.
pub(super) fn keep(bench: &Bench, folder: &Path, results: Folder) -> Result<()> {
    let kept = campaign::kept(bench.campaign(), results.rows())?;
    // Each replay is a separate process that reads the log.
    drop(results);
    let program = this_program()?;
    let seconds = SLOWER * bench.campaign().time_limit;
    for run in kept {
        let place = folder.join("trajectories");
        let file = place.join(format!("run{run}.mcap"));
        if file.exists() || interrupt::interrupted() {
            continue;
        }
        let unmade = |e| Error::new(Code::Output, "the folder cannot be made").at(&place).why(e);
        std::fs::create_dir_all(&place).map_err(unmade)?;
        let mut replay = Command::new(&program);
        replay.arg("replay").arg(folder).arg(run.to_string()).arg("--output-file").arg(&file);
        let ended = ends(&mut replay, seconds)
            .map_err(|e| Error::new(Code::Lost, format!("run {run} cannot be repeated")).why(e))?;
        let said = match ended {
            None => {
                // Without a recorded duration there is no limit.
                drop(std::fs::remove_file(&file));
                format!("it took longer than {seconds} s")
            }
            // The trajectory of a failed run is kept; the row says why it failed.
            Some((good, _)) if good || file.exists() => continue,
            Some((_, said)) => said,
        };
        messages::warning(&format!("run {run} has left no trajectory: {said}"));
    }
    Ok(())
}

/// Whether a process succeeds, and its output; `None` if it does not end within this time.
fn ends(command: &mut Command, seconds: f64) -> std::io::Result<Option<(bool, String)>> {
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    let mut process = Supervised::start(command)?;
    let mut said = Vec::new();
    if let Some(mut stderr) = process.0.stderr.take() {
        let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        let outcome = read_until(&mut stderr, &mut said, limit, |_| None::<()>);
        if outcome == Err(Status::TimedOut) {
            return Ok(None);
        }
    }
    let good = process.0.wait()?.success();
    Ok(Some((good, String::from_utf8_lossy(&said).trim().to_owned())))
}
