//! An error that is sent over the network.

use serde::{Deserialize, Serialize};

use cosim_base::error::{Code, Error};

/// What went wrong in another process.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Failure {
    code: String,
    what: String,
    /// The name of the file concerned; its path means nothing here.
    file: Option<String>,
    why: Option<String>,
    help: Option<String>,
    log: Vec<String>,
    status: Option<i32>,
}

impl From<&Error> for Failure {
    fn from(error: &Error) -> Self {
        Self {
            code: error.code().as_str().to_owned(),
            what: error.what().to_owned(),
            file: error
                .place()
                .and_then(|(file, _)| Some(file.file_name()?.to_string_lossy().into_owned())),
            why: error.reason().map(str::to_owned),
            help: error.remedy().map(str::to_owned),
            log: error.logged().to_vec(),
            status: error.status(),
        }
    }
}

impl Failure {
    /// The original error, with the place where it happened.
    pub(crate) fn into_error(self, place: &str) -> Error {
        let code = Code::ALL.iter().find(|code| code.as_str() == self.code);
        let error = Error::new(*code.unwrap_or(&Code::Protocol), self.what).maybe_help(self.help);
        let error = match self.why {
            Some(why) => error.why(format!("{why} (on {place})")),
            None => error.why(format!("it happened on {place}")),
        };
        let error = error.log(self.log).returned(self.status);
        match self.file {
            Some(file) => error.at(file),
            None => error,
        }
    }
}
