//! The variadic logger, which stable Rust cannot define: its entry point is a few assembly
//! instructions that store the argument registers in memory, as the prologue of every variadic C
//! function does, and pass them to Rust.
//!
//! * x86-64: System V ABI, 3.2.3 and 3.5.7: integers and pointers in rdi, rsi, rdx, rcx, r8, r9,
//!   doubles in xmm0 to xmm7 if al is not zero, the rest on the stack, 8 bytes each.
//! * AArch64: AAPCS64, 6.8.2: x0 to x7, v0 to v7, then the stack.
//!
//! `fmi2CallbackLogger` has five named arguments; the rest are variadic.

use std::ffi::c_char;

use super::Log;
use crate::status::RawStatus;

/// The five named arguments. To C it is a variadic function; Rust never calls it.
pub(crate) type Logger =
    unsafe extern "C" fn(*const Log, *const c_char, RawStatus, *const c_char, *const c_char);

/// Registers that hold named arguments.
const NAMED: usize = 5;

/// Number of integer registers that carry arguments.
#[cfg(not(target_arch = "aarch64"))]
const INTEGERS: usize = 6;
#[cfg(target_arch = "aarch64")]
const INTEGERS: usize = 8;
const FLOATS: usize = 8;

/// What the entry point stores, in this layout.
#[repr(C)]
pub(super) struct Saved {
    integers: [u64; INTEGERS],
    /// Of 16 bytes each; a double is in the lower half.
    floats: [[u64; 2]; FLOATS],
    /// The first argument on the stack.
    stack: *const u64,
}

/// The variadic arguments of one call, taken one after another.
///
/// Taking more than were passed returns other words of the stack, as in C: reading is harmless, and
/// the values are not trusted.
pub(super) struct Arguments {
    saved: *const Saved,
    integers: usize,
    floats: usize,
    stack: *const u64,
}

impl Arguments {
    /// # Safety
    /// `saved` belongs to a call that does not return while this value is used.
    unsafe fn new(saved: *const Saved) -> Self {
        // SAFETY: `saved` is alive.
        let stack = unsafe { (*saved).stack };
        Self { saved, integers: NAMED, floats: 0, stack }
    }

    /// The next integer or pointer. The upper half of an `int` is undefined.
    pub(super) fn word(&mut self) -> u64 {
        // SAFETY: `saved` is alive (see `new`).
        let saved = unsafe { &*self.saved };
        match saved.integers.get(self.integers) {
            Some(word) => {
                self.integers += 1;
                *word
            }
            None => self.next_on_stack(),
        }
    }

    /// The next `double`.
    pub(super) fn double(&mut self) -> f64 {
        // SAFETY: `saved` is alive (see `new`).
        let saved = unsafe { &*self.saved };
        match saved.floats.get(self.floats) {
            Some(register) => {
                self.floats += 1;
                f64::from_bits(register[0])
            }
            None => f64::from_bits(self.next_on_stack()),
        }
    }

    /// The next `long double`, as a double: 80 bits on the stack of x86-64, 128 bits in a vector
    /// register of AArch64.
    pub(super) fn long_double(&mut self) -> f64 {
        #[cfg(target_arch = "aarch64")]
        {
            // SAFETY: `saved` is alive (see `new`).
            let saved = unsafe { &*self.saved };
            if let Some(register) = saved.floats.get(self.floats) {
                self.floats += 1;
                return quadruple(register[0], register[1]);
            }
        }
        // Aligned to 16 bytes.
        if !self.stack.addr().is_multiple_of(16) {
            self.next_on_stack();
        }
        let (low, high) = (self.next_on_stack(), self.next_on_stack());
        if cfg!(target_arch = "aarch64") { quadruple(low, high) } else { extended(low, high) }
    }

    fn next_on_stack(&mut self) -> u64 {
        // SAFETY: above the caller's frame are those of its callers: at least a page, and `printf`
        // takes few arguments.
        let word = unsafe { self.stack.read() };
        self.stack = self.stack.wrapping_add(1);
        word
    }
}

/// x87 extended precision: sign, 15 bits of exponent, 64 bits of mantissa with its leading one.
fn extended(mantissa: u64, high: u64) -> f64 {
    let exponent = (high & 0x7fff) as i32;
    let sign = if high & 0x8000 == 0 { 1.0 } else { -1.0 };
    let magnitude = match (exponent, mantissa << 1) {
        (0x7fff, 0) => f64::INFINITY,
        (0x7fff, _) => f64::NAN,
        _ => libm::ldexp(mantissa as f64, (exponent - 16383 - 63).max(-2000)),
    };
    sign * magnitude
}

/// IEEE 754 binary128, to the precision of a double.
fn quadruple(low: u64, high: u64) -> f64 {
    let exponent = ((high >> 48) & 0x7fff) as i32;
    let sign = if high >> 63 == 0 { 1.0 } else { -1.0 };
    let fraction = ((high << 16) >> 4) | (low >> 52);
    let magnitude = match (exponent, fraction | (low << 12)) {
        (0x7fff, 0) => f64::INFINITY,
        (0x7fff, _) => f64::NAN,
        (0, _) => 0.0,
        // 60 bits of the fraction are enough.
        _ => libm::ldexp((fraction | 1 << 60) as f64, (exponent - 16383 - 60).max(-2000)),
    };
    sign * magnitude
}

/// # Safety
/// Called by [`logger`] only.
#[cfg(any(all(unix, target_arch = "x86_64"), all(target_os = "linux", target_arch = "aarch64")))]
unsafe extern "C" fn found(
    log: *const Log,
    instance: *const c_char,
    status: RawStatus,
    category: *const c_char,
    format: *const c_char,
    saved: *const Saved,
) {
    // SAFETY: `saved` lies in the frame of `logger`, which returns after this.
    let mut arguments = unsafe { Arguments::new(saved) };
    super::logged(log, instance, status, category, format, Some(&mut arguments));
}

/// The logger on x86-64. 216 bytes keep the stack aligned: 48 for integers, 128 for doubles, 8
/// for the pointer, 32 unused.
///
/// # Safety
/// Called as `fmi2CallbackLogger`.
#[cfg(all(unix, target_arch = "x86_64"))]
#[unsafe(naked)]
pub(super) unsafe extern "C" fn logger(
    _: *const Log,
    _: *const c_char,
    _: RawStatus,
    _: *const c_char,
    _: *const c_char,
) {
    std::arch::naked_asm!(
        "sub rsp, 216",
        "mov [rsp], rdi",
        "mov [rsp + 8], rsi",
        "mov [rsp + 16], rdx",
        "mov [rsp + 24], rcx",
        "mov [rsp + 32], r8",
        "mov [rsp + 40], r9",
        "test al, al",
        "je 2f",
        "movaps [rsp + 48], xmm0",
        "movaps [rsp + 64], xmm1",
        "movaps [rsp + 80], xmm2",
        "movaps [rsp + 96], xmm3",
        "movaps [rsp + 112], xmm4",
        "movaps [rsp + 128], xmm5",
        "movaps [rsp + 144], xmm6",
        "movaps [rsp + 160], xmm7",
        "2:",
        "lea rax, [rsp + 224]",
        "mov [rsp + 176], rax",
        "mov r9, rsp",
        "call {found}",
        "add rsp, 216",
        "ret",
        found = sym found,
    )
}

/// The logger on AArch64: 64 bytes for integers, 128 for floats, 8 for the pointer, 8 unused.
///
/// # Safety
/// Called as `fmi2CallbackLogger`.
#[cfg(all(target_os = "linux", target_arch = "aarch64"))]
#[unsafe(naked)]
pub(super) unsafe extern "C" fn logger(
    _: *const Log,
    _: *const c_char,
    _: RawStatus,
    _: *const c_char,
    _: *const c_char,
) {
    std::arch::naked_asm!(
        "stp x29, x30, [sp, #-16]!",
        "mov x29, sp",
        "sub sp, sp, #208",
        "stp x0, x1, [sp]",
        "stp x2, x3, [sp, #16]",
        "stp x4, x5, [sp, #32]",
        "stp x6, x7, [sp, #48]",
        "stp q0, q1, [sp, #64]",
        "stp q2, q3, [sp, #96]",
        "stp q4, q5, [sp, #128]",
        "stp q6, q7, [sp, #160]",
        "add x9, x29, #16",
        "str x9, [sp, #192]",
        "mov x5, sp",
        "bl {found}",
        "add sp, sp, #208",
        "ldp x29, x30, [sp], #16",
        "ret",
        found = sym found,
    )
}

/// The logger on other machines: the format is shown unchanged.
///
/// # Safety
/// Called as `fmi2CallbackLogger`.
#[cfg(not(any(
    all(unix, target_arch = "x86_64"),
    all(target_os = "linux", target_arch = "aarch64")
)))]
pub(super) unsafe extern "C" fn logger(
    log: *const Log,
    instance: *const c_char,
    status: RawStatus,
    category: *const c_char,
    format: *const c_char,
) {
    super::logged(log, instance, status, category, format, None);
}

#[cfg(test)]
mod tests;
