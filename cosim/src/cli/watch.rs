//! `cosim watch`: shows the status of a distributed run in the terminal.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};

use clap::Args;
use cosim::distributed::{self, DEFAULT_ENDPOINT, GroupStatus, Status};
use cosim::shown;
use cosim::{Code, Error, Result};

use super::Format;
use super::distributed::Reach;
use super::interrupt;

/// Show the status of a distributed run until it ends
#[derive(Args)]
pub(crate) struct Watch {
    /// Where the run listens (default: tcp/127.0.0.1:7447)
    #[arg(long, value_name = "ENDPOINT")]
    connect: Option<String>,
    /// Text, or a line of JSON for each message
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    reach: Reach,
}

impl Watch {
    pub(crate) fn run(self) -> Result<()> {
        let ours = self.reach.ours()?;
        let connect = self.connect.or_else(|| ours.connect.clone());
        let access = self.reach.access(connect.unwrap_or(DEFAULT_ENDPOINT.to_owned()), &ours);
        interrupt::listen();
        let terminal = std::io::stdout().is_terminal();
        let mut above = 0;
        let mut show = |status: &Status| match self.format {
            Format::Json => {
                let line = serde_json::to_string(status).map_err(unshown)?;
                super::output::print(&line)
            }
            Format::Text if terminal => {
                let table = table(status);
                // Moves to the first line of the previous table and clears it.
                let back = if above > 0 { format!("\x1b[{above}A\x1b[J") } else { String::new() };
                above = table.lines().count();
                let mut out = std::io::stdout().lock();
                write!(out, "{back}{table}").and_then(|()| out.flush()).map_err(unshown)
            }
            Format::Text => super::output::print(&line(status)),
        };
        distributed::watch(&access, &interrupt::interrupted, &mut show)
    }
}

fn unshown(why: impl std::fmt::Display) -> Error {
    Error::new(Code::Output, "stdout cannot be written").why(why)
}

/// One line, for logs.
fn line(status: &Status) -> String {
    let awaited: Vec<String> = status.groups.iter().filter_map(waiting).collect();
    let awaited = if awaited.is_empty() { "no group".to_owned() } else { awaited.join("; ") };
    let end = if status.ended { ", ended" } else { "" };
    format!("{}; waiting for {awaited}{end}", head(status))
}

fn head(status: &Status) -> String {
    let Status { system, time, stop, real_time_factor, .. } = status;
    format!("{system}: t = {time:.3} of {stop} s, {real_time_factor:.3} x real time")
}

fn waiting(group: &GroupStatus) -> Option<String> {
    let since = group.awaited?;
    let (names, place) = (group.components.join(", "), &group.place);
    Some(format!("{names} at {place} for {:.1} ms", since * 1e3))
}

/// A table, for terminals.
fn table(status: &Status) -> String {
    let end = if status.ended { ", ended" } else { "" };
    let mut text = format!("{}{end}\n", shown::one_line(&head(status)));
    let title = ["place", "life", "answers", "mean ms", "longest", "waits ms", "components"];
    let [place, life, answers, mean, longest, waits, names] = title;
    let head =
        format!("{place:<20} {life:>4} {answers:>9} {mean:>8} {longest:>8} {waits:>8}  {names}\n");
    text.push_str(&head);
    for group in &status.groups {
        let waits = group.awaited.map_or("-".to_owned(), |since| format!("{:.1}", since * 1e3));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<20} {:>4} {:>9} {:>8.3} {:>8.1} {waits:>8}  {}",
            shown::one_line(&group.place),
            group.generation,
            group.answers,
            group.mean * 1e3,
            group.longest * 1e3,
            shown::one_line(&group.components.join(", ")),
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_awaited_group_is_named() {
        let group = |name: &str, awaited| GroupStatus {
            components: vec![name.to_owned()],
            place: format!("worker {name}"),
            awaited,
            ..GroupStatus::default()
        };
        let groups = vec![group("plant", None), group("filter", Some(0.0025))];
        let status = Status { system: "s".to_owned(), stop: 2.0, groups, ..Status::default() };
        let text = line(&status);
        assert!(text.ends_with("waiting for filter at worker filter for 2.5 ms"), "{text}");
        assert_eq!(table(&status).lines().count(), 4);
    }
}
