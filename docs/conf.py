"""Configuration of the documentation site: Sphinx, pages in Markdown (MyST), equations as MathML.

Nothing is loaded from the network, neither while the site is built nor while it is read.
"""

import importlib.metadata
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "helmbench"
author = "the helmbench authors"
copyright = author
release = importlib.metadata.version("helmbench")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_gallery.gen_gallery", "docstrings", "mathml"]
exclude_patterns = [
    "_build",
    "gallery",
    *(f"generated/indices-{part}.md" for part in ("example", "accuracies", "priors")),
]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
default_role = "code"

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "generated/gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("matplotlib", "figures.last_figure"),
    "ignore_repr_types": "matplotlib",
    "run_stale_examples": True,  # the package may have changed where an example has not
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
}

autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = "helmbench"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["wide.css"]


def write_generated_pages(app) -> None:
    """Write the pages of tables and equations from what the installed package holds."""
    import generate

    generate.write(HERE / "generated")


def setup(app) -> None:
    app.connect("builder-inited", write_generated_pages)
