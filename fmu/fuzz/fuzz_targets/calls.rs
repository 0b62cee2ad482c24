//! Random sequences of calls over all 44 functions, on the components of the tests.
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

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    // A panicking component is part of the game; libFuzzer's hook would end the process at it.
    std::panic::set_hook(Box::new(|_| {}));
    let calls = std::panic::catch_unwind(|| random_calls::run(random_calls::Bytes(bytes)));
    if calls.is_err() {
        std::process::abort();
    }
});
