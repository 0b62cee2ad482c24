//! All decoders of data from the network as one function of bytes: they may refuse the data, and
//! must do nothing else. For the fuzzer, and for a small test of the same kind.

use std::sync::Arc;

use super::failure::Failure;
use super::host::Host;
use super::pool::{Order, WorkerInfo};
use super::process_status::ProcessStatus;
use super::setup::{FmuFile, FmuSource, Setup};
use super::wire::{Body, Header};
use cosim_base::error::{Code, Error, Result};
use cosim_core::master::{Change, EngineState, Report, Tally};
use cosim_import::{Fmu, Scalar};

/// A source without FMUs.
struct Nothing;

impl FmuSource for Nothing {
    fn open(&mut self, file: &FmuFile) -> Result<Arc<Fmu>> {
        Err(Error::new(Code::File, format!("no {} here", file.name)))
    }
}

/// Decodes bytes as every kind of message; whether any decoder accepts them.
pub fn decode(bytes: &[u8]) -> bool {
    // Messages to and from workers have no header.
    let order = postcard::from_bytes::<Order>(bytes).is_ok();
    let info = postcard::from_bytes::<WorkerInfo>(bytes).is_ok();
    let status = postcard::from_bytes::<Result<ProcessStatus, String>>(bytes).is_ok();
    // A host accepts any bytes; without a set-up it does nothing with them.
    let mut host = Host::new(1, Box::new(Nothing));
    host.handle(bytes);
    let Ok((_, body)) = Header::read(bytes) else {
        return order || info || status;
    };
    values(body);
    let whole = body.whole().is_ok();
    let setup = body.structure::<Setup>().is_ok();
    let change = body.structure::<(usize, Change)>().is_ok();
    let failure = body.structure::<Failure>().map(|failure| failure.into_error("there")).is_ok();
    let state = state(body);
    let report = body.structure::<Report>().is_ok();
    whole || setup || change || failure || state || report
}

/// A part, values, and the end.
fn values(mut body: Body<'_>) {
    let mut read = [Scalar::default(); 4];
    if body.number().is_ok() && body.values(0..4, &[2], &mut read).is_ok() {
        // There may be bytes left over.
        drop(body.end());
    }
}

fn state(mut body: Body<'_>) -> bool {
    let blob = body.blob();
    blob.is_ok_and(|blob| postcard::from_bytes::<(EngineState, Tally)>(blob).is_ok())
}
