//! The commands of the command line, one file each.
//!
//! Results and requested output go to stdout or files, everything else to stderr. Exit codes: 0 ok,
//! 1 the run failed, 2 usage, 3 the input is not valid, 4 undecided, 130 interrupted
//! (`cosim::Code::exit_code`).

mod campaign;
mod changes;
mod completion;
mod convert;
mod distributed;
mod drawing;
mod explain;
mod export;
mod info;
mod inspect;
pub(crate) mod interrupt;
pub(crate) mod isolate;
mod keys;
mod live;
mod logging;
pub(crate) mod messages;
mod output;
mod problems;
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
mod watch;
mod worker;

use clap::{Parser, Subcommand, ValueEnum};
use cosim::Result;
use cosim::distributed::Threads;

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
    Proxy(proxy::Proxy),
    Remote(proxy::Remote),
    Worker(worker::Worker),
    Workers(worker::Workers),
    Group(worker::Group),
    Keys(keys::Keys),
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
        Verb::Proxy(verb) => verb.run(),
        Verb::Remote(verb) => verb.run(),
        Verb::Worker(verb) => verb.run(),
        Verb::Workers(verb) => verb.run(),
        Verb::Group(verb) => verb.run(),
        Verb::Keys(verb) => verb.run(),
        Verb::Watch(verb) => verb.run(),
        Verb::Report(verb) => verb.run(),
        Verb::Verify(verb) => verb.run(),
        Verb::Explain(verb) => verb.run(),
        Verb::Completion(verb) => verb.run(),
        Verb::Man(verb) => verb.run(),
    };
    done.map(|()| 0)
}
