//! Our own standard output, separate from what FMUs print.

use std::fs::File;
use std::io::{self, Write};
use std::sync::OnceLock;

use cosim::{Code, Error, Result};

/// Where standard output went before FMUs got standard error in its place.
static OWN: OnceLock<File> = OnceLock::new();

/// From here on, what FMUs print goes to standard error, because programs read what we write to
/// standard output.
pub(super) fn keep_apart() -> Result<()> {
    let broken = |e| Error::new(Code::Output, "stdout cannot be written").why(e);
    if OWN.get().is_some() {
        return Ok(());
    }
    let own = rustix::io::dup(rustix::stdio::stdout()).map_err(broken)?;
    rustix::stdio::dup2_stdout(rustix::stdio::stderr()).map_err(broken)?;
    OWN.get_or_init(|| own.into());
    Ok(())
}

/// Our standard output.
pub(super) fn out() -> Box<dyn Write> {
    match OWN.get() {
        Some(own) => Box::new(own),
        None => Box::new(io::stdout()),
    }
}
