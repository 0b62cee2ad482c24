//! The ZIP reader: what it unpacks is in its folder and has the declared size.
#![no_main]
#![allow(dead_code)]

#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| readers::within(readers::archive, bytes));
