//! A whole system as one FMU for co-simulation (FMI 2.0).
//!
//! Its resources contain the description of the system, as written by `System::write`, the unpacked
//! FMUs, and the meaning of the value references. Its library is the same for all systems and runs
//! them with the engine (`cosim_core::hosted`). Everything is checked before it is written, and the
//! same system gives the same bytes.
//!
//! | file | what |
//! |---|---|
//! | `choice` | which variables are exposed |
//! | `description`, `definitions`, `feedthrough` | modelDescription.xml: variables, units and types, dependencies |
//! | `documentation` | documentation, licences, icon |
//! | `library` | the binaries, and whether the inner FMUs have theirs |
//! | `archive` | the file |

#![forbid(unsafe_code)]

pub mod archive;
mod choice;
mod definitions;
mod description;
mod documentation;
mod feedthrough;
pub mod library;

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use archive::{Content, Entry};
use choice::Chosen;
use cosim_base::error::Result;
use cosim_base::files;
use cosim_core::hosted::MARK;
use cosim_core::hosted::{self, Interface, Running};
use cosim_core::master::Manipulator;
use cosim_core::scenario::Scenario;
use cosim_core::system::{Packed, System};
use cosim_import::Value;
use cosim_import::archive::{Unpacked, unpack_part};
use description::Description;

/// The library of exported systems.
const LIBRARY: library::Kind = library::Kind {
    variable: "COSIM_SYSTEM_LIBRARY",
    file: "libcosim_system.so",
    mark: MARK,
    of: "exported systems",
};

/// How to export a system as an FMU.
///
/// ```no_run
/// use cosim_core::{Overrides, System};
/// use cosim_pack::Export;
///
/// let system = System::load("vehicle.ssd", &Overrides::new())?;
/// Export::new().hide("*.sigma.*").write(&system, "Vehicle.fmu")?;
/// # Ok::<(), cosim_core::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Export {
    name: Option<String>,
    expose: Vec<String>,
    hide: Vec<String>,
    libraries: Vec<PathBuf>,
    scenario: Option<PathBuf>,
}

impl Export {
    /// Exposes all outputs, all parameters and all unconnected inputs, for this machine.
    pub fn new() -> Self {
        Self::default()
    }

    /// The name of the model; by default that of the system.
    #[must_use]
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// Exposes this variable, or those that the pattern (`*`, `?`) matches, and only variables
    /// selected in this way. Connected inputs and local variables can be exposed, too.
    #[must_use]
    pub fn expose(mut self, pattern: impl Into<String>) -> Self {
        self.expose.push(pattern.into());
        self
    }

    /// Hides this variable, or those that the pattern matches.
    #[must_use]
    pub fn hide(mut self, pattern: impl Into<String>) -> Self {
        self.hide.push(pattern.into());
        self
    }

    /// The library that serves the system, one for each platform.
    #[must_use]
    pub fn library(mut self, path: impl Into<PathBuf>) -> Self {
        self.libraries.push(path.into());
        self
    }

    /// Applies the faults and changes of this file in the FMU. None may wait for a condition or end
    /// the run: there are no recorded values, and the importer decides when it ends.
    #[must_use]
    pub fn scenario(mut self, file: impl Into<PathBuf>) -> Self {
        self.scenario = Some(file.into());
        self
    }

    /// Writes the FMU, replacing an existing one as a whole; returns notes.
    pub fn write(&self, system: &System, path: impl AsRef<Path>) -> Result<Vec<String>> {
        let path = path.as_ref();
        system.ready()?;
        archive::check_ending(path)?;
        let inputs = system.files().chain(self.scenario.as_deref());
        files::refuse_inputs(path, inputs)?;
        let libraries = library::find(&LIBRARY, &self.libraries)?;
        libraries.iter().try_for_each(|library| library::check(library, system))?;
        let chosen = choice::choose(system, &self.expose, &self.hide)?;
        let packed = system.packed("fmus/")?;
        let inner = packed.fmus.iter().map(|(name, path)| {
            let folder = unpack_part(path, is_included)?;
            Ok(Inner { name: name.clone(), path: path.clone(), folder })
        });
        let inner = inner.collect::<Result<Vec<_>>>()?;
        let entries = self.entries(system, &chosen, packed, &inner, libraries)?;
        archive::write(path, &entries)?;
        Ok(notes(system, &chosen))
    }

    fn entries(
        &self,
        system: &System,
        chosen: &[Chosen],
        packed: Packed,
        inner: &[Inner],
        libraries: Vec<library::Library>,
    ) -> Result<Vec<Entry>> {
        let model_name = self.name.as_deref().unwrap_or(system.name());
        let identifier = identifier(model_name);
        let description = Description { system, chosen, model_name, identifier: &identifier };
        let exposed = chosen.iter().map(|chosen| chosen.exposed.clone()).collect();
        let mut interface = Interface::new(packed.name, running(system), exposed);
        if let Some(file) = &self.scenario {
            let scenario = Scenario::read(file)?;
            scenario.runs_without_records().map_err(|why| why.at(file))?;
            scenario.clone().start(system, None)?;
            interface.scenario = Some(scenario);
        }
        let mut inside = Vec::new();
        for Inner { name, folder, .. } in inner {
            let files = archive::files(folder.path())?.into_iter();
            let files = files.filter(|(file, _)| !file.starts_with("documentation/"));
            inside.extend(files.map(|(file, what)| (format!("resources/{name}/{file}"), what)));
        }
        let (described, listed) = (description.text("")?, interface.bytes()?);
        let files = inside.iter().map(|(_, content)| content.digest().as_bytes());
        let parts = [described.as_bytes(), packed.text.as_bytes(), &listed].into_iter();
        let guid = guid(parts.chain(files));
        interface.guid.clone_from(&guid);
        let text = description.text(&guid)?;
        let mut entries = vec![("modelDescription.xml".to_owned(), Content::bytes(text))];
        entries.extend(documentation::entries(&description, &guid, inner, &libraries)?);
        entries.extend(libraries.into_iter().map(|library| {
            let name = format!("binaries/{}/{identifier}.so", library.folder);
            (name, Content::bytes(library.bytes))
        }));
        entries.push((format!("resources/{}", packed.name), Content::bytes(packed.text)));
        let list = Content::bytes(interface.bytes()?);
        entries.push((format!("resources/{}", hosted::FILE), list));
        entries.extend(inside);
        Ok(entries)
    }
}

/// An FMU of the system.
struct Inner {
    /// Its folder in the resources.
    name: String,
    path: PathBuf,
    folder: Unpacked,
}

/// Whether a file of an FMU is included: of its documentation, only the licences are, beside those of
/// the other FMUs.
fn is_included(file: &Path) -> bool {
    !file.starts_with("documentation") || file.starts_with(documentation::LICENSES)
}

/// How the system is run, as far as its description does not specify it.
fn running(system: &System) -> Running {
    let linear = system.connections().iter().enumerate();
    let linear = linear.filter(|(position, _)| system.is_linear(*position));
    Running {
        algorithm: system.algorithm().to_string(),
        solver: system.solver().method,
        tolerance: system.tolerance(),
        step_control: system.step_control(),
        retries: system.retries(),
        linear: linear.map(|(_, connection)| system.port_name(connection.to)).collect(),
    }
}

/// SHA-256 of the contents in the usual form of a GUID.
pub fn guid<'p>(parts: impl Iterator<Item = &'p [u8]>) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    let digits: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    let (a, b, c, d, e) =
        (&digits[..8], &digits[8..12], &digits[12..16], &digits[16..20], &digits[20..32]);
    format!("{{{a}-{b}-{c}-{d}-{e}}}")
}

/// A name as an identifier of C, which names the library file.
pub fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    match name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        true => name,
        false => format!("system_{name}"),
    }
}

/// Notes on files that are not included.
fn notes(system: &System, chosen: &[Chosen]) -> Vec<String> {
    let mut notes = Vec::new();
    for component in system.components() {
        let texts = component.start_values.iter().filter_map(|(variable, value)| match value {
            Value::String(text) => Some((component.model.variable_name(*variable), text)),
            _ => None,
        });
        for (name, text) in texts.filter(|(_, text)| Path::new(text).is_absolute()) {
            notes.push(format!(
                "'{}.{name}' names {text}, which stays where it is: the FMU needs it there",
                component.name
            ));
        }
    }
    let count = |role| chosen.iter().filter(|chosen| chosen.exposed.role == role).count();
    let inputs = count(hosted::Role::Input);
    notes.push(format!("{} variables are shown, {inputs} of them inputs", chosen.len()));
    notes
}
