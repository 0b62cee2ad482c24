//! The reader of serialized states, behind its checksum: any bytes as the body of a state with the
//! right head and the right checksum. What is taken must be usable.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/fmi2/components.rs"]
mod components;
#[path = "../../tests/fmi2/driver.rs"]
mod driver;
#[path = "../../tests/fmi2/hybrid.rs"]
mod hybrid;

use components::fmi2;
use driver::{CS, Fmu};
use fmu_kit::kernel::Status;
use sha2::{Digest, Sha256};

libfuzzer_sys::fuzz_target!(|body: &[u8]| {
    let mut bytes = b"fmu-kit1".to_vec();
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
    bytes.extend(Sha256::digest(&bytes));
    for name in ["Spring", "Noise", "Ball"] {
        let mut fmu = Fmu::started(name, CS);
        let mut state = std::ptr::null_mut();
        unsafe {
            let (place, size) = (bytes.as_ptr().cast(), bytes.len());
            let status = fmi2::fmi2DeSerializeFMUstate(fmu.c, place, size, &raw mut state);
            if status == Status::Ok && fmi2::fmi2SetFMUstate(fmu.c, state) == Status::Ok {
                let t = fmu.get("time");
                fmu.step(t, 0.01);
            }
        }
    }
});
