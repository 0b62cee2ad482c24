//! The code in the documents is run as a reader would paste it, or compared with its source.
//!
//! | block | what happens |
//! |---|---|
//! | `sh` | run by `sh -e` in a separate folder for the page; `cargo` commands are only looked up, and the wheel is installed |
//! | `sh syntax` | the options of its `cosim` commands are checked, nothing is run |
//! | `python` | run by the Python of the tests |
//! | `rust` | must occur, word for word, in a source file |
//! | any with `file=NAME` | written to that file for the commands after it |
//! | any with `of=NAME` | its lines must occur in that file, which a command has written |
//! | `xml`, `json` | must have such a name |
//! | others | nothing |

mod blocks;
mod cargo;
mod shell;
mod sources;

use crate::{
    book::pages::{Page, Pages},
    package, paths, process, python,
};
use anyhow::{Context, Result, bail};
use blocks::{Block, blocks};
use cargo::Commands;
use shell::Shell;
use sources::Sources;
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// Builds what the pages use, checks their blocks, and runs the library's example.
pub(crate) fn run() -> Result<()> {
    package::wheel::for_this_machine()?;
    package::wheel::install()?;
    process::run(&mut process::cargo(&["run", "--release", "--quiet", "-p", "depth-hold"]))?;
    let checker = Checker {
        python: python::TESTS.interpreter()?,
        sources: Sources::read()?,
        cargo: Commands::known()?,
    };
    for page in &Pages::reached()?.pages {
        checker.page(page)?;
    }
    // The library's example; it is built with all of the workspace.
    process::run(
        Command::new(paths::target().join("release/examples/campaign"))
            .args(["examples/baseline.ssd", "1"])
            .current_dir(paths::root()),
    )
}

/// The folder in which the blocks of a page run.
pub(crate) fn folder(page: &Path) -> PathBuf {
    let name = page.with_extension("").display().to_string().replace('/', "-");
    paths::target().join("examples").join(name)
}

/// The sources that blocks are compared with.
struct Checker {
    python: PathBuf,
    sources: Sources,
    cargo: Commands,
}

impl Checker {
    fn page(&self, page: &Page) -> Result<()> {
        let blocks = blocks(&page.text);
        if blocks.is_empty() {
            return Ok(());
        }
        let shell = Shell::new(&folder(&page.path), &self.python)?;
        for block in &blocks {
            let place = format!("{}:{} {}", page.path.display(), block.line, block.language());
            eprintln!("{place}");
            self.block(block, &shell).context(place)?;
        }
        Ok(())
    }

    fn block(&self, block: &Block, shell: &Shell) -> Result<()> {
        if let Some(name) = block.value("file") {
            return shell.write(name, &block.text);
        }
        if let Some(name) = block.value("of") {
            return shell.must_show(name, &block.text);
        }
        match block.language() {
            "sh" => {
                self.cargo.check(&block.text)?;
                shell.run(&block.text, block.says("syntax"))
            }
            "python" => shell.python(&self.python, &block.text),
            "rust" => self.sources.must_have(&block.text),
            language @ ("xml" | "json") => {
                bail!(
                    "give this {language} a name, ```{language} file=NAME, and use it in a command"
                )
            }
            _ => Ok(()),
        }
    }
}
