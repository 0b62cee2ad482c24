//! The command line: parse, run, one error.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    match cli::run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::messages::error(&error);
            ExitCode::from(error.code().exit_code())
        }
    }
}
