//! `cosim proxy`: writes a remote FMU; also the program inside such an FMU.

use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;

use clap::Args;
use cosim::distributed::proxy::{self, Proxy as Writer};
use cosim::{Code, Error, Result, distributed};

use super::{messages, values};

/// Write an FMU that looks like another one and is computed by a worker, here or on another machine
#[derive(Args)]
pub(crate) struct Proxy {
    /// The FMU that workers compute; with --from, its file name there, or its SHA-256
    fmu: PathBuf,
    /// The worker NAME holds the FMU (--allow) and provides its description; the FMU stays there
    #[arg(long, value_name = "NAME", conflicts_with = "held")]
    from: Option<String>,
    /// Output FMU; an existing file is replaced
    #[arg(long, short, value_name = "FILE.fmu")]
    output: PathBuf,
    /// Where workers connect to the importer's machine (repeatable: the first free endpoint is
    /// used; default: tcp/127.0.0.1:7447)
    #[arg(long, value_name = "ENDPOINT")]
    listen: Vec<String>,
    /// A folder with ca.pem, cert.pem and key.pem (cosim keys), for endpoints tls/HOST:PORT
    #[arg(long, value_name = "FOLDER")]
    credentials: Option<PathBuf>,
    /// Allow an endpoint on another machine without TLS
    #[arg(long)]
    insecure: bool,
    /// The worker that computes it, if it is connected (default: any)
    #[arg(long, value_name = "NAME")]
    worker: Option<String>,
    /// How long to wait for a worker, in seconds (default: 10)
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    wait: Option<f64>,
    /// Give up a worker that does not answer within this many seconds (default: 5)
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    deadline: Option<f64>,
    /// Save the state after this many steps; 0: never (default: 50)
    #[arg(long, value_name = "N")]
    save_every: Option<u64>,
    /// Do not pack the FMU itself: only workers that hold it can compute it
    #[arg(long)]
    held: bool,
    /// The library of remote FMUs, one for each platform (repeatable; default:
    /// $COSIM_PROXY_LIBRARY, or libcosim_proxy.so beside this program or in ../lib/cosim)
    #[arg(long, value_name = "FILE.so")]
    library: Vec<PathBuf>,
    /// The program cosim, one for each platform (repeatable; default: this one)
    #[arg(long, value_name = "FILE")]
    program: Vec<PathBuf>,
    /// Show errors only
    #[arg(short, long)]
    quiet: bool,
}

impl Proxy {
    pub(crate) fn run(self) -> Result<()> {
        let writer = Writer::new().insecure(self.insecure).held(self.held);
        let writer = self.listen.into_iter().fold(writer, Writer::listen);
        let writer = self.credentials.into_iter().fold(writer, Writer::credentials);
        let writer = self.worker.into_iter().fold(writer, Writer::worker);
        let writer = self.wait.into_iter().fold(writer, Writer::wait);
        let writer = self.deadline.into_iter().fold(writer, Writer::deadline);
        let writer = self.save_every.into_iter().fold(writer, Writer::save_every);
        let writer = self.library.into_iter().fold(writer, Writer::library);
        let writer = self.program.into_iter().fold(writer, Writer::program);
        let notes = match &self.from {
            Some(worker) => {
                writer.write_offered(worker, &self.fmu.to_string_lossy(), &self.output)?
            }
            None => writer.write(&self.fmu, &self.output)?,
        };
        if !self.quiet {
            notes.iter().for_each(|text| messages::note(text));
            messages::info(&format!("written: {}", self.output.display()));
        }
        Ok(())
    }
}

/// Serve the library of a remote FMU at the other end of stdin
#[derive(Args)]
#[command(hide = true)]
pub(crate) struct Remote {}

impl Remote {
    pub(crate) fn run(self) -> Result<()> {
        distributed::close_inherited(&[]);
        let stdin = std::io::stdin().as_fd().try_clone_to_owned();
        let stream = stdin.map(UnixStream::from).and_then(|stream| {
            // Only a socket is accepted.
            stream.peer_addr().map(|_| stream)
        });
        let stream = stream.map_err(|why| {
            Error::new(Code::Usage, "stdin is not a socket")
                .why(why)
                .help("only the library of a remote FMU calls this")
        })?;
        proxy::serve(stream)
    }
}
