//! How deep the brackets of a text are nested: for parsers that set no limit themselves.

/// The most levels.
pub const MOST: usize = 64;

/// Whether there are more levels than that, in texts and comments, too.
pub fn is_too_deep(text: &str) -> bool {
    let mut depth = 0_usize;
    text.bytes().any(|byte| {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => (),
        }
        depth > MOST
    })
}
