//! A campaign that is killed repeatedly, and continues each time: its rows must equal those of an
//! undisturbed one.

use std::fs;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, ensure};

use super::{Dice, Soak};
use crate::paths;

/// The longest time until the next kill (ms): some runs are finished by then.
const LONGEST: u64 = 2000;

impl Soak {
    /// Kills until the number is reached; fails at the first row that differs.
    pub(super) fn campaign(&self, kills: u32, dice: &mut Dice) -> Result<()> {
        let alone = self.folder.join("campaign-alone");
        remove(&alone)?;
        let status = self.go_on(&alone)?.wait()?;
        ensure!(is_over(status), "the campaign failed: {status}");
        let wanted = rows(&alone)?;
        let killed = self.folder.join("campaign-killed");
        let mut count = 0;
        while count < kills {
            remove(&killed)?;
            loop {
                let mut campaign = self.go_on(&killed)?;
                std::thread::sleep(Duration::from_millis(dice.below(LONGEST)));
                if let Some(status) = campaign.try_wait()? {
                    ensure!(is_over(status), "after {count} kills: {status}");
                    break;
                }
                campaign.kill()?;
                if is_over(campaign.wait()?) {
                    break;
                }
                count += 1;
            }
            ensure!(rows(&killed)? == wanted, "after {count} kills the rows are others");
            println!("{count} kills of a campaign, {} rows the same", wanted.len() - 1);
        }
        Ok(())
    }

    /// Starts or continues the campaign.
    fn go_on(&self, folder: &Path) -> Result<std::process::Child> {
        let mut command = Command::new(&self.program);
        command.args(["campaign", "examples/campaign/filters.toml", "--quiet", "--csv"]);
        command.arg("--output-dir").arg(folder).current_dir(paths::root());
        Ok(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()?)
    }
}

/// Whether all runs were made, whatever the thresholds say.
fn is_over(status: ExitStatus) -> bool {
    matches!(status.code(), Some(0 | 1 | 4))
}

fn remove(folder: &Path) -> Result<()> {
    if folder.exists() { Ok(fs::remove_dir_all(folder)?) } else { Ok(()) }
}

/// The rows without their durations.
fn rows(folder: &Path) -> Result<Vec<String>> {
    let file = folder.join("runs.csv");
    let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    let rows = text.lines().map(|line| Ok(line.rsplit_once(',').context("no row")?.0.to_owned()));
    rows.collect()
}
