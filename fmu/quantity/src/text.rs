//! Texts among inputs and outputs.

use std::ffi::CString;

use crate::{Count, Declaration, Declarations, Field, Reader, Start, Variables, Writer};

/// A text of at most `N` octets of UTF-8, for inputs and outputs: plain data without a heap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text<const N: usize> {
    octets: [u8; N],
    length: usize,
}

impl<const N: usize> Text<N> {
    /// The beginning of `text`, as many whole characters as fit, up to its first NUL.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let text = text.split('\0').next().unwrap_or_default();
        let mut length = text.len().min(N);
        while !text.is_char_boundary(length) {
            length -= 1;
        }
        let mut octets = [0; N];
        octets.iter_mut().zip(text.bytes().take(length)).for_each(|(own, octet)| *own = octet);
        Self { octets, length }
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(self.octets()).unwrap_or_default()
    }

    fn octets(&self) -> &[u8] {
        self.octets.get(..self.length).unwrap_or_default()
    }
}

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self::new("")
    }
}

impl<const N: usize> From<&str> for Text<N> {
    fn from(text: &str) -> Self {
        Self::new(text)
    }
}

impl<const N: usize> Variables for Text<N> {
    const COUNT: Count = Count { strings: 1, ..Count::NONE };

    fn declare(&self, at: &Field, into: &mut Declarations) {
        let start = Start::String(self.as_str().to_owned());
        into.push(Declaration { field: at.clone(), start });
    }

    fn load(from: &mut Reader<'_>) -> Self {
        let Some((first, rest)) = from.strings.split_first() else { return Self::default() };
        from.strings = rest;
        Self::new(&first.to_string_lossy())
    }

    /// Allocates only if the text differs from the one before.
    fn store(&self, into: &mut Writer<'_>) {
        let Some((text, rest)) = std::mem::take(&mut into.strings).split_first_mut() else {
            return;
        };
        if text.as_bytes() != self.octets() {
            *text = CString::new(self.octets()).unwrap_or_default();
        }
        into.strings = rest;
    }

    fn zip_reals(&mut self, _: &Self, _: &mut impl FnMut(&mut f64, f64)) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_ends_with_a_whole_character() {
        assert_eq!(Text::<4>::new("abcdef").as_str(), "abcd");
        assert_eq!(Text::<4>::new("abcü").as_str(), "abc");
        assert_eq!(Text::<5>::new("abcü").as_str(), "abcü");
        assert_eq!(Text::<4>::new("a\0b").as_str(), "a");
        assert_eq!(Text::<0>::new("a").as_str(), "");
    }
}
