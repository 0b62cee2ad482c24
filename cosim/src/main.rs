//! The command line: parses, runs, reports one error.

mod cli;

use std::process::ExitCode;

use clap::Parser;

/// Replaces the function of the C library: see `cli::interrupt`. FMUs find it because the program
/// exports it.
#[allow(unsafe_code, reason = "the place of a function of the C library")]
#[unsafe(no_mangle)]
extern "C" fn _exit(code: libc::c_int) -> ! {
    cli::interrupt::ended();
    cli::interrupt::exit(code)
}

/// The same under its C name.
#[allow(unsafe_code, reason = "the place of a function of the C library")]
#[unsafe(no_mangle)]
extern "C" fn _Exit(code: libc::c_int) -> ! {
    _exit(code)
}

#[allow(unsafe_code, reason = "the environment before there are threads")]
fn main() -> ExitCode {
    // While there is only one thread: an isolated run continues in a process in its own namespaces.
    match cli::isolate::enter() {
        Ok(None) => (),
        Ok(Some(status)) => return ExitCode::from(u8::try_from(status).unwrap_or(1)),
        Err(error) => {
            cli::messages::error(&error);
            return ExitCode::from(error.code().exit_code());
        }
    }
    cosim::files::protect_inputs();
    let arguments = cli::Arguments::parse();
    #[cfg(feature = "distributed")]
    if let Some((name, value)) = arguments.threads().setting() {
        // SAFETY: no other thread exists yet that could read the environment meanwhile.
        unsafe { std::env::set_var(name, value) }
    }
    let code = match cli::run(arguments) {
        Ok(code) => code,
        Err(error) => {
            cli::messages::error(&error);
            error.code().exit_code()
        }
    };
    cli::interrupt::leave(code)
}
