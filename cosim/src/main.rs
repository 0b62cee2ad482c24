//! The command line: parse, run, one error.

mod cli;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    if let Some((name, value)) = arguments.threads().setting() {
        // SAFETY: there is no other thread yet that could read the environment meanwhile.
        unsafe { std::env::set_var(name, value) }
    }
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
