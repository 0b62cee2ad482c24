//! The reader of serialized states, after its checksum.
#![no_main]
#![allow(dead_code)]

#[path = "../../tests/fmi2/components.rs"]
mod components;
#[path = "../../tests/fmi2/driver.rs"]
mod driver;
#[path = "../../tests/fmi2/hybrid.rs"]
mod hybrid;
#[path = "../../tests/fmi2/random_states.rs"]
mod random_states;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| random_states::run(bytes));
