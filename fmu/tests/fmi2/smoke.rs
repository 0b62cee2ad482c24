//! A few hundred thousand random calls, the same every time.

use crate::random_calls::{Bytes, run};

fn random_calls(number: usize, mut random: u64) {
    let mut calls = 0;
    while calls < number {
        let bytes: Vec<u8> = (0..8000)
            .map(|_| {
                // xorshift64* (Marsaglia 2003; Vigna 2016)
                random ^= random >> 12;
                random ^= random << 25;
                random ^= random >> 27;
                (random.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 56) as u8
            })
            .collect();
        calls += run(Bytes(&bytes));
    }
}

#[test]
fn random_calls_always_return_and_are_told_of_once() {
    random_calls(300_000, 0x9E37_79B9_7F4A_7C15);
}

#[test]
#[ignore = "takes a minute"]
fn ten_million_random_calls() {
    random_calls(10_000_000, 0xD1CE_D1CE_D1CE_D1CE);
}
