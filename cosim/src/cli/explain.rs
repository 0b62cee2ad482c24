//! `cosim explain`: explains an error code and its remedy, or the faults of scenarios.

use clap::Args;
use cosim::scenario::{KINDS, Word};
use cosim::{Code, Error, Result, names};

use super::output::print;

/// Explain an error code such as E203, or the faults of scenarios
#[derive(Args)]
pub(crate) struct Explain {
    /// The code, `faults`, the name of a fault, or `schema` for the JSON Schema of scenarios;
    /// without one, all codes are listed
    code: Option<String>,
}

impl Explain {
    pub(crate) fn run(self) -> Result<()> {
        let Some(wanted) = self.code else {
            let lines: Vec<String> = Code::ALL.iter().map(|&code| line(code)).collect();
            return print(&lines.join("\n"));
        };
        if wanted == "schema" {
            return print(&format!("{:#}", cosim::scenario::schema()));
        }
        if wanted == "faults" {
            let all: Vec<String> = KINDS.iter().map(fault).collect();
            return print(all.join("\n").trim_end());
        }
        if let Some(word) = KINDS.iter().find(|word| word.name == wanted) {
            return print(fault(word).trim_end());
        }
        match Code::ALL.iter().find(|code| code.as_str().eq_ignore_ascii_case(&wanted)) {
            Some(&code) => print(&format!("{}\n{}", line(code), code.remedy())),
            None => Err(Error::new(Code::Usage, format!("there is no error code '{wanted}'"))
                .maybe_help(names::did_you_mean(&wanted, Code::ALL.iter().map(|c| c.as_str())))),
        }
    }
}

/// A fault as in a scenario file, with comments.
fn fault(word: &Word) -> String {
    let mut text = format!("# {}: {}\n", word.name, word.meaning);
    for meant in word.keys {
        text += &format!("#   {}: {}\n", meant.key, meant.meaning);
    }
    text += &format!("[[fault]]\nkind = \"{}\"\non = \"component.variable\"\n", word.name);
    text + word.example + if word.example.is_empty() { "" } else { "\n" }
}

fn line(code: Code) -> String {
    format!("{code}  (exit code {})  {}", code.exit_code(), code.explanation().trim())
}
