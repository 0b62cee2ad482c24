//! The fenced blocks of a Markdown text.

use crate::book::pages::{events, line};
use pulldown_cmark::{CodeBlockKind, Event, Tag, TagEnd};

/// A fenced block.
pub(super) struct Block {
    /// The line it begins at, counted from one.
    pub(super) line: usize,
    /// The language, and the rest of the line after the fence.
    words: Vec<String>,
    pub(super) text: String,
}

impl Block {
    pub(super) fn language(&self) -> &str {
        self.words.first().map_or("", String::as_str)
    }

    /// Whether `word` follows the language.
    pub(super) fn says(&self, word: &str) -> bool {
        self.words.iter().skip(1).any(|said| said == word)
    }

    /// The value of `key=value` after the language.
    pub(super) fn value(&self, key: &str) -> Option<&str> {
        self.words.iter().find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
    }
}

/// All fenced blocks, in their order.
pub(super) fn blocks(markdown: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut inside = false;
    for (event, range) in events(markdown) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) => {
                inside = true;
                blocks.push(Block {
                    line: line(markdown, range.start),
                    words: info.split_whitespace().map(str::to_owned).collect(),
                    text: String::new(),
                });
            }
            Event::End(TagEnd::CodeBlock) => inside = false,
            Event::Text(text) if inside => {
                if let Some(block) = blocks.last_mut() {
                    block.text.push_str(&text);
                }
            }
            _ => (),
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_have_line_language_and_words() {
        let found = blocks(
            "a\n\n```sh syntax\nx \\\n y\n```\n\n    not this\n\n```xml file=a.ssd\n<a/>\n```\n",
        );
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].line, found[0].language()), (3, "sh"));
        assert!(found[0].says("syntax") && found[0].text == "x \\\n y\n");
        assert_eq!(found[1].value("file"), Some("a.ssd"));
    }
}
