//! What the resources of remote FMUs and of Python classes say.
#![no_main]
#![allow(dead_code)]

#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| readers::within(readers::manifest, bytes));
