//! The pages of the book: `docs/index.md` and every Markdown file that can be reached by links,
//! with the files that they link or show. A broken link is an error.

use crate::paths;
use anyhow::{Context, Result, bail};
use pulldown_cmark::{Event, Options, Parser, Tag};
use std::{
    collections::{BTreeSet, VecDeque},
    fs,
    ops::Range,
    path::{Component, Path, PathBuf},
};

/// The page that all others are reached from.
pub(super) const FIRST: &str = "docs/index.md";

/// The folder of pictures that are made by the commands of their pages.
const PICTURES: &str = "docs/pictures";

/// A Markdown file.
pub(crate) struct Page {
    /// Its path below the workspace root.
    pub(crate) path: PathBuf,
    pub(crate) text: String,
}

/// The parts of the book.
pub(crate) struct Pages {
    /// The pages in the order in which links reach them.
    pub(crate) pages: Vec<Page>,
    /// Paths, below the workspace root, of the other files that are linked or shown.
    pub(crate) files: BTreeSet<PathBuf>,
}

impl Pages {
    /// Follows all links from the first page on.
    pub(crate) fn reached() -> Result<Self> {
        let mut queue = VecDeque::from([PathBuf::from(FIRST)]);
        let mut met = BTreeSet::from([PathBuf::from(FIRST)]);
        let (mut pages, mut files, mut broken) = (Vec::new(), BTreeSet::new(), Vec::new());
        while let Some(path) = queue.pop_front() {
            let text = fs::read_to_string(paths::root().join(&path))
                .with_context(|| path.display().to_string())?;
            for (line, link) in links(&text) {
                let target = beside(&path, &link);
                if target.starts_with(PICTURES) {
                    // A new one exists once the commands of its page have run.
                    files.insert(target);
                } else if !paths::root().join(&target).is_file() {
                    let (page, target) = (path.display(), target.display());
                    broken.push(format!("{page}:{line}: the link to {target} leads to no file"));
                } else if target.extension().is_none_or(|ending| ending != "md") {
                    files.insert(target);
                } else if met.insert(target.clone()) {
                    queue.push_back(target);
                }
            }
            pages.push(Page { path, text });
        }
        match broken.is_empty() {
            true => Ok(Self { pages, files }),
            false => bail!("{}", broken.join("\n")),
        }
    }
}

/// A page's parts with their positions in the text.
pub(crate) fn events(text: &str) -> impl Iterator<Item = (Event<'_>, Range<usize>)> {
    Parser::new_ext(text, Options::ENABLE_TABLES | Options::ENABLE_MATH).into_offset_iter()
}

/// The line of a position in a text, counted from one.
pub(crate) fn line(text: &str, place: usize) -> usize {
    1 + text[..place].matches('\n').count()
}

/// The pictures of a page that its own commands make.
pub(super) fn pictures(page: &Page) -> Vec<PathBuf> {
    let places = links(&page.text).into_iter().map(|(_, link)| beside(&page.path, &link));
    places.filter(|place| place.starts_with(PICTURES)).collect()
}

/// Lines and targets of the links and pictures that refer to files, without the part after `#`.
fn links(text: &str) -> Vec<(usize, String)> {
    let target = |(event, range): (Event<'_>, Range<usize>)| match event {
        Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
            let (path, _) = dest_url.split_once('#').unwrap_or((&dest_url, ""));
            let elsewhere = path.is_empty() || dest_url.contains("://");
            (!elsewhere).then(|| (line(text, range.start), path.to_owned()))
        }
        _ => None,
    };
    events(text).filter_map(target).collect()
}

/// The target of a link on `page`.
fn beside(page: &Path, link: &str) -> PathBuf {
    let mut place = page.parent().unwrap_or(Path::new("")).to_owned();
    for part in Path::new(link).components() {
        match part {
            Component::ParentDir => {
                place.pop();
            }
            Component::CurDir => (),
            other => place.push(other),
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_files_are_found_with_their_lines() {
        let text = "[a](x.md#top)\n\n![b](p/q.svg) [c](#here) [d](https://e.org/f.md)\n`[g](h.md)`";
        assert_eq!(links(text), [(1, "x.md".to_owned()), (3, "p/q.svg".to_owned())]);
    }

    #[test]
    fn links_are_followed_from_the_folder_of_their_page() {
        assert_eq!(beside(Path::new("docs/a.md"), "../b/./c.md"), Path::new("b/c.md"));
    }

    #[test]
    fn every_link_of_the_book_leads_to_a_file() {
        let reached = Pages::reached().unwrap();
        assert!(reached.pages.iter().any(|page| page.path == Path::new("README.md")));
    }
}
