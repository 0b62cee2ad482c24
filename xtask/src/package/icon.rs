//! `model.png`, which importers show in their diagrams, drawn from the component's SVG file.

use anyhow::{Context, Result};
use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{Options, Tree},
};

/// Width and height, px.
const SIZE: u16 = 256;

/// Draws a square SVG.
pub(crate) fn png(svg: &str) -> Result<Vec<u8>> {
    let tree = Tree::from_str(svg, &Options::default())?;
    let side = u32::from(SIZE);
    let mut pixmap = Pixmap::new(side, side).context("no memory for the icon")?;
    let size = tree.size();
    let scale = f32::from(SIZE) / size.width().max(size.height());
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixmap.as_mut());
    pixmap.encode_png().context("the icon cannot be encoded")
}
