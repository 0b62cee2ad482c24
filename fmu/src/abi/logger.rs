//! The importer's logger as a [`Sink`].

use std::ffi::{CStr, CString};

use crate::kernel::{Category, Sink, Status};

use super::types::{fmi2CallbackFunctions, fmi2CallbackLogger, fmi2ComponentEnvironment};

/// The importer's logger with its arguments.
pub(super) struct Logger {
    callback: Option<fmi2CallbackLogger>,
    environment: fmi2ComponentEnvironment,
    instance_name: CString,
}

// SAFETY: the environment is only passed back to the importer, from the thread on which the
// importer called; FMI lets it call from any one thread at a time.
unsafe impl Send for Logger {}

impl Logger {
    pub(super) fn new(functions: &fmi2CallbackFunctions, instance_name: &CStr) -> Self {
        Self {
            callback: functions.logger,
            environment: functions.componentEnvironment,
            instance_name: instance_name.to_owned(),
        }
    }
}

impl Sink for Logger {
    fn write(&self, status: Status, category: Category, text: &str) {
        let Some(callback) = self.callback else {
            return;
        };
        // One line, whatever a panic or a file name contains.
        let text = CString::new(text.replace(char::is_control, " ")).unwrap_or_default();
        let category = CString::new(category.name()).unwrap_or_default();
        // SAFETY: the importer gave this function to be called in this way; all strings are
        // NUL-terminated and outlive the call. The message is an argument of "%s", never a format
        // itself.
        unsafe {
            callback(
                self.environment,
                self.instance_name.as_ptr(),
                status,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}
