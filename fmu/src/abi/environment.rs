//! The floating-point environment during a call: rounding to nearest, gradual underflow, no traps,
//! whatever the importer uses; afterwards the importer's environment is restored, flags included.
//!
//! Rust is compiled for this environment and no other. Only the unit that Rust uses is handled:
//! MXCSR of x86-64 (nothing here computes on the x87), FPCR and FPSR of AArch64. On other machines
//! the importer has to call with the default environment.

use machine::{DEFAULT, is_default, read, write};

/// The importer's floating-point environment, restored when this is dropped.
#[must_use]
pub(super) struct Environment {
    before: machine::Word,
}

impl Environment {
    /// Ensures that the environment is the default one.
    #[inline(always)]
    pub(super) fn enter() -> Self {
        let before = read();
        if !is_default(before) {
            change(DEFAULT);
        }
        Self { before }
    }
}

impl Drop for Environment {
    #[inline(always)]
    fn drop(&mut self) {
        if read() != self.before {
            change(self.before);
        }
    }
}

#[cold]
#[inline(never)]
fn change(word: machine::Word) {
    write(word);
}

/// Two numbers, known to the compiler only from here on: values computed from an argument are not
/// computed before the environment is the default one.
#[inline(always)]
pub(super) fn from_here(mut a: f64, mut b: f64) -> (f64, f64) {
    // SAFETY: no instruction at all; assembly blocks keep their order.
    #[cfg(target_arch = "x86_64")]
    unsafe {
        std::arch::asm!("/* {0} {1} */", inout(xmm_reg) a, inout(xmm_reg) b,
            options(nostack, preserves_flags));
    }
    // SAFETY: likewise.
    #[cfg(target_arch = "aarch64")]
    unsafe {
        std::arch::asm!("/* {0:d} {1:d} */", inout(vreg) a, inout(vreg) b,
            options(nostack, preserves_flags));
    }
    (a, b)
}

#[cfg(target_arch = "x86_64")]
mod machine {
    use std::arch::asm;

    /// MXCSR.
    pub(super) type Word = u32;
    /// All exceptions masked, nearest, gradual underflow, no flag raised.
    pub(super) const DEFAULT: Word = 0x1F80;
    const FLAGS: Word = 0x3F;

    #[inline(always)]
    pub(super) fn is_default(word: Word) -> bool {
        word & !FLAGS == DEFAULT
    }

    #[inline(always)]
    pub(super) fn read() -> Word {
        let mut word = 0_u32;
        // SAFETY: stores four bytes to a location of four bytes.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags)) };
        word
    }

    #[inline(always)]
    pub(super) fn write(word: Word) {
        // SAFETY: the word is the default or was read before.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags)) };
    }
}

#[cfg(target_arch = "aarch64")]
mod machine {
    use std::arch::asm;

    /// FPCR and FPSR.
    pub(super) type Word = (u64, u64);
    /// No traps, nearest, gradual underflow, no flag raised.
    pub(super) const DEFAULT: Word = (0, 0);

    #[inline(always)]
    pub(super) fn is_default((control, _): Word) -> bool {
        control == DEFAULT.0
    }

    #[inline(always)]
    pub(super) fn read() -> Word {
        let (control, status): (u64, u64);
        // SAFETY: reading them changes nothing.
        unsafe {
            asm!("mrs {0}, fpcr", "mrs {1}, fpsr", out(reg) control, out(reg) status,
                options(nostack, preserves_flags));
        }
        (control, status)
    }

    #[inline(always)]
    pub(super) fn write((control, status): Word) {
        // SAFETY: the words are the default or were read before.
        unsafe {
            asm!("msr fpcr, {0}", "msr fpsr, {1}", in(reg) control, in(reg) status,
                options(nostack, preserves_flags));
        }
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod machine {
    pub(super) type Word = ();
    pub(super) const DEFAULT: Word = ();

    pub(super) const fn is_default((): Word) -> bool {
        true
    }

    pub(super) const fn read() -> Word {}

    pub(super) const fn write((): Word) {}
}
