//! How a program of another platform is run here.

use crate::{
    debian,
    package::{
        compile,
        platform::{self, Platform},
    },
    paths, process,
};
use anyhow::{Result, bail};
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// Runs programs of a platform.
pub(super) enum Machine {
    /// This one.
    This,
    /// Wine and a folder of libraries that it needs.
    Wine([PathBuf; 2]),
    /// qemu-user and the folder of the other machine's glibc.
    Qemu([PathBuf; 2]),
}

impl Machine {
    /// The one for a platform, unpacked if necessary.
    pub(super) fn of(platform: &Platform, offline: bool) -> Result<Self> {
        if *platform == *platform::host()? {
            return Ok(Self::This);
        }
        match (platform.os, platform.arch) {
            ("windows", "x86_64") => Ok(Self::Wine(debian::install_wine(offline)?)),
            ("linux", "aarch64") => Ok(Self::Qemu(debian::install_qemu(offline)?)),
            _ => bail!("nothing here runs programs of {}", platform.folder()),
        }
    }

    /// Its name and version.
    pub(super) fn name(&self) -> String {
        let version = match self {
            Self::This => return "native".to_owned(),
            Self::Wine(paths) => process::output(Self::wine(paths).arg("--version")),
            Self::Qemu([program, _]) => process::output(Command::new(program).arg("--version")),
        };
        let version = version.unwrap_or_default();
        let line = version.lines().next().unwrap_or_default();
        line.split(" (").next().unwrap_or_default().replace(" version", "")
    }

    /// Runs a program of a folder there.
    pub(super) fn run(&self, folder: &Path, program: &str, argument: &str) -> Result<()> {
        let program = folder.join(program);
        let mut command = match self {
            Self::This => Command::new(&program),
            Self::Wine(paths) => {
                Self::complete_wine(folder)?;
                let mut command = Self::wine(paths);
                command.arg(&program);
                command
            }
            Self::Qemu([qemu, root]) => {
                let mut command = Command::new(qemu);
                command.arg("-L").arg(root).arg(&program);
                command
            }
        };
        process::run(command.arg(argument).current_dir(folder))
    }

    fn wine([program, libraries]: &[PathBuf; 2]) -> Command {
        let mut command = Command::new(program);
        command
            .env("LD_LIBRARY_PATH", libraries)
            .env("WINEPREFIX", debian::folder().join("prefix"))
            // File names are in UTF-8, whatever the user's locale.
            .env("LC_ALL", "C.UTF-8")
            // No messages of its own, and none of the parts that it would offer to install.
            .env("WINEDEBUG", "-all")
            .env("WINEDLLOVERRIDES", "mscoree,mshtml,winemenubuilder.exe=")
            .env_remove("DISPLAY");
        command
    }

    /// Puts a library that older ones lack beside the programs.
    fn complete_wine(folder: &Path) -> Result<()> {
        let file = folder.join("bcryptprimitives.dll");
        let source = paths::root().join("xtask/platforms/bcryptprimitives.c");
        let mut command = compile::c_compiler(platform::named("win64")?)?;
        command.args(["-shared", "-s", "-o"]).arg(&file).arg(source).arg("-ladvapi32");
        process::run(&mut command)
    }
}
