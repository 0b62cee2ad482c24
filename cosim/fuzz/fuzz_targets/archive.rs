//! The ZIP reader: what it unpacks lies in its folder and is of the size it claimed.
#![no_main]
#![allow(dead_code)]

#[path = "../readers.rs"]
mod readers;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| readers::within(readers::archive, bytes));
