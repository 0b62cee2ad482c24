//! Serialized states from any source of bytes, after a correct header and before a correct
//! checksum; shared by the fuzz target and the ordinary tests. Accepted states must be usable,
//! rejected ones must be reported.

use std::ptr::{null, null_mut};

use fmu_kit::kernel::Status;
use sha2::{Digest, Sha256};

use crate::components::fmi2;
use crate::driver::{CS, Fmu, ME};

const HEAD: &[u8] = b"fmu-kit2";
/// Before the body: the header and its length. After it: the checksum.
const BEFORE: usize = 16;
const CHECKSUM: usize = 32;

/// Offers a state to instances: `bytes` as the body of one, or as changes to a valid one.
pub fn run(bytes: &[u8]) {
    let Some((choice, bytes)) = bytes.split_first() else {
        return;
    };
    let name = ["Spring", "Noise", "Ball", "Limiter", "Pendulum"][usize::from(choice / 4) % 5];
    let interface = if choice & 1 == 0 { CS } else { ME };
    let mut fmu = Fmu::started(name, interface);
    let body = if choice & 2 == 0 { bytes.to_vec() } else { changed(saved(&mut fmu), bytes) };
    offer(&mut fmu, &sealed(&body));
}

/// Every three bytes: a position and the new value.
fn changed(mut body: Vec<u8>, changes: &[u8]) -> Vec<u8> {
    for change in changes.chunks_exact(3) {
        let place = usize::from(u16::from_le_bytes([change[0], change[1]]));
        let n = body.len().max(1);
        if let Some(byte) = body.get_mut(place % n) {
            *byte = change[2];
        }
    }
    body
}

/// The body of a state of the instance.
fn saved(fmu: &mut Fmu) -> Vec<u8> {
    let (c, mut state, mut size) = (fmu.c, null_mut(), 0);
    unsafe {
        assert_eq!(fmi2::fmi2GetFMUstate(c, &raw mut state), Status::Ok);
        assert_eq!(fmi2::fmi2SerializedFMUstateSize(c, state, &raw mut size), Status::Ok);
        let mut bytes = vec![0_u8; size];
        let place = bytes.as_mut_ptr().cast();
        assert_eq!(fmi2::fmi2SerializeFMUstate(c, state, place, size), Status::Ok);
        assert_eq!(sealed(&bytes[BEFORE..size - CHECKSUM]), bytes);
        bytes[BEFORE..size - CHECKSUM].to_vec()
    }
}

fn sealed(body: &[u8]) -> Vec<u8> {
    let mut bytes = HEAD.to_vec();
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
    bytes.extend(Sha256::digest(&bytes));
    bytes
}

fn offer(fmu: &mut Fmu, bytes: &[u8]) {
    let mut state = null_mut();
    let (place, size) = (bytes.as_ptr().cast(), bytes.len());
    let read = unsafe { fmi2::fmi2DeSerializeFMUstate(fmu.c, place, size, &raw mut state) };
    assert_eq!(fmu.log().len(), usize::from(read != Status::Ok), "{read:?}");
    if read != Status::Ok {
        return;
    }
    let set = unsafe { fmi2::fmi2SetFMUstate(fmu.c, state) };
    assert_eq!(fmu.log().len(), usize::from(set != Status::Ok), "{set:?}");
    if set != Status::Ok {
        return;
    }
    // Finite but extreme states may have outputs that are not finite: that is reported, and the
    // instance survives.
    let (got, t) = fmu.try_get("time");
    assert_eq!(fmu.log().len(), usize::from(got != Status::Ok), "{got:?}");
    assert!(got != Status::Ok || t.is_finite(), "{t}");
    fmu.step(t, 0.01);
    unsafe {
        let mut size = 0;
        fmi2::fmi2SerializedFMUstateSize(fmu.c, state, &raw mut size);
        fmi2::fmi2GetReal(fmu.c, null(), 0, null_mut());
        fmi2::fmi2Reset(fmu.c);
    }
    fmu.log();
    assert_eq!((fmu.setup(0.0), fmu.initialize()), (Status::Ok, Status::Ok));
}
