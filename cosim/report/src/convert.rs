//! Figures as PNG and PDF, rendered from their SVG with the fonts of this machine.

use std::sync::Arc;

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};
use svg2pdf::{ConversionOptions, PageOptions};

use cosim_base::error::{Code, Error, Result};

/// Pixels of a PNG for each unit of the SVG, so that it is sharp on today's screens and in print.
const SCALE: f32 = 2.0;

/// The picture on white, in the format PNG.
pub(super) fn png(svg: &str) -> Result<Vec<u8>> {
    let tree = tree(svg)?;
    let size = tree.size().to_int_size().scale_by(SCALE);
    let pixmap = size.and_then(|size| Pixmap::new(size.width(), size.height()));
    let mut pixmap = pixmap.ok_or_else(|| failed("it is too large for a picture of pixels"))?;
    pixmap.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(failed)
}

/// A page of the picture's size, in the format PDF.
pub(super) fn pdf(svg: &str) -> Result<Vec<u8>> {
    svg2pdf::to_pdf(&tree(svg)?, ConversionOptions::default(), PageOptions::default())
        .map_err(failed)
}

fn tree(svg: &str) -> Result<Tree> {
    let mut fonts = Database::new();
    fonts.load_system_fonts();
    if fonts.is_empty() {
        return Err(failed("no font is installed")
            .help("install one, for example fonts-dejavu-core, or write a .svg"));
    }
    let plain = ["DejaVu Sans", "Liberation Sans", "Noto Sans", "Arial", "Helvetica"];
    let first = |fonts: &Database| {
        let is_here =
            |name: &&str| fonts.faces().any(|f| f.families.iter().any(|(n, _)| n == name));
        let any = || fonts.faces().next().and_then(|face| face.families.first());
        plain
            .iter()
            .find(|n| is_here(n))
            .map(|n| (*n).to_owned())
            .or_else(|| Some(any()?.0.clone()))
    };
    if let Some(family) = first(&fonts) {
        fonts.set_sans_serif_family(family);
    }
    let options = Options { fontdb: Arc::new(fonts), ..Options::default() };
    Tree::from_str(svg, &options).map_err(failed)
}

fn failed(why: impl std::fmt::Display) -> Error {
    Error::new(Code::Output, "the figure cannot be rendered").why(why)
}
