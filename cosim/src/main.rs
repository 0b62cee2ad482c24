//! The command line: parse, run, one error.

mod cli;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    receive_by_one_thread();
    let arguments = cli::Arguments::parse();
    let code = match cli::run(arguments) {
        Ok(()) => 0,
        Err(error) => {
            cli::messages::error(&error);
            error.code().exit_code()
        }
    };
    if cosim::fmi::has_mapped_python() {
        // What cannot be written has nobody to be told to.
        drop(std::io::stdout().flush());
        // SAFETY: nothing of ours is left to be done at the end of the process.
        unsafe { libc::_exit(code.into()) }
    }
    ExitCode::from(code)
}

/// Lets one thread wait for what comes over Zenoh and hand it on. By default one waits and wakes
/// another, which costs a distributed step a quarter more. Whoever sets the variable decides.
fn receive_by_one_thread() {
    const RUNTIME: &str = "ZENOH_RUNTIME";
    if std::env::var_os(RUNTIME).is_none() {
        let one = "(rx:(handover:app),acc:(handover:app),net:(handover:app))";
        // SAFETY: there is no other thread yet that could read the environment meanwhile.
        unsafe { std::env::set_var(RUNTIME, one) }
    }
}
