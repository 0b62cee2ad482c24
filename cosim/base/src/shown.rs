//! Makes third-party text safe for a terminal: names in files, messages of FMUs, errors about both.
//!
//! A terminal obeys what is printed to it: control sequences move the cursor, set the title, or
//! answer as if the user had typed. Everything that `cosim` prints therefore passes through one of
//! these functions; results files and logs keep the original text.

use std::borrow::Cow;
use std::io::{self, Write};

/// Names are aligned up to this width; a longer one only shifts its own line.
const MAX_WIDTH: usize = 80;

/// Escapes control characters (except line feeds and tabs) and characters that change the writing
/// direction, as `\u001b`: JSON remains JSON.
pub fn visible(text: &str) -> Cow<'_, str> {
    escaped(text, |c| !matches!(c, '\n' | '\t') && is_control(c))
}

/// The same for a text that must not start lines of its own.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_control)
}

/// The same with all lines except the first indented, so that none can be mistaken for one of ours.
pub fn set_in(text: &str) -> String {
    visible(text).replace('\n', "\n        ")
}

/// The width of a column for such texts.
pub fn width<'a>(texts: impl IntoIterator<Item = &'a str>) -> usize {
    texts.into_iter().map(|text| text.chars().count()).max().unwrap_or(0).min(MAX_WIDTH)
}

fn escaped(text: &str, unwanted: impl Fn(char) -> bool + Copy) -> Cow<'_, str> {
    if !text.contains(unwanted) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '\n' if unwanted(c) => shown.push_str("\\n"),
            '\t' if unwanted(c) => shown.push_str("\\t"),
            _ if unwanted(c) => shown.push_str(&format!("\\u{:04x}", u32::from(c))),
            _ => shown.push(c),
        }
    }
    shown.into()
}

fn is_control(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A writer to a terminal, which makes everything written to it [`visible`].
pub struct Terminal<W> {
    inner: W,
    /// The first bytes of an incomplete character.
    begun: Vec<u8>,
}

impl<W: Write> Terminal<W> {
    /// Around `inner`.
    pub fn new(inner: W) -> Self {
        Self { inner, begun: Vec::new() }
    }
}

impl<W: Write> Write for Terminal<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut all = std::mem::take(&mut self.begun);
        all.extend_from_slice(bytes);
        let mut text = String::new();
        for chunk in all.utf8_chunks() {
            text.push_str(chunk.valid());
            let rest = chunk.invalid();
            let cut = all.ends_with(rest) && rest.len() < 4;
            match std::str::from_utf8(rest) {
                Err(why) if cut && why.error_len().is_none() => self.begun = rest.to_vec(),
                Err(_) => text.push(char::REPLACEMENT_CHARACTER),
                Ok(_) => (),
            }
        }
        self.inner.write_all(visible(&text).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Passes on what a process prints, until it prints no more; with `visibly`, as by a [`Terminal`].
pub fn relay(
    mut from: impl io::Read + Send + 'static,
    to: impl Write + Send + 'static,
    visibly: bool,
) -> std::thread::JoinHandle<()> {
    std::thread::spawn(move || {
        let mut to: Box<dyn Write> =
            if visibly { Box::new(Terminal::new(to)) } else { Box::new(to) };
        let mut piece = [0; 4096];
        while let Ok(count @ 1..) = from.read(&mut piece) {
            // If the output is closed, there is no channel left to report it; the child must not
            // wait for that.
            drop(to.write_all(&piece[..count]).and_then(|()| to.flush()));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_shown() {
        let hostile = "a\x1b]0;title\x07\r\u{9b}2J\u{202e}b\n\tc\u{7f}";
        let shown = "a\\u001b]0;title\\u0007\\u000d\\u009b2J\\u202eb\n\tc\\u007f";
        assert_eq!(visible(hostile), shown);
        assert_eq!(one_line(hostile), shown.replace('\n', "\\n").replace('\t', "\\t"));
        assert!(matches!(visible("Gerät µ √2"), Cow::Borrowed("Gerät µ √2")));
        assert_eq!(set_in("a\nerror: b"), "a\n        error: b");
    }

    #[test]
    fn a_character_may_come_in_parts() {
        for cut in 0..="ä\u{9b}1\u{1f600}".len() {
            let mut terminal = Terminal::new(Vec::new());
            let (a, b) = "ä\u{9b}1\u{1f600}".as_bytes().split_at(cut);
            terminal.write_all(a).and_then(|()| terminal.write_all(b)).unwrap();
            assert_eq!(terminal.inner, "ä\\u009b1\u{1f600}".as_bytes(), "{cut}");
        }
        let mut terminal = Terminal::new(Vec::new());
        terminal.write_all(b"a\xff\x9bb").unwrap();
        assert_eq!(String::from_utf8(terminal.inner).unwrap(), "a\u{fffd}\u{fffd}b");
    }
}
