//! Creates an instance.

use std::ffi::{CString, c_char};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use fmu_standard::{Call, Phase};

use super::{Followed, Instance};
use crate::callbacks::{Callbacks, Known};
use crate::guard::Float;
use crate::library::{Component, Functions, Hot};
use crate::log::Log;
use crate::status;
use crate::{Fmu, InterfaceType, Logging};
use cosim_base::error::{Code, Error, Result};
use cosim_base::time::Time;

impl Instance {
    /// Instantiates `fmu` for co-simulation under `name`.
    pub fn new(fmu: Arc<Fmu>, name: &str, logging: &Logging) -> Result<Self> {
        Self::of(fmu, InterfaceType::CoSimulation, name, logging)
    }

    /// Instantiates `fmu` for that interface type.
    pub fn of(fmu: Arc<Fmu>, kind: InterfaceType, name: &str, logging: &Logging) -> Result<Self> {
        let once = fmu.interface(kind)?.once_per_process;
        let binary = fmu.binary(kind)?;
        let (functions, own) = (binary.functions, binary.own);
        if once && fmu.taken.swap(true, Ordering::AcqRel) {
            return Err(Error::new(Code::Fmu, format!("'{name}' cannot be instantiated"))
                .at(fmu.path())
                .why("the FMU allows one instance per process, and there is one already"));
        }
        let log = Log::new(logging.messages_of(name), logging.mailbox.clone(), name);
        let log = Known::new(log, name);
        let callbacks = Box::new(Callbacks::new(&log));
        let followed = Followed::of(logging, name, fmu.description()).map(Box::new);
        let mut instance = Self {
            component: std::ptr::null_mut(),
            name: name.to_owned(),
            phase: Phase::Instantiated,
            time: Time::ZERO,
            step: (Time::ZERO, 0.0),
            saved: Default::default(),
            callbacks: Some(callbacks),
            log,
            followed,
            hot: Hot::new(&functions, &own),
            kind,
            grid: None,
            usual: None,
            tolerance: None,
            functions,
            own,
            kept: Arc::default(),
            fmu,
        };
        for line in &instance.fmu.binary(kind)?.changed {
            instance.log.push_line(line);
        }
        instance.instantiate(logging)?;
        if instance.attempt(|instance| instance.choose_categories(logging))?.is_err() {
            instance.log.push_line("fmi2SetDebugLogging is refused: the FMU logs what it chooses");
        }
        Ok(instance)
    }

    fn instantiate(&mut self, logging: &Logging) -> Result<()> {
        let text = |text: &str| CString::new(text.replace('\0', "")).unwrap_or_default();
        let (name, guid) = (text(&self.name), text(&self.fmu.description().guid));
        let resources = self.fmu.resource_uri();
        let kind = self.kind as i32;
        // Categories are selected after this, and only then is anything logged.
        let debug = logging.debug && logging.categories.is_empty();
        if let Some(followed) = &self.followed {
            let (guid, kind) = (&self.fmu.description().guid, self.kind.name());
            followed.begin("fmi2Instantiate", self.time, |_| {
                format!("{:?}, {kind}, {guid:?}, {resources:?}, {debug}", self.name)
            });
        }
        let resources = text(&resources);
        let Some(callbacks) = self.callbacks.as_deref() else { return Ok(()) };
        let float = Float::now();
        // SAFETY: the strings live during the call, callbacks and log as long as the instance.
        self.component = unsafe {
            (self.functions.instantiate)(
                name.as_ptr(),
                kind,
                guid.as_ptr(),
                resources.as_ptr(),
                callbacks,
                0,
                i32::from(debug),
            )
        };
        float.check(&self.log, "fmi2Instantiate");
        self.check_process("fmi2Instantiate");
        self.log.is_of(self.component.addr());
        let made = !self.component.is_null();
        if let Some(followed) = &self.followed {
            followed.end("fmi2Instantiate", if made { status::OK } else { status::ERROR }, false);
        }
        if made { Ok(()) } else { Err(self.not_made()) }
    }

    fn not_made(&self) -> Error {
        let description = self.fmu.description();
        let tool = self.fmu.interface(self.kind).is_ok_and(|i| i.needs_execution_tool);
        let error = Error::new(Code::Fmu, format!("'{}' cannot be instantiated", self.name))
            .at(self.fmu.path())
            .why("fmi2Instantiate returned NULL")
            .log(self.log.take());
        if !tool {
            return error;
        }
        error.help(format!(
            "the FMU needs its tool: is '{}' installed?",
            description.generation_tool
        ))
    }

    /// Requests debug messages of all categories, or of none.
    pub fn debug(&mut self, on: bool) -> Result<()> {
        let set = |f: &Functions, c: Component| {
            // SAFETY: `c` is alive; an empty list is not read.
            unsafe { (f.set_debug_logging)(c, i32::from(on), 0, std::ptr::null()) }
        };
        self.call(Call::SetDebugLogging, |_| format!("{on}, []"), set)
    }

    fn choose_categories(&mut self, logging: &Logging) -> Result<()> {
        let declared = &self.fmu.description().log_categories;
        let wanted = |name: &&String| declared.is_empty() || declared.contains(name);
        let chosen: Vec<&String> = logging.categories.iter().filter(wanted).collect();
        if chosen.is_empty() {
            return Ok(());
        }
        let shown = format!("true, {chosen:?}");
        let texts: Vec<CString> =
            chosen.iter().filter_map(|name| CString::new(name.as_str()).ok()).collect();
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        let set = |f: &Functions, c: Component| {
            // SAFETY: `c` is alive; the strings live during the call.
            unsafe { (f.set_debug_logging)(c, 1, pointers.len(), pointers.as_ptr()) }
        };
        self.call(Call::SetDebugLogging, |_| shown, set)
    }
}
