//! The components of a library, distinguished by their GUIDs.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use sha2::{Digest, Sha256};

use fmu_standard::InterfaceType;

use crate::author::{Component, Info, Resources};

use super::adapter::ComponentModel;
use super::dependencies::{self, Dependencies};
use super::description;
use super::documentation;
use super::instance::Instance;
use super::log::Sink;
use super::model::Model;
use super::served::Request;
use super::table::{Table, TableError};

/// One component of a library.
#[derive(Debug)]
pub struct Entry {
    info: Info,
    table: Arc<Table>,
    flaw: Option<TableError>,
    guid: Arc<str>,
    model: fn(&Table, Resources) -> Box<dyn Model>,
    dependencies: fn(&Table) -> Result<Dependencies, String>,
}

impl Entry {
    /// The entry of a component.
    #[must_use]
    pub fn of<C: Component>() -> Self {
        let (table, flaw) = match Table::of::<C>() {
            Ok(table) => (table, None),
            Err(flaw) => (Table::default(), Some(flaw)),
        };
        let text = description::write(&C::INFO, &table, "", None);
        Self {
            info: C::INFO,
            guid: guid(C::INFO.name, &text).into(),
            table: Arc::new(table),
            flaw,
            model: |table, resources| Box::new(ComponentModel::<C>::new(table, resources)),
            dependencies: dependencies::probe::<C>,
        }
    }

    /// Name, description, default experiment.
    #[must_use]
    pub fn info(&self) -> &Info {
        &self.info
    }

    /// The variables.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// What distinguishes this component, in this version of its interface, from all others.
    #[must_use]
    pub fn guid(&self) -> &str {
        &self.guid
    }

    /// The text of its modelDescription.xml.
    ///
    /// # Errors
    /// The variable table is invalid, or the component cannot be probed for its dependencies.
    pub fn describe(&self) -> Result<String, String> {
        let name = self.info.name;
        if let Some(flaw) = &self.flaw {
            return Err(format!("{name}: {flaw}"));
        }
        let dependencies =
            (self.dependencies)(&self.table).map_err(|reason| format!("{name}: {reason}"))?;
        Ok(description::write(&self.info, &self.table, &self.guid, Some(&dependencies)))
    }

    /// The text of its documentation/index.html; `chapters` is HTML shown before the variables.
    #[must_use]
    pub fn documentation(&self, chapters: &str) -> String {
        documentation::html(&self.info, &self.table, chapters)
    }

    /// Its variables as tables in Markdown.
    #[must_use]
    pub fn listing(&self) -> String {
        documentation::markdown(&self.info, &self.table)
    }

    /// A new instance.
    ///
    /// # Errors
    /// The interface is not offered, or the variable table is invalid.
    pub fn instantiate(
        &self,
        interface: InterfaceType,
        resources: Resources,
        sink: Box<dyn Sink>,
        logging_on: bool,
    ) -> Result<Instance, String> {
        let name = self.info.name;
        if let Some(flaw) = &self.flaw {
            return Err(format!("{name}: {flaw}"));
        }
        if interface == InterfaceType::ModelExchange && !self.info.model_exchange {
            return Err(format!("{name} offers co-simulation only, not model exchange"));
        }
        let model = (self.model)(&self.table, resources);
        Ok(Instance::new(
            Arc::clone(&self.table),
            Arc::clone(&self.guid),
            model,
            interface,
            sink,
            logging_on,
        ))
    }
}

/// A component that is built only on request: a library with many components is loaded for one.
#[derive(Debug)]
pub struct Deferred {
    name: &'static str,
    make: fn() -> Entry,
    made: OnceLock<Entry>,
}

impl Deferred {
    /// The entry of a component, to be built.
    #[must_use]
    pub const fn of<C: Component>() -> Self {
        Self { name: C::INFO.name, make: Entry::of::<C>, made: OnceLock::new() }
    }

    fn get(&self) -> &Entry {
        self.made.get_or_init(self.make)
    }
}

/// All components of a library.
#[derive(Debug)]
pub struct Registry {
    library: &'static str,
    entries: Vec<Deferred>,
}

impl Registry {
    /// A library of these components; `module` is the module that exports them.
    #[must_use]
    pub fn new(module: &'static str, entries: Vec<Deferred>) -> Self {
        Self { library: module.split("::").next().unwrap_or(module), entries }
    }

    /// Name of the library, as Cargo has it.
    #[must_use]
    pub fn library(&self) -> &'static str {
        self.library
    }

    /// The components in the order of the export.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter().map(Deferred::get)
    }

    /// A new instance of the component selected by the request's GUID.
    ///
    /// # Errors
    /// There is no such component, or it does not offer the interface.
    pub fn serve(&self, request: Request<'_>) -> Result<Instance, String> {
        let Request { interface, guid, resources, sink, logging_on, .. } = request;
        self.by_guid(guid)?.instantiate(interface, resources, sink, logging_on)
    }

    /// The component called `name`.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.name == name).map(Deferred::get)
    }

    /// The component with a GUID.
    ///
    /// # Errors
    /// There is none; the text names the requested GUID and the known ones.
    pub fn by_guid(&self, guid: &str) -> Result<&Entry, String> {
        let named = self.entries.iter().filter(|entry| guid.ends_with(&mark(entry.name)));
        named.map(Deferred::get).find(|entry| &*entry.guid == guid).ok_or_else(|| {
            let known: Vec<_> =
                self.entries().map(|e| format!("{} {}", e.info.name, e.guid)).collect();
            format!(
                "GUID \"{guid}\" is not one of this library's, which are {}; \
                 modelDescription.xml and library belong to different builds",
                known.join(", ")
            )
        })
    }
}

/// A registry that is built when it is first needed, and rebuilt after it was cleared: unlike a
/// static that is initialized once, it leaks nothing when the library is unloaded.
#[derive(Debug)]
pub struct Shared {
    make: fn() -> Registry,
    made: Mutex<Option<Arc<Registry>>>,
}

impl Shared {
    /// A registry that `make` will build.
    #[must_use]
    pub const fn new(make: fn() -> Registry) -> Self {
        Self { make, made: Mutex::new(None) }
    }

    /// The registry.
    pub fn get(&self) -> Arc<Registry> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(made.get_or_insert_with(|| Arc::new((self.make)())))
    }

    /// Drops it, at the latest when nothing uses it any more. It does not wait: at the end of a
    /// process, a thread that uses it may never release it.
    pub fn clear(&self) {
        if let Ok(mut made) = self.made.try_lock() {
            *made = None;
        }
    }
}

/// SHA-256 of the description and of the name in the usual form of a GUID.
fn guid(name: &str, text: &str) -> String {
    let mut guid = String::from("{");
    for (index, byte) in Sha256::digest(text.as_bytes()).iter().take(10).enumerate() {
        if matches!(index, 4 | 6 | 8) {
            guid.push('-');
        }
        guid.push_str(&format!("{byte:02x}"));
    }
    guid + &mark(name)
}

/// The end of a GUID, which identifies the component without the description.
fn mark(name: &str) -> String {
    let digest = Sha256::digest(name.as_bytes());
    let digits: String = digest.iter().take(6).map(|byte| format!("{byte:02x}")).collect();
    format!("-{digits}}}")
}
