//! The commands of the command line, one file each.
//!
//! Results and requested output go to stdout or files, everything else to stderr. Exit codes: 0 ok,
//! 1 the run failed, 2 usage, 3 the input is not valid, 4 undecided, 130 interrupted
//! (`cosim::Code::exit_code`).

mod campaign;
mod changes;
mod completion;
mod convert;
#[cfg_attr(not(feature = "distributed"), path = "alone.rs")]
mod distributed;
mod drawing;
mod explain;
mod export;
mod info;
mod inspect;
pub(crate) mod interrupt;
pub(crate) mod isolate;
#[cfg(feature = "distributed")]
mod keys;
mod live;
mod logging;
pub(crate) mod messages;
mod output;
mod problems;
mod progress;
#[cfg(feature = "distributed")]
mod proxy;
mod replay;
mod report;
mod run;
mod score;
mod simulate;
mod snapshots;
mod solver;
mod standard;
mod stepping;
mod stop_when;
mod summary;
mod validate;
mod values;
mod verify;
#[cfg(feature = "distributed")]
mod watch;
#[cfg(feature = "distributed")]
mod worker;

use clap::{Parser, Subcommand, ValueEnum};
#[cfg(feature = "distributed")]
use cosim::distributed::Threads;
use cosim::{Code, Error, Result};

/// Co-simulation of FMI 2.0 components
#[derive(Parser)]
#[command(version, about, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Info(info::Info),
    Inspect(inspect::Inspect),
    Validate(validate::Validate),
    Simulate(Box<simulate::Simulate>),
    Run(Box<run::Run>),
    Campaign(campaign::Campaign),
    Replay(replay::Replay),
    Score(score::Score),
    #[command(hide = true)]
    CampaignWorker(campaign::CampaignWorker),
    Convert(convert::Convert),
    Export(export::Export),
    #[cfg(feature = "distributed")]
    Proxy(proxy::Proxy),
    #[cfg(feature = "distributed")]
    Remote(proxy::Remote),
    #[cfg(feature = "distributed")]
    Worker(worker::Worker),
    #[cfg(feature = "distributed")]
    Workers(worker::Workers),
    #[cfg(feature = "distributed")]
    Group(worker::Group),
    #[cfg(feature = "distributed")]
    Keys(keys::Keys),
    #[cfg(feature = "distributed")]
    Watch(watch::Watch),
    Report(report::Report),
    Verify(verify::Verify),
    Explain(explain::Explain),
    Completion(completion::Completion),
    Man(completion::Man),
}

/// Output format.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Text
    Text,
    /// JSON
    Json,
}

impl Arguments {
    /// The threads that Zenoh gets, if it is used.
    #[cfg(feature = "distributed")]
    pub(crate) fn threads(&self) -> Threads {
        match &self.verb {
            Verb::Run(verb) if !verb.may_use_tls() => Threads::SenderApart,
            _ => Threads::One,
        }
    }
}

/// Executes the command; returns the exit code.
pub(crate) fn run(arguments: Arguments) -> Result<u8> {
    let done = match arguments.verb {
        // The errors of an isolated run have already been reported.
        Verb::Simulate(verb) => return verb.run(),
        Verb::Run(verb) => return verb.run(),
        Verb::Info(verb) => verb.run(),
        Verb::Inspect(verb) => verb.run(),
        Verb::Validate(verb) => verb.run(),
        Verb::Campaign(verb) => verb.run(),
        Verb::Replay(verb) => verb.run(),
        Verb::Score(verb) => verb.run(),
        Verb::CampaignWorker(verb) => verb.run(),
        Verb::Convert(verb) => verb.run(),
        Verb::Export(verb) => verb.run(),
        #[cfg(feature = "distributed")]
        Verb::Proxy(verb) => verb.run(),
        #[cfg(feature = "distributed")]
        Verb::Remote(verb) => verb.run(),
        #[cfg(feature = "distributed")]
        Verb::Worker(verb) => verb.run(),
        #[cfg(feature = "distributed")]
        Verb::Workers(verb) => verb.run(),
        #[cfg(feature = "distributed")]
        Verb::Group(verb) => verb.run(),
        #[cfg(feature = "distributed")]
        Verb::Keys(verb) => verb.run(),
        #[cfg(feature = "distributed")]
        Verb::Watch(verb) => verb.run(),
        Verb::Report(verb) => verb.run(),
        Verb::Verify(verb) => verb.run(),
        Verb::Explain(verb) => verb.run(),
        Verb::Completion(verb) => verb.run(),
        Verb::Man(verb) => verb.run(),
    };
    done.map(|()| 0)
}

/// The path of this executable.
pub(crate) fn this_program() -> Result<String> {
    let path = std::env::current_exe()
        .map_err(|why| Error::new(Code::Session, "the path of this program is unknown").why(why))?;
    path.into_os_string()
        .into_string()
        .map_err(|path| Error::new(Code::Session, "the path of this program is not UTF-8").at(path))
}
