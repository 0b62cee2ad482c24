//! `cosim worker`: lends this machine to runs; and the process for one group of components.

use clap::Args;
use cosim::distributed::{DEFAULT_ENDPOINT, Order, serve_group};
use cosim::{Code, Error, Result, distributed};

use super::distributed::Reach;
use super::interrupt::Interrupt;

/// Lend this machine to distributed runs
#[derive(Args)]
pub(crate) struct Worker {
    /// Name of this worker (default: the machine's name and a number)
    #[arg(long)]
    name: Option<String>,
    /// Where runs listen
    #[arg(long, value_name = "ENDPOINT", default_value = DEFAULT_ENDPOINT)]
    connect: String,
    /// End with the process that started this one
    #[arg(long, hide = true)]
    with_parent: bool,
    #[command(flatten)]
    reach: Reach,
}

/// List the workers that dial an endpoint
#[derive(Args)]
pub(crate) struct Workers {
    /// Where workers dial
    #[arg(long, value_name = "ENDPOINT", default_value = DEFAULT_ENDPOINT)]
    listen: String,
    /// Wait so long for them
    #[arg(long, value_name = "SECONDS", default_value = "2", value_parser = super::values::seconds)]
    wait: f64,
    #[command(flatten)]
    reach: Reach,
}

impl Workers {
    pub(crate) fn run(self) -> Result<()> {
        let patience = std::time::Duration::from_secs_f64(self.wait);
        for worker in distributed::workers(&self.reach.access(self.listen), patience)? {
            let (name, host, process) = (&worker.name, &worker.host, worker.process);
            super::output::print(&format!(
                "{name}: {host}, process {process}, {}",
                worker.computes()
            ))?;
        }
        Ok(())
    }
}

/// Compute a group of components, as a worker asks
#[derive(Args)]
#[command(hide = true)]
pub(crate) struct Group {
    #[arg(long)]
    connect: String,
    #[arg(long)]
    run: String,
    #[arg(long)]
    group: usize,
    #[arg(long)]
    generation: u32,
    #[command(flatten)]
    reach: Reach,
}

impl Worker {
    pub(crate) fn run(self) -> Result<()> {
        if self.with_parent {
            end_with_parent()?;
        }
        let mut program = vec![this_program()?, "group".to_owned()];
        program.extend(["--connect".to_owned(), self.connect.clone()]);
        program.extend(self.reach.arguments());
        let name = self.name.unwrap_or_else(distributed::default_name);
        let access = self.reach.access(self.connect);
        let interrupt = Interrupt::new();
        distributed::Worker { name, access, program }.serve(&|| interrupt.came())
    }
}

impl Group {
    pub(crate) fn run(self) -> Result<()> {
        end_with_parent()?;
        let order = Order { run: self.run, group: self.group, generation: self.generation };
        serve_group(&self.reach.access(self.connect), &order)
    }
}

/// The path of this executable.
pub(crate) fn this_program() -> Result<String> {
    let path = std::env::current_exe().map_err(|why| {
        Error::new(Code::Session, "this program does not know where it is").why(why)
    })?;
    path.into_os_string()
        .into_string()
        .map_err(|path| Error::new(Code::Session, "the path of this program is not UTF-8").at(path))
}

/// Nothing that was started for somebody outlives it, however that ends.
fn end_with_parent() -> Result<()> {
    use rustix::process::{Signal, getppid, set_parent_process_death_signal};
    let before = getppid();
    set_parent_process_death_signal(Some(Signal::KILL)).map_err(|why| {
        Error::new(Code::Session, "the process cannot be tied to its parent").why(why)
    })?;
    if getppid() != before || before.is_none() {
        return Err(Error::new(Code::Session, "the process that started this one is gone"));
    }
    Ok(())
}
