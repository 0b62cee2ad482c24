//! Threads that share instances and states, over all functions.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/fmi2/components.rs"]
mod components;
#[path = "../../tests/fmi2/driver.rs"]
mod driver;
#[path = "../../tests/fmi2/hybrid.rs"]
mod hybrid;
#[path = "../../tests/fmi2/random_threads.rs"]
mod random_threads;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    // A panicking component is part of the test; libFuzzer's hook would end the process.
    std::panic::set_hook(Box::new(|_| {}));
    random_threads::run(bytes);
});
