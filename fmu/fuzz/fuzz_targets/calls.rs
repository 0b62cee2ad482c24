//! Random sequences of calls over all 44 functions, on the components of the tests. Reports every
//! million calls.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/fmi2/components.rs"]
mod components;
#[path = "../../tests/fmi2/driver.rs"]
mod driver;
#[path = "../../tests/fmi2/hybrid.rs"]
mod hybrid;
#[path = "../../tests/fmi2/random_calls.rs"]
mod random_calls;

use std::sync::atomic::{AtomicUsize, Ordering};

const MILLION: usize = 1_000_000;

static CALLS: AtomicUsize = AtomicUsize::new(0);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    // A panicking component is part of the test; libFuzzer's hook would end the process.
    std::panic::set_hook(Box::new(|_| {}));
    match std::panic::catch_unwind(|| random_calls::run(random_calls::Bytes(bytes))) {
        Ok(calls) => {
            let before = CALLS.fetch_add(calls, Ordering::Relaxed);
            if before / MILLION < (before + calls) / MILLION {
                eprintln!("{} million calls", (before + calls) / MILLION);
            }
        }
        Err(payload) => {
            let text = payload.downcast_ref::<String>().map_or("a failed check", String::as_str);
            eprintln!("{text}");
            std::process::abort();
        }
    }
});
