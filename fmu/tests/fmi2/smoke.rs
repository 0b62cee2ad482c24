//! A few hundred thousand random calls, some of them by several threads, and some thousand random
//! states, the same every time.

use crate::{random_calls, random_states, random_threads};

/// xorshift64* (Marsaglia 2003; Vigna 2016)
struct Random(u64);

impl Random {
    fn bytes(&mut self, n: usize) -> Vec<u8> {
        let byte = |_| {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 56) as u8
        };
        (0..n).map(byte).collect()
    }
}

fn calls(number: usize, seed: u64) {
    let (mut calls, mut random) = (0, Random(seed));
    while calls < number {
        calls += random_calls::run(random_calls::Bytes(&random.bytes(8000)));
    }
}

#[test]
fn random_calls_always_return_and_are_told_of_once() {
    calls(300_000, 0x9E37_79B9_7F4A_7C15);
}

#[test]
#[ignore = "takes a minute"]
fn ten_million_random_calls() {
    calls(10_000_000, 0xD1CE_D1CE_D1CE_D1CE);
}

#[test]
fn random_states_are_refused_or_usable() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for n in 0..20_000 {
        random_states::run(&random.bytes(1 + n % 40));
    }
}

#[test]
fn random_calls_of_several_threads_do_no_harm() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for _ in 0..300 {
        random_threads::run(&random.bytes(1600));
    }
}
