//! The pages as Sphinx reads them: equations as MathML, generated parts inserted, and a table of
//! contents from the lists of links in `docs/index.md`.

use super::{
    generated,
    pages::{FIRST, Page, Pages, events},
};
use crate::{package::page::mathml, paths};
use anyhow::{Context, Result};
use pulldown_cmark::{Event, HeadingLevel, Tag, TagEnd};
use pulldown_latex::config::DisplayMode;
use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

/// Files that the book needs but that no page links.
const SUPPORT: [&str; 2] = ["docs/conf.py", "docs/static/book.css"];

/// Writes pages and files to a folder, at their paths in the repository.
pub(super) fn write(pages: &Pages, folder: &Path) -> Result<()> {
    let _ = fs::remove_dir_all(folder);
    let support = SUPPORT.map(PathBuf::from);
    for file in pages.files.iter().chain(&support) {
        let bytes = fs::read(paths::root().join(file));
        put(&folder.join(file), &bytes.with_context(|| file.display().to_string())?)?;
    }
    for page in &pages.pages {
        let place = || page.path.display().to_string();
        let mut text = with_equations(&generated::complete(page)?).with_context(place)?;
        if page.path == Path::new(FIRST) {
            text.push_str(&contents(page));
        }
        put(&folder.join(&page.path), text.as_bytes())?;
    }
    Ok(())
}

fn put(path: &Path, bytes: &[u8]) -> Result<()> {
    let place = || path.display().to_string();
    fs::create_dir_all(path.parent().unwrap_or(path)).with_context(place)?;
    fs::write(path, bytes).with_context(place)
}

/// LaTeX becomes MathML, which browsers display directly.
fn with_equations(text: &str) -> Result<String> {
    let (mut whole, mut copied) = (String::new(), 0);
    for (event, range) in events(text) {
        let equation = match &event {
            Event::InlineMath(latex) => mathml(latex, DisplayMode::Inline)?,
            Event::DisplayMath(latex) => mathml(latex, DisplayMode::Block)?,
            _ => continue,
        };
        whole.push_str(&text[copied..range.start]);
        // One line, and no bars that would end a table cell.
        whole.push_str(&equation.replace('\n', " ").replace('|', "&#124;"));
        copied = range.end;
    }
    whole.push_str(&text[copied..]);
    Ok(whole)
}

/// A table of contents for each section of the first page that lists links.
fn contents(first: &Page) -> String {
    let (mut sections, mut in_heading) = (Vec::<(String, Vec<String>)>::new(), false);
    let mut in_list = false;
    for (event, _) in events(&first.text) {
        match event {
            Event::Start(Tag::Heading { level: HeadingLevel::H2, .. }) => {
                in_heading = true;
                sections.push((String::new(), Vec::new()));
            }
            Event::End(TagEnd::Heading(_)) => in_heading = false,
            Event::Start(Tag::List(_)) => in_list = true,
            Event::End(TagEnd::List(_)) => in_list = false,
            Event::Text(text) if in_heading => {
                if let Some((title, _)) = sections.last_mut() {
                    title.push_str(&text);
                }
            }
            Event::Start(Tag::Link { dest_url, .. }) if in_list => {
                if let (Some((_, links)), Some(page)) =
                    (sections.last_mut(), dest_url.strip_suffix(".md"))
                {
                    links.push(page.to_owned());
                }
            }
            _ => (),
        }
    }
    let mut text = String::new();
    for (title, links) in sections.iter().filter(|(_, links)| !links.is_empty()) {
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n{}\n```\n",
            links.join("\n")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_become_one_line_without_bars() {
        let text = with_equations("a $|x|$ and\n\n$$\\frac{a}\n{b}$$\n\n`$no$`").unwrap();
        assert_eq!(text.matches("<math").count(), 2);
        assert!(!text.contains('|') && text.ends_with("`$no$`"), "{text}");
        assert!(with_equations("$\\nosuchcommand$").is_err());
    }

    #[test]
    fn each_list_of_links_is_a_section_of_the_contents() {
        let text = "# B\n\n## Start\n\n[not](this.md)\n\n- [a](a.md)\n- [b](../b.md)\n\n## None\n";
        let page = Page { path: FIRST.into(), text: text.into() };
        let wanted = "\n```{toctree}\n:hidden:\n:caption: Start\n\na\n../b\n```\n";
        assert_eq!(contents(&page), wanted);
    }
}
