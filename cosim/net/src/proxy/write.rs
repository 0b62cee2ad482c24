//! Writes a remote FMU.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use super::description::{self, can_save};
use super::settings::Settings;
use super::shell;
use crate::AvailableFmu;
use cosim_base::error::{Code, Error, Result};
use cosim_base::xml;
use cosim_import::proxy::MARK;
use cosim_import::proxy::manifest::{self, CONNECTION, FILE, Manifest};
use cosim_import::{Fmu, InterfaceType, archive as packed, elf};
use cosim_pack::archive::{self, Content};
use cosim_pack::library::{self, Kind, Library};
use cosim_pack::{guid, identifier};

/// The library of remote FMUs.
const LIBRARY: Kind = Kind {
    variable: "COSIM_PROXY_LIBRARY",
    file: "libcosim_proxy.so",
    mark: MARK,
    of: "remote FMUs",
};

/// Writes an FMU that is computed by a worker.
///
/// ```no_run
/// use cosim_net::proxy::Proxy;
///
/// Proxy::new().listen("tls/0.0.0.0:7447").credentials("keys/orchestrator").write("Ekf.fmu", "Ekf.remote.fmu")?;
/// # Ok::<(), cosim_base::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Proxy {
    settings: Settings,
    held: bool,
    libraries: Vec<PathBuf>,
    programs: Vec<PathBuf>,
}

impl Proxy {
    /// For workers that connect to this machine's loopback address.
    pub fn new() -> Self {
        Self::default()
    }

    /// Where workers connect: the first free one of several endpoints.
    #[must_use]
    pub fn listen(mut self, endpoint: impl Into<String>) -> Self {
        self.settings.listen.push(endpoint.into());
        self
    }

    /// A folder with ca.pem, cert.pem and key.pem, for TLS.
    #[must_use]
    pub fn credentials(mut self, folder: impl Into<PathBuf>) -> Self {
        self.settings.credentials = Some(folder.into());
        self
    }

    /// An endpoint on another machine needs no TLS.
    #[must_use]
    pub fn insecure(mut self, insecure: bool) -> Self {
        self.settings.insecure = insecure;
        self
    }

    /// The worker that computes it, if it is connected.
    #[must_use]
    pub fn worker(mut self, name: impl Into<String>) -> Self {
        self.settings.worker = Some(name.into());
        self
    }

    /// How long to wait for a worker, in seconds.
    #[must_use]
    pub fn wait(mut self, seconds: f64) -> Self {
        self.settings.wait = Some(seconds);
        self
    }

    /// How long an answer may take, in seconds.
    #[must_use]
    pub fn deadline(mut self, seconds: f64) -> Self {
        self.settings.deadline = Some(seconds);
        self
    }

    /// The state is saved after this many steps; 0: never.
    #[must_use]
    pub fn save_every(mut self, steps: u64) -> Self {
        self.settings.save_every = Some(steps);
        self
    }

    /// The FMU is not packed: workers must have it.
    #[must_use]
    pub fn held(mut self, held: bool) -> Self {
        self.held = held;
        self
    }

    /// The library, one for each platform.
    #[must_use]
    pub fn library(mut self, path: impl Into<PathBuf>) -> Self {
        self.libraries.push(path.into());
        self
    }

    /// The program `cosim`, one for each platform.
    #[must_use]
    pub fn program(mut self, path: impl Into<PathBuf>) -> Self {
        self.programs.push(path.into());
        self
    }

    /// Writes the remote FMU of a file, replacing an existing one as a whole; returns notes.
    pub fn write(&self, fmu: impl AsRef<Path>, path: impl AsRef<Path>) -> Result<Vec<String>> {
        let (fmu, path) = (fmu.as_ref(), path.as_ref());
        check_paths(fmu, path)?;
        let parts = self.parts()?;
        let opened = Fmu::open(fmu)?;
        let binaries = binaries(&opened)?;
        let own = Content::file(opened.path().to_owned())?;
        let name = fmu.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let sha256 = own.digest().to_owned();
        let own = (!self.held).then_some(own);
        self.write_of(&Original { fmu: &opened, name, sha256 }, own, parts, path)?;
        Ok(notes(&opened, &binaries))
    }

    /// Writes the remote FMU of an FMU that a worker holds, given by its file name or its SHA-256:
    /// the worker provides the description, and the FMU itself stays there.
    pub fn write_offered(
        &self,
        worker: &str,
        fmu: &str,
        path: impl AsRef<Path>,
    ) -> Result<Vec<String>> {
        let path = path.as_ref();
        archive::check_ending(path)?;
        let parts = self.parts()?;
        let available =
            AvailableFmu::ask(&self.settings.accesses(), worker, fmu, self.settings.patience()?)?;
        let (opened, _folder) = shell::open(&available.shell, &available.name)?;
        let original = Original { fmu: &opened, name: available.name, sha256: available.sha256 };
        self.write_of(&original, None, parts, path)?;
        let platforms: Vec<&str> = available.platforms.iter().map(String::as_str).collect();
        Ok(notes(&opened, &platforms))
    }

    /// Everything that does not depend on the FMU; fails if anything is missing.
    fn parts(&self) -> Result<Parts> {
        let connection = self.settings.text()?;
        let libraries = library::find(&LIBRARY, &self.libraries)?;
        let programs = self.programs(&libraries)?;
        Ok(Parts { connection, libraries, programs })
    }

    fn write_of(
        &self,
        original: &Original<'_>,
        own: Option<Content>,
        parts: Parts,
        path: &Path,
    ) -> Result<()> {
        let Original { fmu, name, sha256 } = original;
        let Parts { connection, libraries, programs } = parts;
        let interface = fmu.interface(InterfaceType::CoSimulation)?;
        let file = fmu.path();
        let for_people = packed::unpack_part(file, shell::is_for_people)?;
        let shown = file.join("modelDescription.xml");
        let root = xml::read(&fmu.folder().join("modelDescription.xml"), &shown)?;
        let identifier = identifier(&format!("{}_remote", interface.model_identifier));
        let mut manifest = Manifest::new(fmu.description(), interface, name, sha256);
        let once = self.settings.accesses().len() == 1;
        let draft = description::text(&root, interface, once, &identifier, "");
        manifest.guid = guid([draft.as_bytes(), sha256.as_bytes()].into_iter());
        let text = description::text(&root, interface, once, &identifier, &manifest.guid);
        let mut entries = vec![("modelDescription.xml".to_owned(), Content::bytes(text))];
        entries.extend(archive::files(for_people.path())?);
        entries.extend(libraries.into_iter().map(|library| {
            let name = format!("binaries/{}/{identifier}.so", library.folder);
            (name, Content::bytes(library.bytes))
        }));
        entries.push((format!("resources/{FILE}"), Content::bytes(manifest.text()?)));
        entries.push((format!("resources/{CONNECTION}"), Content::bytes(connection)));
        entries.extend(programs.into_iter().map(|(platform, content)| {
            (format!("resources/{}", manifest::place(platform)), content)
        }));
        entries.extend(own.map(|own| (format!("resources/{name}"), own)));
        archive::write(path, &entries)
    }

    /// The program for the platform of each library; for this platform it is the running one.
    fn programs(&self, libraries: &[Library]) -> Result<Vec<(&'static str, Content)>> {
        let unread = |file: &Path, why: String| {
            Error::new(Code::File, "the program cosim cannot be read").at(file).why(why)
        };
        let own = env::current_exe().ok().filter(|_| self.programs.is_empty());
        let mut found = Vec::new();
        for file in self.programs.iter().chain(&own) {
            let bytes = fs::read(file).map_err(|why| unread(file, why.to_string()))?;
            let platform = elf::platform(&bytes).map_err(|why| unread(file, why))?;
            found.push((platform, Content::bytes(bytes)));
        }
        let lacks = |library: &&Library| !found.iter().any(|(p, _)| *p == library.folder);
        match libraries.iter().find(lacks) {
            None => Ok(found),
            Some(library) => {
                let what = format!("there is no program cosim for {}", library.folder);
                Err(Error::new(Code::Usage, what)
                    .at(&library.path)
                    .why("this library is for that platform")
                    .help("specify the program of each platform with --program"))
            }
        }
    }
}

/// The original FMU.
struct Original<'a> {
    fmu: &'a Fmu,
    /// Its file name.
    name: String,
    sha256: String,
}

/// The parts of every remote FMU.
struct Parts {
    connection: String,
    libraries: Vec<Library>,
    programs: Vec<(&'static str, Content)>,
}

fn notes(fmu: &Fmu, platforms: &[&str]) -> Vec<String> {
    let state = match fmu.interface(InterfaceType::CoSimulation).is_ok_and(can_save) {
        true => "its state can be saved: after the loss of a worker it is continued from there",
        false => "its state cannot be saved: after a loss it is computed again from the start",
    };
    vec![format!("computed on workers with {}", platforms.join(", ")), state.to_owned()]
}

fn check_paths(fmu: &Path, path: &Path) -> Result<()> {
    archive::check_ending(path)?;
    match (fmu.canonicalize(), path.canonicalize()) {
        (Ok(one), Ok(other)) if one == other => {
            Err(Error::new(Code::Usage, "the remote FMU would replace the FMU itself")
                .at(path)
                .help("choose another name: -o NAME.remote.fmu"))
        }
        _ => Ok(()),
    }
}

/// The platforms of workers that can compute it, by the folders of its binaries.
pub(super) fn binaries(fmu: &Fmu) -> Result<Vec<&'static str>> {
    fmu.interface(InterfaceType::CoSimulation)
        .map_err(|error| error.help("export it as an FMU for co-simulation first: cosim export"))?;
    let here = elf::here();
    let has = |folder: &&&str| fmu.has_binaries(folder);
    let found: Vec<&str> =
        elf::all_folders().filter_map(|names| names.iter().find(has)).copied().collect();
    if found.is_empty() || here.is_some_and(|here| found.contains(&here)) {
        // A binary for this machine is checked more closely; without any, the error lists the
        // existing ones.
        fmu.digest(InterfaceType::CoSimulation)?;
    }
    Ok(found)
}
