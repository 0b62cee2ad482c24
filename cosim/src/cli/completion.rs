//! `cosim completion` and `cosim man`, from the same definitions as `--help`.

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use cosim::{Code, Error, Result};

use super::Arguments;
use super::output::print;

/// Print a completion script for a shell
#[derive(Args)]
pub(crate) struct Completion {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completion {
    pub(crate) fn run(self) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "cosim", &mut script);
        print(String::from_utf8_lossy(&script).trim_end())
    }
}

/// Print the manual page (roff); `cosim man | man -l -` shows it
#[derive(Args)]
pub(crate) struct Man {}

impl Man {
    pub(crate) fn run(self) -> Result<()> {
        let mut page = Vec::new();
        self.render(&mut page)
            .map_err(|e| Error::new(Code::Output, "the page cannot be written").why(e))?;
        print(String::from_utf8_lossy(&page).trim_end())
    }

    /// The manual page of the program, followed by the options of every command.
    fn render(&self, page: &mut Vec<u8>) -> std::io::Result<()> {
        let mut command = Arguments::command();
        command.build();
        clap_mangen::Man::new(command.clone()).render(page)?;
        for verb in command
            .get_subcommands()
            .filter(|verb| !verb.is_hide_set() && verb.get_name() != "help")
        {
            writeln!(page, ".SH {}", verb.get_name().to_uppercase())?;
            let man = clap_mangen::Man::new(verb.clone());
            man.render_description_section(page)?;
            man.render_options_section(page)?;
        }
        Ok(())
    }
}
