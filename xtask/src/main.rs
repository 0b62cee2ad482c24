//! The task runner: `cargo xtask <task>`.
//!
//! Everything that developers and CI do with this project goes through here, so that both do the
//! same.

mod bench;
mod book;
mod debian;
mod describe;
mod examples;
mod experiment;
mod field;
mod fuzz;
mod judge;
mod matrix;
mod mutants;
mod navigate;
mod package;
mod paths;
mod platforms;
mod process;
mod python;
mod reproduce;
mod soak;
mod supply;
mod test;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Tasks of the RexROV FMI project")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Build the library and write the FMUs, baseline.ssp and paper.ssp to target/fmus.
    Package(package::Options),
    /// Regenerate modelDescription/ from the components.
    Describe {
        /// Only compare: fail if a committed file differs from the components.
        #[arg(long)]
        check: bool,
    },
    /// Run the paper's experiment from packaged FMUs and write target/reproduce/report.html.
    Reproduce(reproduce::Options),
    /// Measure the goals of the navigation filters from packaged FMUs and write
    /// target/navigate/table.md.
    Navigate(navigate::Options),
    /// Run the documents' code and write target/book/index.html, the documents as a book.
    Book {
        /// Only compare the pictures: fail if a committed one differs from what its page's commands
        /// make.
        #[arg(long)]
        check: bool,
    },
    /// Measure speed as ratios within one run.
    Bench(bench::Options),
    /// Build the Python package into target/wheels.
    Wheel {
        /// With FMUs for every shipped platform, as `package --all` builds them.
        #[arg(long)]
        all: bool,
    },
    /// On Debian: unpack the compilers for Windows and ARM under target/debian.
    Toolchain,
    /// Compare the components on Windows (under Wine) and ARM (under qemu) with this machine's, bit
    /// for bit.
    Platforms(platforms::Options),
    /// Check the FMUs with FMPy, fmi-rs, fmutool, libcosim, Ecos and CoFmuPy, and compare `cosim`
    /// with them.
    Judge,
    /// Validate and run systems of other tools, and write the results as a table.
    Field(field::Options),
    /// Fuzz the FMI functions, the reader of saved states and the readers of `cosim`, under
    /// AddressSanitizer; needs nightly Rust and cargo-fuzz.
    Fuzz {
        /// How long to fuzz each target.
        #[arg(long, default_value_t = 600)]
        seconds: u32,
        /// Only these targets; by default all.
        targets: Vec<String>,
    },
    /// Put faults into a copy of the navigation filters, one at a time; a test must catch each.
    Mutants {
        /// Only those whose names contain this.
        filter: Option<String>,
    },
    /// Make the campaign of all faults and filters, which takes a quarter of an hour on two cores, and write docs/how-to/fault-matrix.md.
    Matrix,
    /// Kill the processes of distributed runs, or of a campaign, hundreds of times; every byte must
    /// stay the same.
    Soak(soak::Options),
    /// Check licences and sources of the dependencies by deny.toml.
    Deny {
        /// Also known vulnerabilities: downloads the RustSec database.
        #[arg(long)]
        advisories: bool,
    },
    /// Write target/sbom.cdx.json, the crates in the shipped files, as CycloneDX.
    Sbom,
    /// Run every check and every test of the project.
    Test,
}

fn main() -> std::process::ExitCode {
    let outcome = match Arguments::parse().task {
        Task::Package(options) => package::run(&options),
        Task::Describe { check: true } => describe::check(),
        Task::Describe { check: false } => describe::write(),
        Task::Reproduce(options) => package::for_this_machine()
            .and_then(|()| package::program_for_this_machine())
            .and_then(|()| reproduce::run(&options)),
        Task::Navigate(options) => {
            package::for_this_machine().and_then(|()| navigate::run(&options))
        }
        Task::Book { check } => package::for_shipping().and_then(|()| book::run(check)),
        Task::Bench(options) => bench::run(&options),
        Task::Wheel { all } => package::wheel::run(all),
        Task::Toolchain => package::toolchain::install(),
        Task::Platforms(options) => platforms::run(&options),
        Task::Judge => judge::run(),
        Task::Field(options) => field::run(&options),
        Task::Fuzz { seconds, targets } => fuzz::run(seconds, &targets),
        Task::Mutants { filter } => mutants::run(filter.as_deref()),
        Task::Matrix => matrix::run(),
        Task::Soak(options) => soak::run(&options),
        Task::Deny { advisories } => supply::deny::run(advisories),
        Task::Sbom => supply::sbom::run(),
        Task::Test => test::run(),
    };
    match outcome {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            std::process::ExitCode::FAILURE
        }
    }
}
