//! `cosim explain`: what an error code means, and what to do about it.

use clap::Args;
use cosim::{Code, Error, Result, names};

use super::output::print;

/// Explain an error code such as E203
#[derive(Args)]
pub(crate) struct Explain {
    /// The code; without one all are listed
    code: Option<String>,
}

impl Explain {
    pub(crate) fn run(self) -> Result<()> {
        let Some(wanted) = self.code else {
            let lines: Vec<String> = Code::ALL.iter().map(|&code| line(code)).collect();
            return print(&lines.join("\n"));
        };
        match Code::ALL.iter().find(|code| code.as_str().eq_ignore_ascii_case(&wanted)) {
            Some(&code) => print(&format!("{}\n{}", line(code), code.remedy())),
            None => Err(Error::new(Code::Usage, format!("there is no error code '{wanted}'"))
                .maybe_help(names::did_you_mean(&wanted, Code::ALL.iter().map(|c| c.as_str())))),
        }
    }
}

fn line(code: Code) -> String {
    format!("{code}  (exit code {})  {}", code.exit_code(), code.explanation().trim())
}
