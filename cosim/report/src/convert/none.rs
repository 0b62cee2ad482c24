//! Instead of `convert`, in programs without the feature `pictures`.

use cosim_base::error::{Code, Error, Result};

pub(super) fn png(_: &str) -> Result<Vec<u8>> {
    Err(missing("PNG"))
}

pub(super) fn pdf(_: &str) -> Result<Vec<u8>> {
    Err(missing("PDF"))
}

fn missing(format: &str) -> Error {
    Error::new(Code::Output, format!("this program writes no {format}"))
        .why("it was built without the feature 'pictures'")
        .help("write a .svg, or build cosim with '--features pictures'")
}
