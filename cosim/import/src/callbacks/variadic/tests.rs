//! Tests that call the logger as C does.

use super::*;
use crate::callbacks::Known;

type Variadic =
    unsafe extern "C" fn(*const Log, *const c_char, RawStatus, *const c_char, *const c_char, ...);

/// Calls the logger with a format and arguments; returns the logged line.
macro_rules! logged {
    ($format:literal $(, $argument:expr)*) => {{
        let log = Known::new(Log::default(), "it");
        // SAFETY: to C the logger is a variadic function; the arguments are those of the format.
        unsafe {
            let call: Variadic = std::mem::transmute(logger as Logger);
            call(&*log, c"it".as_ptr(), 1, c"logAll".as_ptr(), $format.as_ptr() $(, $argument)*);
        }
        let line = log.take().remove(0);
        line.strip_prefix("Warning (logAll): ").unwrap().to_owned()
    }};
}

#[test]
fn registers_and_stack() {
    assert_eq!(logged!(c"plain 100%%"), "plain 100%");
    assert_eq!(logged!(c"%d %s", 7_i32, c"tank".as_ptr()), "7 tank");
    // Three words on the stack after the registers of either machine.
    let line = logged!(c"%d %d %d %d %d %ld", -1_i32, 2_i32, -3_i32, 4_i32, 5_i32, i64::MIN);
    assert_eq!(line, "-1 2 -3 4 5 -9223372036854775808");
    // Ten doubles: eight in registers, two on the stack, with a word and a pointer between them.
    let line = logged!(
        c"%g %g %g %g %s %g %g %g %g %d %g %.3f",
        0.5,
        1.5,
        2.5,
        3.5,
        c"x".as_ptr(),
        4.5,
        5.5,
        6.5,
        7.5,
        42_i32,
        8.5,
        1.0 / 3.0
    );
    assert_eq!(line, "0.5 1.5 2.5 3.5 x 4.5 5.5 6.5 7.5 42 8.5 0.333");
}

#[test]
fn extended_precision() {
    assert_eq!(extended(1 << 63, 16383), 1.0);
    assert_eq!(extended(3 << 62, 0x8000 | 16384), -3.0);
    assert_eq!(extended(1 << 63, 0x7fff), f64::INFINITY);
    assert!(extended(3 << 62, 0x7fff).is_nan());
    assert_eq!((extended(0, 0), extended(1, 0)), (0.0, 0.0));
}

#[test]
fn quadruple_precision() {
    assert_eq!(quadruple(0, 0x3fff << 48), 1.0);
    assert_eq!(quadruple(0, (0xc000 << 48) | (1 << 47)), -3.0);
    assert_eq!(quadruple(0, 0x7fff << 48), f64::INFINITY);
    assert!(quadruple(1, 0x7fff << 48).is_nan());
    assert_eq!(quadruple(0, 0), 0.0);
}

#[test]
fn whatever_is_passed_as_environment_a_message_finds_its_instance() {
    let say = |environment: usize, name: *const c_char| {
        // SAFETY: to C the logger is a variadic function.
        unsafe {
            let call: Variadic = std::mem::transmute(logger as Logger);
            let environment = std::ptr::without_provenance(environment);
            call(environment, name, 0, std::ptr::null(), c"said".as_ptr());
        }
    };
    let (a, b) = (Known::new(Log::default(), "one a"), Known::new(Log::default(), "one b"));
    b.is_of(0x1230);
    let gone = {
        let gone = Known::new(Log::default(), "one gone");
        std::ptr::from_ref::<Log>(&gone).addr()
    };
    for (environment, name) in [
        (1, c"one b".as_ptr()),
        (0x1230, std::ptr::null()),
        (0x1230, std::ptr::without_provenance(8)),
        (0, c"one b".as_ptr()),
        (gone, c"one b".as_ptr()),
    ] {
        say(environment, name);
        assert_eq!((a.take().len(), b.take().len()), (0, 1), "{environment:#x}");
    }
    // These belong to no live instance.
    say(1, c"one c".as_ptr());
    say(gone, std::ptr::null());
    assert_eq!((a.take().len(), b.take().len()), (0, 0));
}
