//! A signal dictionary referenced by a system description.
#![no_main]
#![allow(dead_code)]

#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| readers::within(readers::ssb, bytes));
