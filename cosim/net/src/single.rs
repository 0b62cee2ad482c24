//! One instance driven by another process: the worker side of a remote FMU.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::check::check_file;
use super::setup::{FmuFile, FmuSource};
use super::wire::{Body, Malformed, put_blob};
use cosim_base::error::{Code, Error, Result};
use cosim_import::calls::{Ask, Outcome, Trouble};
use cosim_import::{Instance, Logging, Mailbox, guard};

/// An instance to be made, from its start or from a state.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct SingleSetup {
    /// Name of the instance.
    pub name: String,
    /// Its FMU.
    pub file: FmuFile,
    /// Debug messages are requested from it.
    pub debug: bool,
    /// Calls that are made first.
    pub before: Vec<Ask>,
    /// A state that is restored after them.
    pub state: Option<Vec<u8>>,
}

/// The instance.
pub(super) struct Single {
    instance: Instance,
    mailbox: Arc<Mailbox>,
}

impl SingleSetup {
    /// Makes it.
    pub(super) fn build(self, fmus: &mut dyn FmuSource) -> Result<Single> {
        check_file(&self.file)?;
        guard::begin();
        fmus.permit(&self.name, &self.file)?;
        let mailbox = Arc::new(Mailbox::default());
        let logging = Logging {
            debug: self.debug,
            last: fmus.last_call(),
            mailbox: Some(mailbox.clone()),
            ..Logging::default()
        };
        let fmu = fmus.open(&self.file)?;
        let mut instance = Instance::new(fmu, &self.name, &logging)?;
        for ask in self.before.iter().chain(&self.state.map(Ask::Restore)) {
            instance.relay(ask)?;
        }
        // The messages have already been reported before the loss.
        if !self.before.is_empty() {
            mailbox.take();
        }
        Ok(Single { instance, mailbox })
    }

    /// Serializes it; also returns a digest of what both sides must agree on.
    pub(super) fn encode(&self) -> Result<(Vec<u8>, u64)> {
        let digest = Sha256::digest(&self.file.sha256);
        let first = digest.first_chunk::<8>().copied().unwrap_or_default();
        Ok((bytes(self)?, u64::from_le_bytes(first)))
    }
}

impl Single {
    /// Makes calls; the answer is their outcome, which is the same each time, followed by the
    /// messages.
    pub(super) fn obey(&mut self, body: Body<'_>) -> Result<Vec<u8>> {
        let unread = |why| Error::new(Code::Protocol, "calls cannot be understood").why(why);
        let asks: Vec<Ask> = body.structure().map_err(unread)?;
        let mut outcome = Outcome::default();
        for ask in &asks {
            match self.instance.relay(ask) {
                Ok(given) => outcome.given.push(given),
                Err(error) => {
                    outcome.trouble = Some(trouble(&error));
                    break;
                }
            }
        }
        let mut answer = Vec::with_capacity(512);
        put_blob(&mut answer, &bytes(&outcome)?);
        answer.extend(bytes(&self.mailbox.take())?);
        Ok(answer)
    }
}

fn trouble(error: &Error) -> Trouble {
    let why = error.reason().map(|why| format!(": {why}")).unwrap_or_default();
    Trouble {
        status: error.status().unwrap_or(cosim_import::status::ERROR),
        text: format!("{}{why}", error.what()),
        ended: error.code() == Code::Ended,
    }
}

/// Reads an answer: outcome and messages.
pub(super) fn read(answer: &[u8]) -> Result<(Outcome, Vec<cosim_import::Message>), Malformed> {
    let mut body = Body::after_header(answer);
    let outcome = postcard::from_bytes(body.blob()?);
    let outcome = outcome.map_err(|e| Malformed::Body(e.to_string()))?;
    Ok((outcome, body.structure()?))
}

pub(super) fn bytes<T: Serialize>(value: &T) -> Result<Vec<u8>> {
    postcard::to_stdvec(value)
        .map_err(|why| Error::new(Code::Protocol, "a message cannot be serialized").why(why))
}
