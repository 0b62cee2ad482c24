"""Sphinx's configuration; `cargo xtask book` prepares the pages and calls it."""

project = "RexROV and cosim"
extensions = ["myst_parser"]
myst_heading_anchors = 4
root_doc = "docs/index"
smartquotes = False  # options begin with two hyphens

html_theme = "furo"
html_title = project
html_copy_source = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["book.css"]
pygments_style = "friendly"
pygments_dark_style = "monokai"
