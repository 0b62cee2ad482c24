//! `printf` formats (C11, 7.21.6.1) from untrusted FMUs: all conversions, flags, widths, precisions
//! and lengths, without ever reading more arguments than the format requires.
//!
//! Numbers are formatted by the C library with a conversion that is assembled here. Strings are
//! read only where memory is readable, `%n` writes nothing, and the text is bounded.

use std::ffi::{CString, c_char};

use super::memory;
use super::variadic::Arguments;

/// Longest message, in bytes.
pub(super) const MAX_MESSAGE: usize = 16 << 10;
/// Largest width and precision.
const MAX_FIELD: usize = 1000;
/// Conversions of one format.
const MAX_CONVERSIONS: usize = 64;

/// Formats the arguments.
pub(super) fn render(format: &[u8], arguments: &mut Arguments) -> String {
    let mut text = Vec::with_capacity(format.len());
    let mut rest = format;
    let mut conversions = 0;
    while let Some(at) = rest.iter().position(|&b| b == b'%') {
        text.extend_from_slice(&rest[..at]);
        rest = &rest[at..];
        conversions += 1;
        let parsed = if conversions <= MAX_CONVERSIONS { Conversion::parse(rest) } else { None };
        // After an unknown conversion, the remaining arguments cannot be matched any more.
        let Some((mut conversion, length)) = parsed else { break };
        conversion.show(arguments, &mut text);
        rest = &rest[length..];
        if text.len() > MAX_MESSAGE {
            break;
        }
    }
    text.extend_from_slice(rest);
    if text.len() > MAX_MESSAGE {
        text.truncate(MAX_MESSAGE);
        text.extend_from_slice(" ... (cut)".as_bytes());
    }
    String::from_utf8_lossy(&text).into_owned()
}

/// `%[flags][width][.precision][length]kind`
#[derive(Debug, Default)]
struct Conversion {
    flags: Vec<u8>,
    width: Field,
    precision: Field,
    length: Length,
    kind: u8,
}

#[derive(Debug, Default, Clone, Copy)]
enum Field {
    #[default]
    None,
    Number(usize),
    /// `*`: an argument.
    Argument,
}

/// The length of an integer in bits, and its meaning for other conversions.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
enum Length {
    Char,
    Short,
    #[default]
    Int,
    /// `l`: 64 bits; wide characters.
    Long,
    /// `L`: long double.
    LongDouble,
}

impl Conversion {
    /// The conversion at the start of `format`, and its length.
    fn parse(format: &[u8]) -> Option<(Self, usize)> {
        let mut at = 1;
        let mut conversion = Self::default();
        while let Some(&flag @ (b'-' | b'+' | b' ' | b'#' | b'0' | b'\'')) = format.get(at) {
            // Digit grouping belongs to a locale; there is none here.
            if flag != b'\'' && !conversion.flags.contains(&flag) {
                conversion.flags.push(flag);
            }
            at += 1;
        }
        conversion.width = field(format, &mut at);
        if format.get(at) == Some(&b'.') {
            at += 1;
            conversion.precision = match field(format, &mut at) {
                Field::None => Field::Number(0),
                given => given,
            };
        }
        conversion.length = length(format, &mut at);
        conversion.kind = *format.get(at)?;
        let known = b"diouxXcCsSpeEfFgGaAnm%".contains(&conversion.kind);
        known.then_some((conversion, at + 1))
    }

    fn show(&mut self, arguments: &mut Arguments, text: &mut Vec<u8>) {
        self.take_fields(arguments);
        match self.kind {
            b'%' => text.push(b'%'),
            b'd' | b'i' => self.integer(signed(arguments.word(), self.length), text),
            b'o' | b'u' | b'x' | b'X' => {
                self.integer(unsigned(arguments.word(), self.length) as i64, text);
            }
            b'e' | b'E' | b'f' | b'F' | b'g' | b'G' | b'a' | b'A' => {
                let value = match self.length {
                    Length::LongDouble => arguments.long_double(),
                    _ => arguments.double(),
                };
                self.number("", text, |to, size, format| {
                    // SAFETY: `to` has `size` bytes; the format takes one double.
                    unsafe { libc::snprintf(to, size, format, value) }
                });
            }
            b'c' | b'C' => {
                let code = arguments.word() as u32;
                let wide = self.length == Length::Long || self.kind == b'C';
                let code = if wide { code } else { code & 0xff };
                let mut buffer = [0; 4];
                match char::from_u32(code) {
                    Some(c) if wide || c.is_ascii() => {
                        self.pad(c.encode_utf8(&mut buffer).as_bytes(), text);
                    }
                    _ => self.pad(&[code as u8], text),
                }
            }
            b's' | b'S' => {
                let address = arguments.word() as usize;
                self.string(address, text);
            }
            b'p' => match arguments.word() {
                0 => self.pad(b"(nil)", text),
                address => self.pad(format!("{address:#x}").as_bytes(), text),
            },
            b'n' => {
                arguments.word();
                text.extend_from_slice(b"(%n refused)");
            }
            // By now, the error number of the C library belongs to another call.
            _ => text.extend_from_slice(b"%m"),
        }
    }

    /// Replaces each `*` by its argument (C11, 7.21.6.1, 5).
    fn take_fields(&mut self, arguments: &mut Arguments) {
        if let Field::Argument = self.width {
            let width = arguments.word() as i32;
            if width < 0 {
                self.flags.push(b'-');
            }
            self.width = Field::Number((width.unsigned_abs() as usize).min(MAX_FIELD));
        }
        if let Field::Argument = self.precision {
            let precision = arguments.word() as i32;
            self.precision = match usize::try_from(precision) {
                Ok(precision) => Field::Number(precision.min(MAX_FIELD)),
                Err(_) => Field::None,
            };
        }
    }

    fn integer(&self, value: i64, text: &mut Vec<u8>) {
        self.number("ll", text, |to, size, format| {
            // SAFETY: `to` has `size` bytes; the format takes one long long.
            unsafe { libc::snprintf(to, size, format, value) }
        });
    }

    /// Formats a number with the C library.
    fn number(
        &self,
        length: &str,
        text: &mut Vec<u8>,
        print: impl FnOnce(*mut c_char, usize, *const c_char) -> i32,
    ) {
        let mut format = String::from("%");
        format.extend(self.flags.iter().map(|&flag| char::from(flag)));
        if let Field::Number(width) = self.width {
            format.push_str(&width.to_string());
        }
        if let Field::Number(precision) = self.precision {
            format.push_str(&format!(".{precision}"));
        }
        format.push_str(length);
        format.push(char::from(self.kind));
        let Ok(format) = CString::new(format) else { return };
        // 309 digits before the decimal point, MAX_FIELD after it.
        let mut buffer = [0_u8; 2 * MAX_FIELD];
        let written = print(buffer.as_mut_ptr().cast(), buffer.len(), format.as_ptr());
        let written = usize::try_from(written).unwrap_or(0).min(buffer.len() - 1);
        text.extend_from_slice(&buffer[..written]);
    }

    fn string(&self, address: usize, text: &mut Vec<u8>) {
        let limit = match self.precision {
            Field::Number(precision) => precision,
            _ => MAX_MESSAGE,
        };
        if address == 0 {
            return self.pad(b"(null)", text);
        }
        if self.length == Length::Long || self.kind == b'S' {
            return self.pad(b"(wide characters)", text);
        }
        match memory::string(address, limit) {
            Some(string) => self.pad(&string, text),
            None => text.extend_from_slice(super::UNREADABLE),
        }
    }

    fn pad(&self, string: &[u8], text: &mut Vec<u8>) {
        let width = if let Field::Number(width) = self.width { width } else { 0 };
        let blanks = width.saturating_sub(string.len());
        let left = self.flags.contains(&b'-');
        if !left {
            text.resize(text.len() + blanks, b' ');
        }
        text.extend_from_slice(string);
        if left {
            text.resize(text.len() + blanks, b' ');
        }
    }
}

fn field(format: &[u8], at: &mut usize) -> Field {
    if format.get(*at) == Some(&b'*') {
        *at += 1;
        return Field::Argument;
    }
    let mut number = None;
    while let Some(digit) = format.get(*at).filter(|b| b.is_ascii_digit()) {
        let value = number.unwrap_or(0) * 10 + usize::from(digit - b'0');
        number = Some(value.min(MAX_FIELD));
        *at += 1;
    }
    number.map_or(Field::None, Field::Number)
}

fn length(format: &[u8], at: &mut usize) -> Length {
    let rest = &format[*at..];
    let (length, bytes) = match rest {
        [b'h', b'h', ..] => (Length::Char, 2),
        [b'h', ..] => (Length::Short, 1),
        [b'l', b'l', ..] => (Length::Long, 2),
        [b'l' | b'q' | b'j' | b'z' | b't', ..] => (Length::Long, 1),
        [b'L', ..] => (Length::LongDouble, 1),
        _ => (Length::Int, 0),
    };
    *at += bytes;
    length
}

fn signed(word: u64, length: Length) -> i64 {
    match length {
        Length::Char => i64::from(word as i8),
        Length::Short => i64::from(word as i16),
        Length::Int => i64::from(word as i32),
        Length::Long | Length::LongDouble => word as i64,
    }
}

fn unsigned(word: u64, length: Length) -> u64 {
    match length {
        Length::Char => u64::from(word as u8),
        Length::Short => u64::from(word as u16),
        Length::Int => u64::from(word as u32),
        Length::Long | Length::LongDouble => word,
    }
}
