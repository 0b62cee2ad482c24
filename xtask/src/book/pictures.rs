//! The pictures of the pages, `docs/pictures/`: committed, so that they show wherever the page is
//! read, and made by the page's own commands, so that they show the results of these commands.

use super::pages::{Pages, pictures};
use crate::{examples, paths};
use anyhow::{Context, Result, bail};
use std::fs;

/// Compares each picture with the file of its name that the page's commands wrote, or copies it.
pub(super) fn settle(check: bool) -> Result<()> {
    let mut stale = Vec::new();
    for page in &Pages::reached()?.pages {
        for picture in pictures(page) {
            let name = picture.file_name().unwrap_or_default();
            let made = examples::folder(&page.path).join(name);
            let made = fs::read(&made).with_context(|| {
                let (page, name) = (page.path.display(), name.display());
                format!("{page} shows {name}, but none of its commands writes that")
            })?;
            let committed = paths::root().join(&picture);
            if fs::read(&committed).ok().as_ref() == Some(&made) {
                continue;
            }
            match check {
                true => stale.push(picture.display().to_string()),
                false => {
                    fs::write(&committed, made).with_context(|| committed.display().to_string())?
                }
            }
        }
    }
    if !stale.is_empty() {
        bail!(
            "{} differ from what the commands of their pages make: run `cargo xtask book` and \
             commit the result",
            stale.join(", ")
        );
    }
    Ok(())
}
